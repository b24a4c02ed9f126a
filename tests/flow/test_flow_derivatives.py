"""Derivatives of flows against complex steps through equations written by hand."""

import numpy as np
import pytest
from scipy.linalg import expm

from helpers.by_hand.sliding import BASE, integrate, rhs
from helpers.toy_models import LinearOscillator
from slipfold import SlidingOscillator
from slipfold.flow import flow as flows
from slipfold.flow.flow import flow_of

RNG = np.random.default_rng(20260103)
MODEL = SlidingOscillator(f=12.2, Nd=0.3, mu=0.45, alpha=0.9)
P = {**BASE, **MODEL.values}
FLOW = flow_of(MODEL)
CONSTANTS = FLOW.constants(MODEL.vector)
STATE = np.array([0.11, -0.06, 3.0, -7.0])
SCALE = np.array([1.0, 1.0, 80.0, 80.0])
TINY = 1e-30


def test_jacobian_of_the_rates():
    states = RNG.normal(size=(6, 4)) * [0.3, 0.3, 20, 20]
    phases = RNG.uniform(0, 1, 6)
    found = FLOW.jacobians(states, phases, CONSTANTS)
    for state, phase, matrix in zip(states, phases, found, strict=True):
        expected = [
            rhs(phase / MODEL.f, state + 1j * TINY * unit, P).imag / TINY / MODEL.f
            for unit in np.eye(4)
        ]
        assert matrix == pytest.approx(np.transpose(expected), rel=1e-11, abs=1e-11)


def test_derivatives_of_the_coefficients():
    p = {parameter.name: MODEL.values[parameter.name] for parameter in MODEL.parameters}
    for column, name in enumerate(p):
        step = 1e-6 * max(1.0, abs(p[name]))
        up, down = (
            FLOW.constants(np.array(list({**p, name: p[name] + sign * step}.values()))).values
            for sign in (1, -1)
        )
        slope = (up - down) / (2 * step)
        size = np.maximum(np.abs(slope), 1)
        assert CONSTANTS.rates[:, column] / size == pytest.approx(slope / size, abs=1e-6)


def test_monodromy_matrix():
    ends, matrices, _ = FLOW.linearize(
        STATE[None], np.zeros(1), np.ones(1), CONSTANTS, CONSTANTS.rates[:, [0]]
    )
    expected = np.transpose(
        [integrate(STATE + 1j * TINY * unit, P).imag / TINY for unit in np.eye(4)]
    )
    assert ends[0] / SCALE == pytest.approx(integrate(STATE, P) / SCALE, abs=1e-11)
    scaled = (matrices[0] - expected) * SCALE / SCALE[:, None]
    assert np.max(np.abs(scaled)) < 1e-9


@pytest.mark.parametrize("together", [24, 3])
def test_derivatives_through_phases_are_those_to_each(together, monkeypatch):
    monkeypatch.setattr(flows.VARIATIONS, "together", together)
    states, along = STATE * np.array([[1.0], [0.9], [0.8]]), CONSTANTS.rates[:, [0, 1]]
    start = np.array([0.0, 0.1, 0.3])
    phases = start[:, None] + np.array([0.0, 0.05, 0.4, 1.0])
    through = FLOW.linearize(states, start, phases, CONSTANTS, along)
    for column, end in enumerate(phases.T):
        to_each = FLOW.linearize(states, start, end, CONSTANTS, along)
        for found, expected in zip(through, to_each, strict=True):
            size = np.abs(expected).max(axis=0)
            assert np.abs(found[:, column] - expected).max() <= 1e-12 * size.max()


@pytest.mark.parametrize("name", [parameter.name for parameter in MODEL.parameters])
def test_derivative_with_respect_to_a_parameter(name):
    direction = CONSTANTS.rates[:, [MODEL.parameter_index(name)]]
    _, _, vectors = FLOW.linearize(STATE[None], np.zeros(1), np.ones(1), CONSTANTS, direction)
    expected = integrate(STATE, {**P, name: P[name] + 1j * TINY}).imag / TINY
    size = np.max(np.abs(expected) / SCALE) + 1e-3
    assert np.max(np.abs(vectors[0, :, 0] - expected) / SCALE) / size < 1e-8


def test_linear_flow_has_an_exact_monodromy_matrix():
    model = LinearOscillator(zeta=0.2)
    flow = flow_of(model)
    constants = flow.constants(model.vector)
    w0 = 2 * np.pi * model.f0
    matrix = np.array([[0, 1], [-(w0**2), -2 * model.zeta * w0]])
    _, found, along = flow.linearize(
        RNG.normal(size=(3, 2)),
        np.zeros(3),
        np.array([0.5, 1, 3]),
        constants,
        constants.rates[:, [model.parameter_index("a")]],
    )
    for phase, part, vector in zip((0.5, 1, 3), found, along, strict=True):
        assert part == pytest.approx(expm(matrix * phase / model.f), abs=1e-12)
        # The response is linear in the amplitude.
        assert vector[:, 0] == pytest.approx(model.exact(phase / model.f) / model.a, abs=1e-12)


def test_jets_agree_with_differences_of_the_flow():
    directions = RNG.normal(size=(9, 4)) * [0.05, 0.05, 3, 3]
    jets = FLOW.jet(STATE, 0.0, 1.0, CONSTANTS, directions)
    nodes = np.cos(np.pi * np.arange(13) / 12)
    for direction, jet in zip(directions, jets, strict=True):
        ends = FLOW.advance(
            STATE + nodes[:, None] * direction, np.zeros(13), np.ones(13), CONSTANTS
        )
        for component in range(4):
            fit = np.polynomial.Chebyshev.fit(nodes, ends[:, component], 12)
            for order in (1, 2, 3):
                expected = fit.deriv(order)(0.0)
                assert jet[order - 1, component] / SCALE[component] == pytest.approx(
                    expected / SCALE[component], abs=1e-7
                )


def test_every_trajectory_may_have_parameters_of_its_own():
    names = ("f", "Nd")
    models = [MODEL.replace(Nd=0.1 * i, f=12.0 + 0.1 * i) for i in range(1, 10)]
    vectors = np.array([model.vector for model in models])
    columns = [MODEL.parameter_index(name) for name in names]
    states = STATE + RNG.normal(size=(9, 4)) * [0.01, 0.01, 0.5, 0.5]
    zero, one = np.zeros(9), np.ones(9)
    together = FLOW.constants(vectors)
    found = FLOW.linearize(states, zero, one, together, together.rates[:, :, columns])
    ends = FLOW.advance(states, zero, one, together)
    rates = FLOW.rates(states, zero, together)
    for i, vector in enumerate(vectors):
        alone = FLOW.constants(vector)
        some = slice(i, i + 1)
        assert np.array_equal(together.values[i], alone.values)
        expected = FLOW.linearize(
            states[some], zero[some], one[some], alone, alone.rates[:, columns]
        )
        for part, exact in zip(found, expected, strict=True):
            assert part[i] == pytest.approx(exact[0], rel=1e-13, abs=1e-13)
        assert ends[i] == pytest.approx(expected[0][0], rel=1e-12)
        assert np.array_equal(rates[i], FLOW.rates(states[some], zero[some], alone)[0])
