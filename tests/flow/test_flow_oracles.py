"""Flows against SciPy on equations written by hand, and against a closed form."""

import numpy as np
import pytest

from helpers.by_hand.sliding import BASE, integrate
from helpers.toy_models import LinearOscillator
from slipfold import SlidingOscillator
from slipfold.flow.equations import build_equations
from slipfold.flow.flow import Flow, flow_of

RNG = np.random.default_rng(20260102)
SETS = [
    {"f": 12.5, "Nd": 0.05},
    {"f": 12.2, "Nd": 0.9, "mu": 0.3},
    {"f": 9.0, "Nd": 0.4, "alpha": 2.0, "Vd": 1.0, "L": 0.01, "k2": 300.0, "zeta1": 0.02},
]
SCALE = np.array([1.0, 1.0, 80.0, 80.0])


@pytest.mark.parametrize("values", SETS)
def test_sliding_flow_agrees_with_scipy(values):
    model = SlidingOscillator(**values)
    flow = flow_of(model)
    states = RNG.normal(size=(11, 4)) * [0.1, 0.1, 5.0, 5.0]
    found = flow.advance(states, np.zeros(11), np.ones(11), flow.constants(model.vector))
    expected = [integrate(state, {**BASE, **model.values}) for state in states]
    assert np.max(np.abs(found - expected) / SCALE) < 2e-11


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10, 1e-13])
def test_error_falls_with_the_tolerance(tolerance):
    model = LinearOscillator()
    flow = Flow(build_equations(model), tolerance)
    end = flow.trajectory(np.zeros(2), flow.constants(model.vector), np.array([0.0, 5.0]))[-1]
    error = np.max(np.abs(end - model.exact(5.0 / model.f)))
    assert error < 10 * tolerance
