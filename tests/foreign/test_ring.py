"""Brusselators in a ring, coupled to their neighbors: 50 states, symmetric, all known exactly.

Nicolis and Prigogine, Self-Organization in Nonequilibrium Systems (Wiley 1977), section 7; of Hopf
bifurcations in rings, Golubitsky, Stewart and Schaeffer, Singularities and Groups in Bifurcation
Theory II (Springer 1988), chapter XVIII. With wave k along n cells the equations linearized about
rest are those of one cell with its diagonal less D lambda, lambda = 4 sin^2(pi k/n). With equal
diffusion D of both so are those about the cycle on which all cells swing alike: its multipliers are
those of one cell, here by SciPy, times exp(-D lambda T).
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from slipfold import System, response

CELLS, DIFFUSION = 25, 0.02
LAMBDA = 4 * np.sin(np.pi * np.arange(CELLS) / CELLS) ** 2


def ring():
    return System(
        name="ring",
        sizes={"n": CELLS},
        parameters={"B": 1, "D": DIFFUSION},
        formulas={"x[0]": "x[n]", "x[n+1]": "x[1]", "y[0]": "y[n]", "y[n+1]": "y[1]"},
        states={
            "x[i=1:n]": {
                "rate": "1 - (B + 1)*x[i] + x[i]^2*y[i] + D*(x[i-1] - 2*x[i] + x[i+1])",
                "start": 1,
            },
            "y[i=1:n]": {
                "rate": "B*x[i] - x[i]^2*y[i] + D*(y[i-1] - 2*y[i] + y[i+1])",
                "start": 1,
            },
        },
    )


def one_cell(b, state, duration):
    """The cycle of one cell near another: its duration and its multiplier besides one."""

    def rates(t, u):
        x, y = u[:2]
        slopes = np.array([[-(b + 1) + 2 * x * y, x * x], [b - 2 * x * y, -x * x]])
        pull = x * x * y
        own = [1 - (b + 1) * x + pull, b * x - pull]
        return np.concatenate([own, (slopes @ u[2:].reshape(2, 2)).ravel()])

    def after(start, time):
        begin = np.concatenate([start, np.eye(2).ravel()])
        return solve_ivp(rates, (0, time), begin, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]

    def misses(z):
        started = np.array([state[0], z[0]])
        return after(started, z[1])[:2] - started

    y, time = fsolve(misses, [state[1], duration], xtol=1e-13)
    matrix = after(np.array([state[0], y]), time)[2:].reshape(2, 2)
    return time, np.linalg.det(matrix)  # the other multiplier is one


def test_a_ring_of_25_brusselators_swings_as_one_does():
    diagram = response(ring(), vary="B", span=(1, 2.002))
    rest, swinging = diagram.branches
    (hopf,) = rest.special
    assert hopf.type == "HB"
    assert hopf.value == pytest.approx(2, abs=1e-9)
    assert hopf.criticality == "supercritical"
    assert diagram.checked.disagreeing == ()
    orbit = swinging.orbit(-1)
    duration, other = one_cell(
        float(swinging.parameter[-1]), orbit.state[[0, CELLS]], orbit.duration
    )
    assert orbit.duration == pytest.approx(duration, rel=1e-9)
    damped = np.exp(-DIFFUSION * LAMBDA * duration)
    known = np.sort(np.concatenate([damped, other * damped]))
    assert np.abs(orbit.multipliers.imag).max() < 1e-6
    assert np.sort(orbit.multipliers.real) == pytest.approx(known, abs=1e-7)


@pytest.mark.long
def test_pairs_of_waves_begin_at_once_and_what_is_not_followed_says_so():
    """Waves of both senses are critical together, at B = 2 + 2 D lambda."""
    diagram = response(ring(), vary="B", span=(1, 2.02))
    found = [point.value for point in diagram.branches[0].special]
    assert found == pytest.approx(2 + 2 * DIFFUSION * LAMBDA[:3], abs=1e-9)
    one, *pairs = diagram.branches[0].special
    assert one.criticality == "supercritical"
    for point in pairs:
        assert point.criticality is None
        assert "several multipliers are critical at once" in point.undecided
    failed = [branch for branch in diagram.branches if branch.failed]
    for branch in failed:
        assert "several multipliers are critical" in branch.stopped.reason
