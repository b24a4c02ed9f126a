"""A study is told case by case, and only studies that the page can show are opened."""

from dataclasses import replace

import numpy as np
import pytest

import slipfold as sf
from helpers.command_line import run
from slipfold import InputError
from slipfold.interface.explorer.curves import study_view
from slipfold.studies.plan import Rows

STUDY = {
    "model": "sliding",
    "parameters": {"f": 12.5},
    "compute": {"what": "simulation", "periods": 1},
    "cases": {"grid": {"alpha": ["30deg", "60deg"], "Nd": [0.01, 0.02, 0.03]}},
}


@pytest.fixture(scope="module")
def study():
    return sf.study(STUDY)


def test_a_study_is_reported_case_by_case_and_nothing_of_those_that_failed(study):
    reasons = study.reasons.copy()
    reasons[4] = "it failed"
    told = study_view(replace(study, reasons=reasons), "sliding")
    alpha, load = told["parameters"]
    assert (alpha["label"], alpha["unit"], load["unit"]) == ("α", "rad", "N")
    for number in range(6):
        given = {"alpha": alpha["values"][number], "Nd": load["values"][number]}
        assert given == study.case(number)
    assert told["reasons"] == ["", "", "", "", "it failed", ""]
    for item in told["quantities"]:
        own = study.values[item["name"]]
        assert item["values"][4] is None
        if not item["isText"]:
            kept = [np.nan if value is None else value for value in item["values"]]
            np.testing.assert_array_equal(np.delete(kept, 4), np.delete(own.astype(float), 4))
    assert (told["vary"], told["span"]) == (None, None)


def test_a_study_too_large_for_a_page_is_refused_in_a_sentence(study):
    many = Rows(("Nd",), np.linspace(0, 0.1, 20_001)[:, None])
    large = replace(study, cases=many, reasons=np.full(20_001, "", object))
    with pytest.raises(InputError, match="the study has 20001 cases and the page shows 20000"):
        study_view(large, "sliding")


def test_a_result_that_is_no_study_is_not_opened(tmp_path):
    file = tmp_path / "motion.nc"
    sf.simulate(sf.SlidingOscillator(), 1).save(file)
    result = run("explore", str(file), "--no-browser")
    assert result.exit_code == 2
    assert f"{file} holds a Simulation, which is of one case; give one of slipfold" in result.stderr


def test_there_is_no_study_unless_one_was_opened(explorer):
    with explorer.http() as http:
        assert http.get("/api/study").json() is None
