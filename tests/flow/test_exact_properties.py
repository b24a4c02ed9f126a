"""The four exact properties of the sliding oscillator in shared/reference/sliding.json."""

import math

import numpy as np
import pytest

from slipfold.flow import flow_of, simulate
from slipfold.models import SlidingOscillator

RNG = np.random.default_rng(20260104)
MODEL = SlidingOscillator(f=12.5, Nd=0.1)
STATES = RNG.normal(size=(5, 4)) * [0.2, 0.2, 10, 10]
MIRROR = np.array([-1.0, 1.0, -1.0, 1.0])


def linearised(model, states=STATES):
    flow = flow_of(model)
    constants = flow.constants(model.vector)
    ones = np.ones(len(states))
    return flow.linearise(states, 0 * ones, ones, constants, constants.rates[:, [0]])[:2]


def test_friction_and_normal_force_act_by_their_product():
    other = MODEL.replace(mu=MODEL.mu / 2, Ns=2 * MODEL.Ns, Nd=2 * MODEL.Nd)
    for one, two in zip(linearised(MODEL), linearised(other), strict=True):
        assert one == pytest.approx(two, rel=1e-11, abs=1e-12)


def test_mirrored_direction_mirrors_the_motion():
    other = MODEL.replace(alpha=math.pi - MODEL.alpha)
    ends, matrices = linearised(MODEL)
    mirrored, mirrored_matrices = linearised(other, STATES * MIRROR)
    assert mirrored * MIRROR == pytest.approx(ends, rel=1e-11, abs=1e-11)
    assert mirrored_matrices * MIRROR * MIRROR[:, None] == pytest.approx(matrices, abs=1e-9)


def test_determinant_is_the_exponential_of_the_mean_trace():
    flow = flow_of(MODEL)
    constants = flow.constants(MODEL.vector)
    nodes, weights = np.polynomial.legendre.leggauss(80)
    phases = (nodes + 1) / 2
    _, matrices = linearised(MODEL)
    for state, matrix in zip(STATES, matrices, strict=True):
        path = flow.trajectory(state, constants, np.concatenate([[0.0], phases]))[1:]
        traces = np.trace(flow.jacobians(path, phases, constants), axis1=1, axis2=2)
        assert np.linalg.det(matrix) == pytest.approx(math.exp(traces @ weights / 2), rel=1e-10)


def test_determinant_of_the_reference_orbit():
    state = np.array([[0.081835200408, -0.116609441502, 3.233575818289, 31.049107141969]])
    ends, matrices = linearised(MODEL, state)
    assert ends[0] == pytest.approx(state[0], abs=1e-8)
    assert np.linalg.det(matrices[0]) == pytest.approx(0.6686990004907, abs=1e-9)
    multipliers = sorted(np.linalg.eigvals(matrices[0]), key=lambda value: value.real)
    assert multipliers[0] == pytest.approx(-2.281699695519, abs=1e-9)


def test_upright_plate_leaves_the_plane_invariant():
    model = MODEL.replace(alpha=math.pi / 2)
    start = np.array([0.0, -0.1, 0.0, 12.0])
    strobe = simulate(model, 10, start).strobe
    # cos(pi/2) is 6e-17 in floating point, so rounding alone leaves the plane; unstable, it grows.
    assert np.max(np.abs(strobe[:, [0, 2]])) < 1e-12
    assert np.max(np.abs(strobe[:, 1])) > 0.01
