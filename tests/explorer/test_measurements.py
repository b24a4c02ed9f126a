"""A measured response is read with the units of the model, and leaves in the copied Python."""

import numpy as np
import pytest

import slipfold as sf
from helpers.explorer_server import diagram
from slipfold.interface.explorer.answering import Answering
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.messages import ExportRequest

TEXT = "Nd [mN],max y,error of max y,min x,sweep\n100,0.2,0.01,,up\n150,,,-0.3,down\n"


def read(explorer, text, model="sliding"):
    with explorer.http() as http:
        asked = {"model": model, "name": "my data.csv", "measurements": text}
        return http.post("/api/measurements", json=asked)


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
def test_measurements_come_in_si_units_by_quantity(explorer, ending):
    answer = read(explorer, TEXT.replace("\n", ending)).json()
    assert answer["vary"] == "Nd"
    assert answer["values"] == pytest.approx([0.1, 0.15])
    assert answer["sweep"] == ["up", "down"]
    assert answer["quantities"] == [
        {"show": "y", "statistic": "max", "measurements": [0.2, None], "errors": [0.01, None]},
        {"show": "x", "statistic": "min", "measurements": [None, -0.3], "errors": [None, None]},
    ]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "my data.csv holds no measurements; give a head such as"),
        (TEXT.replace("mN", "mm"), "the head 'Nd [mm]' has the unit 'mm'; write Nd [N]"),
        (TEXT.replace("0.2", "much"), "line 2 of my data.csv: 'much' under 'max y' is not a"),
        (TEXT.replace("max y", "max z"), "has no output 'z'"),
    ],
)
def test_what_cannot_be_read_is_one_sentence(explorer, text, words):
    answer = read(explorer, text)
    assert answer.status_code == 400
    assert words in answer.text
    assert "\n" not in answer.text


def test_copied_python_draws_the_readings(tmp_path, monkeypatch):
    view = diagram(span=[0, 0.02], show="y")
    asked = {"view": view, "format": "python", "measurements": 'it\'s "mine".csv'}
    (tmp_path / asked["measurements"]).write_text(TEXT)
    answering = Answering(Catalogue())
    text = answering.export(ExportRequest.model_validate(asked), lambda: None).decode()
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(compile(text, "copied.py", "exec"), names)
    own = sf.read_measurement(asked["measurements"], names["model"])
    np.testing.assert_array_equal(names["measured"].measured, own.measured)
    assert "measured, upward" in (tmp_path / "diagram.svg").read_text()


@pytest.mark.parametrize("pins", [[], [{"name": "slower", "parameters": {"Vd": 0.4}}]])
def test_figures_hold_the_measurements_that_the_page_draws(pins):
    view = diagram(span=[0, 0.02], show="y")
    asked = {"view": view, "format": "svg", "measurements": "rig.csv", "measured": TEXT}
    figure = ExportRequest.model_validate({**asked, "pins": pins})
    drawn = Answering(Catalogue()).export(figure, lambda: None).decode()
    assert "measured, upward" in drawn
