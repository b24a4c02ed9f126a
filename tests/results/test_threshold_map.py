"""Maps of thresholds as results: input, printed, exported, saved and read back."""

import csv
import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import slipfold as sf
from helpers.threshold_maps import KINDS, REASON, made_map
from slipfold.computations.thresholds import threshold_map
from slipfold.errors import InputError
from slipfold.models import Parameter, SlidingOscillator
from slipfold.results.result import load
from slipfold.results.thresholds import ThresholdMap


def assert_same(one, other):
    for field in dataclasses.fields(ThresholdMap):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if field.name == "over":
            assert list(a) == list(b)
            assert all(np.array_equal(a[name], b[name]) for name in a)
        elif not isinstance(a, np.ndarray):
            assert a == b, field.name
        elif a.dtype.kind == "c":
            assert np.array_equal(a.real, b.real, equal_nan=True)
            assert np.array_equal(a.imag, b.imag, equal_nan=True)
        else:
            assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), field.name
            assert a.dtype.kind == b.dtype.kind, field.name


def saved(tmp_path, found):
    path = tmp_path / "map.nc"
    found.save(path)
    return path


# -- computed ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def computed():
    over = {"Vd": ["0.4m/s", 0.6, "100cm/s"], "alpha": ["60deg"]}
    seen = []
    found = sf.threshold_map(
        SlidingOscillator(), "Nd", over=over, span=("0", "50mN"), observer=seen.append, f="12.5Hz"
    )
    assert isinstance(seen[-1], sf.Progress)
    assert (seen[-1].done, seen[-1].values["failures"]) == (3, 1)
    return found


def test_text_with_units_is_understood(computed):
    assert isinstance(computed, sf.ThresholdMap)
    assert computed.failures == {"no PD in the span": 1}
    assert computed.over["Vd"].tolist() == [0.4, 0.6, 1.0]
    assert computed.span == (0.0, 0.05)
    assert computed.values[1, 0] == pytest.approx(0.043578911491, abs=1e-11)
    assert computed.provenance.seconds > 0


GOOD = {"Vd": [0.5, 0.6], "alpha": [1.0, 1.1]}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"over": [0.5, 0.6]}, "does not give values by name"),
        ({"over": {"Vd": ["5mm"], "alpha": [1.0]}}, "Vd = '5mm' has the unit 'mm'"),
        ({"over": {"Vd": [0.5]}}, "does not name two parameters"),
        ({"over": {"Vd": [0.5], "alfa": [1.0]}}, "did you mean alpha"),
        ({"span": ("0", "90deg")}, "Nd = '90deg' has the unit 'deg'"),
        ({"span": 0.3}, "is not a pair of numbers"),
        ({"type": "NS"}, "type = 'NS' cannot be mapped"),
        ({"Vd": 0.7}, "Vd is varied, so it cannot be set to 0.7"),
        ({"Nd": 0.7}, "Nd is varied"),
        ({"model": "sliding"}, "is not a model"),
    ],
)
def test_bad_input_is_refused(changes, message):
    given = {"threshold": "Nd", "over": GOOD, "span": (0, 0.9), **changes}
    with pytest.raises(InputError, match=message):
        threshold_map(given.pop("model", SlidingOscillator()), **given)


# -- summary, JSON, spreadsheet ----------------------------------------------------------------


def test_summary():
    (title, count), (heads, lowest, highest), failures = (
        part.splitlines() for part in made_map().summary().split("\n\n")
    )
    assert title == (
        "sliding: first PD in Nd from 0 to 0.9 N over Vd from 0.4 to 1 m/s and "
        "alpha from 0.1 to 1.0472 rad; f = 12.4 Hz"
    )
    assert count == "3 x 2 points, 3 thresholds; whole responses followed: 3"
    assert heads.split() == ["Nd", "Vd", "alpha"]
    assert lowest.split() == ["lowest", "0.03333333333", "1", "1.0472"]
    assert highest.split() == ["highest", "0.3", "0.4", "0.1"]
    assert failures == [
        "No threshold at 2 points: limit: lost contact; first at Vd = 0.4 m/s, "
        f"alpha = 1.0472 rad: {REASON}",
        "No threshold at 1 point: no PD in the span; first at Vd = 0.6 m/s, "
        f"alpha = 1.0472 rad: {REASON}",
    ]


def test_summary_of_nothing_found():
    found = made_map(kinds=np.full((3, 2), "interrupted"))
    title, failures = (part.splitlines() for part in found.summary().split("\n\n"))
    assert title[1].startswith("3 x 2 points, 0 thresholds;")
    assert failures[0].startswith("No threshold at 6 points: interrupted; first at Vd = 0.6 m/s")
    assert failures[1] == "Interrupted: some of the map is missing."


def test_summary_where_nothing_failed():
    found = made_map(kinds=np.full((3, 2), ""))
    assert len(found.summary().split("\n\n")) == 2


def test_html_is_escaped():
    page = made_map()._repr_html_()
    assert "keep Nd &lt; Ns" in page
    assert page.count("<tr>") == 3
    assert page.count("<li>") == 3


def test_repr():
    assert repr(made_map()) == (
        "<ThresholdMap of sliding: PD in Nd over Vd and alpha, 3 x 2 points, 3 thresholds, "
        "2 limit: lost contact, 1 no PD in the span>"
    )


def test_json():
    record = json.loads(json.dumps(made_map().to_json(), allow_nan=False))
    assert record["schema"] == "slipfold.threshold_map/1"
    assert (record["model"], record["parameters"]["f"]) == ("sliding", 12.4)
    assert (record["threshold"], record["type"], record["span"]) == ("Nd", "PD", [0.0, 0.9])
    assert record["over"] == {"Vd": [0.6, 0.4, 1.0], "alpha": [0.1, np.pi / 3]}
    assert record["values"] == [[0.1, None], [0.3, None], [None, 0.1 / 3]]
    assert record["kinds"] == [[kind or None for kind in row] for row in KINDS]
    assert record["reasons"][0] == [None, REASON]
    assert record["failures"] == {"limit: lost contact": 2, "no PD in the span": 1}
    assert record["interrupted"] is False


def test_spreadsheet(tmp_path):
    made_map().to_csv(tmp_path / "map.csv")
    with open(tmp_path / "map.csv", newline="", encoding="utf-8") as file:
        heads, *rows = csv.reader(file)
    assert heads[:5] == ["Vd (m/s)", "alpha (rad)", "Nd (N)", "x", "y"]
    assert heads[-5:] == [
        "multiplier 4 imaginary",
        "residual",
        "no threshold",
        "reason",
        "followed",
    ]
    assert len(rows) == 6
    assert all(len(row) == len(heads) for row in rows)
    assert [float(value) for value in rows[5][:4]] == [1.0, np.pi / 3, 0.1 / 3, 20 / 7]
    assert rows[5][-3:] == ["", "", "0"]
    assert rows[1][:2] == ["0.6", repr(np.pi / 3)]
    assert set(rows[1][2:-3]) == {""}
    assert rows[1][-3:] == ["no PD in the span", REASON, "0"]


# -- the dataset -------------------------------------------------------------------------------


def test_dataset_is_labelled():
    data = made_map().to_xarray()
    assert data.Nd.dims == ("Vd", "alpha")
    assert data.Nd.attrs["units"] == "N"
    assert data.Vd.attrs == {"long_name": "Vd: speed of the plate", "units": "m/s"}
    assert float(data.Nd.sel(Vd=1.0, alpha=np.pi / 3)) == 0.1 / 3
    assert data.states.sel(state="vx").dims == ("Vd", "alpha")
    assert data.multipliers_imag.dims == ("Vd", "alpha", "multiplier")
    assert data.kind.values.tolist() == KINDS
    assert all("long_name" in variable.attrs for variable in data.variables.values())
    assert data.attrs["schema"] == "slipfold.threshold_map/1"


class Awkward(SlidingOscillator):
    """A model with a parameter that is called like a column."""

    name = "awkward"
    parameters = (*SlidingOscillator.parameters, Parameter("kind", 1.0))


def test_a_parameter_called_like_a_column_survives(tmp_path):
    over = {"kind": np.array([1.0, 2.0, 3.0]), "alpha": np.array([0.1, 0.2])}
    found = made_map(model=Awkward(), over=over)
    path = saved(tmp_path, found)
    assert_same(found, load(path, kind=Awkward))
    with pytest.raises(
        InputError, match=r"its model 'awkward' is not a built-in one.*kind=TheClass"
    ):
        load(path)


# -- files -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"kinds": np.full((3, 2), "")},
        {"kinds": np.full((3, 2), "interrupted")},
        {"span": (0.9, 1 / 3)},
    ],
)
def test_made_maps_survive(tmp_path, changes):
    found = made_map(**changes)
    copy = load(saved(tmp_path, found))
    assert_same(found, copy)
    assert copy.to_json() == found.to_json()


anything = st.floats(allow_nan=True, allow_infinity=True)
words = st.text(st.characters(blacklist_categories=["Cs"], blacklist_characters="\0"), max_size=30)


@given(st.data(), st.integers(1, 3), st.integers(1, 3))
@settings(max_examples=12)
def test_any_numbers_survive(tmp_path_factory, data, rows, columns):
    def numbers(*shape):
        return data.draw(arrays(float, shape, elements=anything))

    multipliers = np.empty((rows, columns, 4), complex)
    multipliers.real, multipliers.imag = numbers(rows, columns, 4), numbers(rows, columns, 4)
    kinds, reasons = (
        np.array([[data.draw(words) for _ in range(columns)] for _ in range(rows)])
        for _ in range(2)
    )
    found = dataclasses.replace(
        made_map(),
        over={"Vd": 0.1 + np.arange(rows) / 3, "alpha": np.arange(columns) / 7},
        values=numbers(rows, columns),
        states=numbers(rows, columns, 4),
        multipliers=multipliers,
        residuals=numbers(rows, columns),
        kinds=kinds,
        reasons=reasons.astype(object),
        followed=data.draw(arrays(bool, (rows, columns))),
    )
    path = tmp_path_factory.mktemp("any") / "x.nc"
    found.save(path)
    assert_same(found, load(path))
