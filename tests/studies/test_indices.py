"""Sobol's indices of whatever a study finds, amplitudes among it."""

import numpy as np
import pytest

import slipfold as sf
from slipfold import InputError

LINEAR = {
    "model": "duffing",
    "parameters": {"W": 0.8, "F": 0.3, "d": 1.0, "k": 1.0, "g": 0.0},
    "compute": {"what": "simulation", "periods": 24},
    "cases": {
        "sample": "saltelli",
        "count": 32,
        "distributions": {
            "F": "normal 1%",
            "d": "normal 1%",
            "k": "normal 0.5%",
            "g": "normal 1e-9",
        },
    },
}
"""An oscillator whose amplitude F / sqrt((k - W^2)^2 + (d W)^2) is known."""


@pytest.fixture(scope="module")
def found():
    return sf.study(LINEAR)


def test_indices_of_an_amplitude_are_those_of_its_formula(found):
    assert len(found) == 32 * 6
    force, damping, stiffness, _ = found.cases.rows.T
    amplitude = force / np.hypot(stiffness - 0.8**2, 0.8 * damping)
    assert found.values["max_q"] == pytest.approx(amplitude, rel=1e-5)
    # Variances of what is linear add up: relative slopes by relative deviations.
    rest, drag = 1 - 0.8**2, 0.8
    slopes = np.array([1.0, -(drag**2), -rest]) / [1, rest**2 + drag**2, rest**2 + drag**2]
    shares = (slopes * [0.01, 0.01, 0.005]) ** 2
    shares /= shares.sum()
    told = found.indices("max_q")
    assert told.names == ("F", "d", "k", "g")
    assert told.total[:3] == pytest.approx(shares, abs=0.1)
    assert told.total[3] == pytest.approx(0.0, abs=1e-6)
    either = found.indices(np.maximum(-found.values["min_q"], found.values["max_q"]))
    assert either.total == pytest.approx(told.total, abs=1e-3)


def test_indices_that_cannot_be_computed_say_why(found):
    with pytest.raises(InputError, match=r"has no number 'reason'; .*it has settled, period"):
        found.indices("reason")
    with pytest.raises(InputError, match="time is the same in all cases"):
        found.indices("time")
    with pytest.raises(InputError, match=r"duration is missing in 192 of 192 cases$"):
        found.indices("duration")
    cases = {"list": [{"F": 0.3}]}
    compute = {"what": "simulation", "periods": 1}
    with pytest.raises(InputError, match='not drawn for indices; give cases with sample = "sal'):
        sf.study({**LINEAR, "compute": compute, "cases": cases}).indices("max_q")
    cases = {**LINEAR["cases"], "count": 4, "distributions": {"W": "normal 1:-5:5"}}
    lost = sf.study({**LINEAR, "compute": compute, "cases": cases})
    (said,) = (line for line in lost.summary().splitlines() if "fractions of a variance" in line)
    assert said.startswith("no indices of time, last_q, last_v, min_q, max_q, ")
    assert f"the number is missing in {len(lost.failures)} of 12 cases; first: " in said
    assert len(lost.failures) > 0
    for count, why in [(3, "is not a power of 2"), (1, "is too few for the errors of indices")]:
        with pytest.raises(InputError, match=rf"cases\.count = {count} {why}"):
            sf.study({**LINEAR, "cases": {**LINEAR["cases"], "count": count}})


@pytest.mark.parametrize(
    ("quantity", "what"),
    [
        (1.0, r"shape \(\)"),
        ([1.0], r"shape \(1,\)"),
        (np.zeros((2, 192)), r"shape \(2, 192\)"),
        (["one"] * 192, "words or the like"),
        ([[1.0], [1.0, 2.0]], "words or the like"),
    ],
)
def test_what_is_no_number_a_case_is_refused(found, quantity, what):
    with pytest.raises(InputError, match=f"of {what}; give a number for each of the 192 cases"):
        found.indices(quantity)
