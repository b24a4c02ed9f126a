"""Motions are integrated in scaled states: no unit of length is too small or too large."""

import numpy as np
import pytest

from slipfold import System
from slipfold.flow.flow import flow_of

START = np.array([[0.3, -0.8], [1.1, 0.2], [-0.4, 0.9]])
PHASES = np.zeros(3), np.full(3, 1.7)


def duffing(unit: float) -> System:
    """Duffing's oscillator with its length in a unit of so many meters; all else stays."""
    return System(
        parameters={"W": 0.9, "F": 0.8, "unit": unit},
        states={"q": "v", "v": "unit*F*cos(W*t) - 0.1*v - q - q^3/unit^2"},
        forcing={"period": "2*pi/W"},
    )


def known(unit: float):
    model = duffing(unit)
    flow = flow_of(model)
    return flow, flow.constants(model.vector, unit * np.ones(2))


@pytest.mark.parametrize("exponent", [-70, -30, -7, 13, 60])
def test_powers_of_two_change_no_digit(exponent):
    unit = 2.0**exponent
    (flow, ours), (_, one) = known(unit), known(1.0)
    at = ours.rates[:, [1]], one.rates[:, [1]]
    ends, matrices, along = flow.linearize(unit * START, *PHASES, ours, at[0])
    expected = flow.linearize(START, *PHASES, one, at[1])
    assert np.array_equal(ends / unit, expected[0])
    assert np.array_equal(matrices, expected[1])
    assert np.array_equal(along / unit, expected[2])
    bent, pulled = flow.curve(unit * START, *PHASES, ours, at[0], unit * START)
    expected = flow.curve(START, *PHASES, one, at[1], START)
    assert np.array_equal(bent, expected[0])
    assert np.array_equal(pulled / unit, expected[1])
    jets = flow.jet_in_time(unit * START[:1], 0.0, 1.7, ours, unit * START)
    assert np.array_equal(jets / unit, flow.jet_in_time(START[:1], 0.0, 1.7, one, START))
    grid = np.linspace(0, 20, 5)
    motion = flow.trajectory(unit * START[0], ours, grid)
    assert np.array_equal(motion / unit, flow.trajectory(START[0], one, grid))


@pytest.mark.parametrize("unit", [1e-12, 1e-6, 1e9])
def test_each_trajectory_may_have_scales_of_its_own(unit):
    models = [duffing(unit), duffing(1.0), duffing(10 * unit)]
    units = np.array([unit, 1.0, 10 * unit])[:, None]
    flow = flow_of(models[0])
    vectors = np.array([model.vector for model in models])
    constants = flow.constants(vectors, units * np.ones(2))
    together = flow.advance(units * START, *PHASES, constants) / units
    alone = flow.advance(START, *PHASES, known(1.0)[1])
    # Errors of single steps are below 1e-13 of the scales, whatever these are.
    assert together == pytest.approx(alone, rel=0, abs=1e-12)
