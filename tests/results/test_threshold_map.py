"""Maps of thresholds as results: input, printed, exported, saved and read back."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import slipfold as sf
from helpers.locus_diagrams import assert_same
from helpers.threshold_maps import KINDS, REASON, made_map
from slipfold import SlidingOscillator, load

# -- computed ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def computed():
    over = {"Vd": ["0.4m/s", 0.6, "100cm/s"], "alpha": ["60deg"]}
    seen = []
    found = sf.threshold_map(
        SlidingOscillator(),
        "Nd",
        over=over,
        span=("0", "50mN"),
        on_progress=seen.append,
        f="12.5Hz",
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


# -- summary, JSON, spreadsheet ----------------------------------------------------------------


def test_what_is_missing_is_null_in_records():
    record = made_map().to_json()
    assert record["values"] == [[0.1, None], [0.3, None], [None, 0.1 / 3]]
    assert record["kinds"] == [[kind or None for kind in row] for row in KINDS]
    assert record["reasons"][0] == [None, REASON]


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


# -- files -------------------------------------------------------------------------------------


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
