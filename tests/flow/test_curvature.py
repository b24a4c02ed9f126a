"""Second derivatives of flows against closed forms and complex steps through hand-written code."""

import numpy as np
import pytest

from helpers.by_hand.sliding import BASE, integrate
from helpers.toy_models import LinearOscillator, Runaway
from slipfold import SlidingOscillator
from slipfold.flow.flow import flow_of

RNG = np.random.default_rng(20260105)
TINY = 1e-30
NODES = np.cos(np.pi * np.arange(9) / 8)

SLIDING = SlidingOscillator(f=12.2, Nd=0.3, mu=0.45, alpha=0.9)
STATE = np.array([0.11, -0.06, 3.0, -7.0])
SCALE = np.array([1.0, 1.0, 80.0, 80.0])


def curve(model, states, start, end, names, vectors):
    flow = flow_of(model)
    constants = flow.constants(model.vector)
    columns = [model.parameter_index(name) for name in names]
    along = constants.rates[:, columns]
    return flow.curve(states, np.array(start), np.array(end), constants, along, vectors)


def slope_at_zero(values, size):
    """Derivative at zero of what was sampled at NODES times a size, by Chebyshev interpolation."""
    values = np.reshape(values, (len(NODES), -1))
    fits = [np.polynomial.Chebyshev.fit(NODES, column, len(NODES) - 1) for column in values.T]
    return np.array([fit.deriv()(0.0) for fit in fits]) / size


def test_blow_up_has_its_closed_form():
    # x' = x^2 leads from x to x/(1 - x t); t = phase/f.
    model, x, v = Runaway(f=2.0), np.array([[0.3], [-1.5], [0.9]]), np.array([[1.0], [2.0], [-0.5]])
    matrices, by_parameters = curve(model, x, [0.0] * 3, [0.5, 1.0, 1.7], ["f"], v)
    t = np.array([0.5, 1.0, 1.7]) / 2.0
    x, v = x[:, 0], v[:, 0]
    assert matrices[:, 0, 0] == pytest.approx(2 * t / (1 - x * t) ** 3 * v, rel=1e-12)
    assert by_parameters[:, 0, 0] == pytest.approx(
        2 * x / (1 - x * t) ** 3 * (-t / 2.0) * v, rel=1e-12
    )


def test_linear_oscillator_bends_along_its_parameters_alone():
    # D phi is exp(A t): its derivatives by complex steps in closed form.
    model = LinearOscillator(f0=1.1, zeta=0.07, a=0.8, f=1.3)
    names, values = ("f0", "zeta", "f", "a"), model.values
    v = RNG.normal(size=(2, 2))
    matrices, by_parameters = curve(
        model, RNG.normal(size=(2, 2)), [0.0, 0.2], [1.0, 0.9], names, v
    )
    assert np.abs(matrices).max() < 1e-12

    def propagated(vector, phases, **changes):
        p = {**values, **changes}
        w0, zeta, t = 2 * np.pi * p["f0"], p["zeta"], phases / p["f"]
        decay, turning = zeta * w0, w0 * np.sqrt(1 - zeta**2)
        c, s = np.cos(turning * t), np.sin(turning * t) / turning
        x, y = vector
        image = [(c + decay * s) * x + s * y, -(w0**2) * s * x + (c - decay * s) * y]
        return np.exp(-decay * t) * np.array(image)

    for vector, phases, pull in zip(v, (1.0, 0.7), by_parameters, strict=True):
        for column, name in enumerate(names):
            moved = propagated(vector, phases, **{name: values[name] + 1j * TINY})
            assert pull[:, column] == pytest.approx(moved.imag / TINY, abs=1e-11)


def test_sliding_oscillator_against_complex_steps_through_the_equations():
    # The first derivative is a complex step, the second the slope of those along v.
    v, size = np.array([0.4, -0.3, 20.0, 35.0]), 0.1
    names = ("f", "Vd")
    (matrix,), (pull,) = curve(SLIDING, STATE[None], [0.0], [1.0], names, v[None])
    p = {**BASE, **SLIDING.values}
    for column, unit in enumerate(np.eye(4)):
        firsts = [integrate(STATE + size * s * v + 1j * TINY * unit, p).imag / TINY for s in NODES]
        expected = slope_at_zero(firsts, size)
        scaled = SCALE[column] / SCALE
        assert matrix[:, column] * scaled == pytest.approx(expected * scaled, abs=1e-7)
    for column, name in enumerate(names):
        moved = {**p, name: p[name] + 1j * TINY}
        firsts = [integrate(STATE + size * s * v, moved).imag / TINY for s in NODES]
        expected = slope_at_zero(firsts, size)
        assert pull[:, column] / SCALE == pytest.approx(expected / SCALE, abs=1e-6)


def test_second_derivatives_are_symmetric_and_linear():
    u, v = np.array([0.2, 0.1, -9.0, 4.0]), np.array([-0.1, 0.3, 5.0, 7.0])
    vectors = np.array([u, v, 2 * u - 3 * v])
    states = np.tile(STATE, (3, 1))
    matrices, by_parameters = curve(SLIDING, states, [0.1] * 3, [0.8] * 3, ("f", "mu"), vectors)
    assert matrices[0] @ v == pytest.approx(matrices[1] @ u, rel=1e-10)
    assert matrices[2] == pytest.approx(2 * matrices[0] - 3 * matrices[1], rel=1e-9, abs=1e-11)
    assert by_parameters[2] == pytest.approx(
        2 * by_parameters[0] - 3 * by_parameters[1], rel=1e-9, abs=1e-11
    )
    # The jet is the same derivative by other means.
    flow = flow_of(SLIDING)
    jet = flow.jet(STATE, 0.1, 0.8, flow.constants(SLIDING.vector), np.array([u, v]))
    assert matrices[0] @ u == pytest.approx(jet[0, 1], rel=1e-10)
    assert matrices[1] @ v == pytest.approx(jet[1, 1], rel=1e-10)
