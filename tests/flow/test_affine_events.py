"""Events of solutions in closed form: none is passed over between samples."""

from math import factorial

import numpy as np
import pytest

from slipfold.flow.affine_events import ORDERS, VALUES, EventFunctions, _enclosed, _Watched
from slipfold.flow.affine_flow import AffineSolutions, Harmonics


def watched(exponents, parts, constant):
    """The function ``Re sum(parts e^(exponents t)) + constant`` from phase zero on."""
    n, none = len(exponents), np.zeros(0, dtype=complex)
    unit, no_forcing = np.eye(n, dtype=complex), Harmonics(none, np.zeros((0, n), dtype=complex))
    solutions = AffineSolutions(
        exponents, unit, unit, no_forcing, np.zeros((0, n), dtype=complex), (), np.ones(n)
    )
    own = Harmonics(np.zeros(1, dtype=complex), np.full((1, 1), constant, dtype=complex))
    functions = EventFunctions(solutions, parts[None], own)
    return _Watched(functions, np.ones(n, dtype=complex), 0.0)


@pytest.mark.parametrize("seed", range(13))
def test_a_minimum_is_an_event_only_below_zero(seed):
    """Damped vibrations whose lowest value is 1e-9 below zero, and above."""
    made = np.random.default_rng(seed)
    count = made.integers(2, 12)
    exponents = -made.exponential(2.0, count) + 1j * np.exp(made.uniform(0, 5, count))
    parts = made.normal(size=count) + 1j * made.normal(size=count)

    def at(t, order=0):
        return (np.exp(np.multiply.outer(t, exponents)) @ (parts * exponents**order)).real

    t = np.linspace(0, 1, 20_001)
    lowest = t[1 + at(t[1:-1]).argmin()]
    for _ in range(4):
        lowest = np.clip(lowest - at(lowest, 1) / at(lowest, 2), 0, 1)
    assert min(at(0.0), at(1.0)) > at(lowest) + 1e-6
    depth = 1e-9
    assert watched(exponents, parts, depth - at(lowest)).first(1.0) is None
    _, phase = watched(exponents, parts, -depth - at(lowest)).first(1.0)
    assert lowest - phase == pytest.approx(np.sqrt(2 * depth / at(lowest, 2)), rel=1e-3)


@pytest.mark.parametrize("near", [1e-1, 1e-2, 1e-3])
def test_slip_that_has_just_begun_may_stop_between_two_samples(near):
    """``(1 - c)(c - a)(c - b)`` of ``c = cos t``: zero at rest, and twice soon after."""
    a, b = 1 - near, 1 - 2 * near
    powers = np.array([a * b, -(a + b + a * b), 1 + a + b, -1.0])  # of c
    parts = np.array([powers[1] + 0.75 * powers[3], powers[2] / 2, powers[3] / 4], dtype=complex)
    found = watched(1j * np.arange(1.0, 4.0), parts, powers[0] + powers[2] / 2).first(3.0)
    # An event counts as met 1e-14 beyond zero; the slope there is 4e-8 at least.
    assert found[1] == pytest.approx(np.arccos(a), abs=5e-7)


def test_a_dip_that_no_derivative_at_its_ends_shows_is_enclosed():
    # 1 - s^4 (1 - s)^4: in Bernstein's form the coefficient in the middle is 1 - 1/70.
    flat = (ORDERS == 0).astype(float)
    low, high = _enclosed(VALUES, flat, flat, float(factorial(8)))
    assert low == pytest.approx([1, 1, 1, 1, 1 - 1 / 70, 1, 1, 1, 1], abs=1e-14)
    assert high[4] == pytest.approx(1 + 1 / 70, abs=1e-14)
