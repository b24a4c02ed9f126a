"""A pitchfork of an orbit that sticks: where another integrator finds that its symmetry breaks."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import slipfold as sf
from helpers.dry_friction import DUFFING_ON_BELT, belt

FLOOR = (
    DUFFING_ON_BELT.replace("1.0 - v", "-v").replace("- x - 0.1*v - 0.3*x^3", "- 0.1*v - x^3")
    .replace('"0.4"', '"1.0"').replace("A = 0.8", "A = 4.5").replace("1.35", "0.8")
)  # fmt: skip

RATE = 0.8
EXACT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}


@pytest.fixture(scope="module")
def branches():
    """The orbit that is its own mirror image, and those that leave it."""
    orbit = sf.periodic_orbit(sf.System.from_toml(FLOOR))
    settings = sf.Settings(largest_period=1)
    return sf.response(orbit, vary="A", span=(4.5, 4.3), settings=settings).branches


def mirrored_half(force, state):
    """Minus the state half a period later: of an orbit that is its own mirror image the same."""

    def pull(time, x):
        return force * np.cos(RATE * time) - x**3

    def halts(time, state):
        return state[1]

    halts.terminal = True
    time, end, sign, state = 0.0, np.pi / RATE, np.sign(state[1]), np.array(state)
    while time < end:

        def rates(time, state, sign=sign):
            return state[1], pull(time, state[0]) - 0.1 * state[1] - sign

        halts.direction = -sign
        motion = solve_ivp(rates, (time, end), state, events=halts, **EXACT)
        time, state = motion.t[-1], motion.y[:, -1]
        if motion.status != 1:
            break
        if abs(pull(time, state[0])) < 1:  # held until it is pulled as much as friction bears
            x, grid = state[0], np.linspace(time, end, 400)
            over = np.flatnonzero(np.abs(pull(grid, x)) > 1)
            if not len(over):
                break
            time = brentq(lambda t, x=x: abs(pull(t, x)) - 1, *grid[over[0] - 1 :][:2], xtol=1e-14)
        sign = np.sign(pull(time, state[0]))
        state = np.array([state[0], 1e-14 * sign])
    return -state


def left_to_break(force, state):
    """One more than the multiplier of the mirrored half: at minus one symmetry breaks."""
    for _ in range(6):
        sides = [[mirrored_half(force, state + s) for s in (d, -d)] for d in 1e-5 * np.eye(2)]
        slopes = np.transpose([(ahead - back) / 2e-5 for ahead, back in sides])
        state = state + np.linalg.solve(np.eye(2) - slopes, mirrored_half(force, state) - state)
    assert mirrored_half(force, state) == pytest.approx(state, abs=1e-9)
    return float(np.linalg.eigvals(slopes).real.min()) + 1


def test_symmetry_breaks_where_another_integrator_finds_it(branches):
    (point,) = [item for item in branches[0].special if item.type == "BP"]
    assert point.stuck_fraction > 0.005
    assert (point.name, point.criticality) == ("pitchfork", "subcritical")
    # From the multipliers of the orbits that leave it there, at amplitudes that go to zero.
    assert point.coefficient == pytest.approx(76.4, rel=5e-3)
    near, start = (point.value - 1e-4, point.value + 1e-4), point.nodes[0]
    found = brentq(left_to_break, *near, args=(start,), xtol=1e-8)
    assert found == pytest.approx(point.value, abs=1e-6)


@pytest.mark.long
def test_orbits_of_broken_symmetry_close_on_the_branch_point_that_they_began_at():
    # Beside it Newton's method is singular; the fold there says where it is.
    law = sf.Stribeck(mu_s=0.35, mu_k=0.3, vs=0.1, exponent=1)
    model = belt(law, 0.0, force=1.0, f=0.06)
    settings = sf.Settings(largest_period=1)
    orbit = sf.periodic_orbit(model)
    whole, broken = sf.response(orbit, vary="f", span=(0.06, 0.09), settings=settings).branches
    assert broken.stopped.kind == "closed"
    ends = [item.value for item in whole.special if item.type == "BP"]
    assert [item.value for item in broken.special if item.type == "BP"] == pytest.approx(ends)
    assert len(broken.special) == 10


def test_a_mass_that_sticks_beside_an_oscillator_leaves_its_normal_form_alone():
    own = {"x": "v", "v": "0.4*(1 - x^2)*v - x + F*cos(W*t)"}
    dry = own | {"y": "w", "w": "R - 2*y - 0.1*w + cos(W*t)"}
    held = {"R": {"slip": "-w", "normal": "1.0", "friction": sf.Coulomb(mu_k=0.85)}}
    given = {"parameters": {"W": 1.3, "F": 1.2}, "forcing": {"period": "2*pi/W"}}
    models = sf.System(states=own, **given), sf.System(states=dry, contacts=held, **given)
    smooth, found = (sf.response(each, "F", (1.2, 0.9)).branches[0].special[0] for each in models)
    assert found.stuck_fraction > 0.1
    assert found.coefficient == pytest.approx(smooth.coefficient, rel=1e-5)
