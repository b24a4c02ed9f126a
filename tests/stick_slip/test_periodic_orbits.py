"""Periodic orbits through stick and slip, and their multipliers, against closed forms."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import slipfold as sf
from helpers.dry_friction import FORCED_SLIDER, belt, den_hartog, sliding, two_masses
from slipfold.bifurcations.branches.orbit_between import orbit_between
from slipfold.models.equilibria import search_equilibrium
from slipfold.models.registry import model_named
from slipfold.orbits.extrema import steady_extrema

COULOMB = sf.Coulomb(mu_s=1.0, mu_k=0.5)


def fall(W, S, x, start, length):
    """Position and speed some time after rest at x: v < 0, x'' + x = cos(W t) + S."""
    V = 1 / (1 - W * W)
    a = x - S - V * math.cos(W * start)
    b = V * W * math.sin(W * start)
    c, s, end = math.cos(length), math.sin(length), W * (start + length)
    return a * c + b * s + S + V * math.cos(end), b * c - a * s - V * W * math.sin(end)


def test_den_hartog_without_stops():
    # A turn multiplies perturbations of the speed by the ratio of the accelerations, between turns
    # they vibrate freely.
    W, S = 0.6, 0.2
    V, U = 1 / (1 - W * W), math.sin(math.pi / W) / (W * (1 + math.cos(math.pi / W)))
    A, half = math.sqrt(V**2 - (S * U) ** 2), math.pi / W
    grid = np.linspace(0, 2 * half, 40)
    speeds = [fall(W, S, A, start, half)[1] for start in grid]
    places = [k for k in range(39) if speeds[k] * speeds[k + 1] < 0]
    turns = [brentq(lambda t: fall(W, S, A, t, half)[1], *grid[[k, k + 1]]) for k in places]
    (turn,) = (t for t in turns if abs(fall(W, S, A, t, half)[0] + A) < 1e-9)
    before = math.cos(W * turn) - A - S
    jump = np.diag([1.0, (before + 2 * S) / before])
    c, s = math.cos(half), math.sin(half)
    once = np.array([[c, s], [-s, c]]) @ jump
    orbit = sf.periodic_orbit(den_hartog(W, S))
    assert orbit.residual < 1e-10
    assert orbit.stuck_fraction == 0
    assert orbit.extrema.of("x")[1] == pytest.approx(A, abs=1e-10)
    assert orbit.extrema.of("Vrel")[0] == pytest.approx(0, abs=1e-10)  # it turns in a corner
    expected = np.sort_complex(np.linalg.eigvals(once @ once))
    assert np.sort_complex(orbit.multipliers) == pytest.approx(expected, abs=1e-9)


def test_friction_that_jumps_has_the_extrema_of_its_smooth_phases():
    # On a belt of speed V the mass is released at 0.8, slips about 0.5 and is caught at 0.2.
    contact = {"slip": "V - v", "normal": "1", "friction": sf.Coulomb(mu_s=0.8, mu_k=0.5)}
    rates = {"x": "v", "v": "F - x"}
    mass = sf.System(parameters={"V": 0.2}, states=rates, contacts={"F": contact})
    diagram = sf.response(mass, "V", (0.2, 0.25), settled=True, start={"x": 0.8, "v": 0.2})
    motion = sf.simulate(mass, 300, state=[0.8, 0.2])
    for known in (diagram.branches[0].extrema, steady_extrema(motion, ("x", "v", "F"))):
        assert np.abs(np.transpose(known.of("F")) - (0.2, 0.8)).max() < 1e-9
        assert known.of("x")[1][0] == pytest.approx(0.5 + np.hypot(0.3, 0.2), abs=1e-8)


@pytest.mark.parametrize(("W", "S", "static"), [(0.6, 0.7, 0.7), (0.6, 0.5, 0.8)])
def test_den_hartog_with_two_stops(W, S, static):
    # From rest at x it is released as |cos(W t) - x| = static, and comes to rest at the next x.
    orbit = sf.periodic_orbit(den_hartog(W, S, static))
    half = math.pi / W

    def following(x, guess):
        start = brentq(lambda t: math.cos(W * t) - x + static, guess - 0.3, guess + 0.3, xtol=1e-15)
        length = brentq(lambda t: fall(W, S, x, start, t)[1], 1.0, half, xtol=1e-15)
        return start, start + length, -fall(W, S, x, start, length)[0]

    x = float(orbit.extrema.of("x")[1][0])
    released = math.acos(x - static) / W
    start, stop, mirrored = following(x, released)
    assert mirrored == pytest.approx(x, abs=1e-10)
    stuck = 1 - (stop - start) / half
    assert orbit.stuck_fraction == pytest.approx(stuck, abs=1e-11)
    assert len(orbit.sticking) == 2
    step = 1e-5
    slope = (following(x + step, released)[2] - following(x - step, released)[2]) / (2 * step)
    assert orbit.multipliers[0] == pytest.approx(slope**2, abs=1e-8)
    assert orbit.multipliers[1] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    ("law", "speed", "damping", "period"),
    [
        (COULOMB, 0.2, 0.0, 2 * (math.pi - math.atan(2.5)) + 5.0),
        (COULOMB, 0.2, 0.1, 8.38379742099),
        (sf.RationalStribeck(mu_s=1.0, d=3.0), 0.3, 0.0, 9.953457266154),
    ],
)
def test_cycles_on_belts(law, speed, damping, period):
    # What sticks begins to slip at one and the same state, whatever was before.
    cycle = sf.periodic_orbit(belt(law, speed, damping))
    assert cycle.residual < 1e-10
    assert cycle.duration == pytest.approx(period, abs=1e-10)
    assert cycle.multipliers[0] == 1.0
    assert abs(cycle.multipliers[1]) <= cycle.multiplier_uncertainty[1] < 1e-14


def test_a_given_phase_is_kept_but_no_multiple_of_a_cycle_and_no_equilibrium():
    model = belt(COULOMB, 0.2, 0.1)
    cycle = sf.periodic_orbit(model)
    given = cycle.sample(8)[1][3]
    again = sf.periodic_orbit(model, state=given, duration=cycle.duration)
    assert again.state == pytest.approx(given, rel=0, abs=1e-9)
    twice = sf.periodic_orbit(model, state=given, duration=2 * cycle.duration)
    assert twice.duration == pytest.approx(cycle.duration, rel=1e-9)
    for wrong in ({"period": 2, "duration": cycle.duration}, {"duration": "x"}):
        with pytest.raises(sf.InputError, match=r"counts forcing periods|duration = 'x' is"):
            sf.periodic_orbit(model, state=given, **wrong)
    for name in ("steady-sliding", "vanderpol-free"):
        at_rest = model_named(name)
        with pytest.raises(sf.InputError, match=r"settled on an equilibrium|no orbit of period 1"):
            sf.periodic_orbit(at_rest, state=search_equilibrium(at_rest, at_rest.start), duration=1)


def test_two_masses_on_a_belt():
    cycle = sf.periodic_orbit(two_masses(), state={"x1": 0.5, "x2": -0.3})
    assert cycle.duration == pytest.approx(12.39295176687, abs=1e-9)
    # Both stick at once for a while: two directions are lost, and the flow's own is neutral.
    assert np.abs(cycle.multipliers[2:]) == pytest.approx(0.0, abs=1e-10)
    # The other one is seen from round to round in a motion that settles.
    motion = sf.simulate(two_masses().replace(duration=12.4), 20, {"x1": 0.5, "x2": -0.3})
    ends = [item for item in motion.sticking.intervals if item.state == "stick"]
    lengths = [item.end - item.begin for item in ends if item.contact == "second"][1:]
    gaps = np.diff(lengths[-14:-1:2])
    assert gaps[1:] / gaps[:-1] == pytest.approx(cycle.multipliers[1].real, abs=1e-3)


@pytest.mark.parametrize("values", [(0.3, 0.05, 0.6), (0.9, 0.02, 0.5)])
def test_multipliers_in_the_plane(values):
    orbit = sf.periodic_orbit(sliding(*values), settle=60)
    assert orbit.residual < 1e-10
    assert np.abs(orbit.multipliers[2:]) == pytest.approx(0.0, abs=1e-14)
    # The same from motions started beside the orbit.
    model, step = orbit.model, 1e-6
    matrix = np.empty((4, 4))
    for place, unit in enumerate(np.eye(4)):
        size = step * max(1.0, float(np.abs(orbit.nodes[:, place]).max()))
        ends = [
            sf.simulate(model, 1, orbit.state + sign * size * unit).states[-1] for sign in (1, -1)
        ]
        matrix[:, place] = (ends[0] - ends[1]) / (2 * size)
    expected = sorted(np.linalg.eigvals(matrix), key=abs, reverse=True)[:2]
    assert orbit.multipliers[:2] == pytest.approx(np.array(expected), abs=1e-6)


def test_an_orbit_that_sticks_says_what_it_cannot():
    orbit = sf.periodic_orbit(belt(COULOMB))
    with pytest.raises(sf.InputError, match="collocation"):
        orbit.check()


def test_a_slip_that_reverses_without_sticking_is_no_orbit_in_slip():
    model = sf.System.from_toml(FORCED_SLIDER).replace(Vd=0.25)
    motion = sf.simulate(model, 400)
    orbit = sf.periodic_orbit(model, 1, motion.states[-1])
    assert (motion.regime, orbit.stuck_fraction) == ("slip", 0)
    assert orbit.state == pytest.approx(motion.states[-1], abs=1e-10)
    step = 1e-7 * np.eye(2)
    ends = [sf.simulate(model, 1, orbit.state + each).states[-1] for each in step]
    expected = np.linalg.det((np.array(ends) - orbit.state) / 1e-7)
    assert np.prod(orbit.multipliers).real == pytest.approx(expected, abs=1e-5)


def test_orbits_that_stick_are_found_between_points_of_a_branch():
    branch = sf.response(sf.System.from_toml(FORCED_SLIDER), "Vd", (0.35, 0.6)).branches[0]
    place, value = float(branch.arclength[:2].mean()), float(branch.parameter[:2].mean())
    orbit = orbit_between(branch, place, value)
    assert orbit.model.values["Vd"] == value
    motion = sf.simulate(orbit.model, 400)
    assert orbit.state == pytest.approx(motion.states[-1], abs=1e-10)
    assert orbit.stuck_fraction == pytest.approx(motion.stuck_fraction, abs=1e-9)


def test_a_slow_cycle_settles_beside_a_vibration_seventy_times_as_fast():
    # Intervals of time are half a period of the fast one: 8192 of them are 26 rounds of the cycle.
    law, ratio = sf.Stribeck(mu_s=0.6, mu_k=0.3, vs=0.5), 70.0
    contact = sf.FrictionContact({"slow": 1.0, "fast": 0.3}, law, load=0.1, Vd=0.2)
    damping, stiffness = np.diag([0.01, 0.01 * ratio]), np.diag([1.0, ratio**2])
    model = sf.Structure(np.eye(2), damping, stiffness, names="slow fast", contacts=contact)
    settlement = sf.simulate(model).settlement
    assert settlement.kind == "cycle", settlement
    orbit = sf.periodic_orbit(model, state={"vslow": 0.1})
    assert orbit.stable
    assert settlement.duration == pytest.approx(orbit.duration, rel=1e-8)


def test_an_orbit_with_stick_of_a_structure_with_a_fast_decaying_mode():
    # Without the small mass, whose mode is ten thousand times as fast, the other has a millionth
    # less inertia.
    law, small = sf.CubicStribeck(mu_s=1.5, mu_m=0.4459, vm=1.0541), 1e-6
    acting = {
        "contacts": sf.FrictionContact("x", law, load=1.0, Vd=1.0),
        "forcing": sf.HarmonicForce("x", F=0.3),
        "f": 0.195,
    }
    alone = sf.Structure([[1.0]], None, [[1.0]], names="x", **acting)
    between = np.array([[1.0, -1.0], [-1.0, 1.0]])
    masses, stiffness = np.diag([1.0, small]), np.diag([1.0, 0.0]) + 100 * between
    both = sf.Structure(masses, 0.01 * between, stiffness, names="x y", **acting)
    known = sf.periodic_orbit(alone, period=2, state=[0.336, 0.380], settle=2)
    x, v = known.state
    orbit = sf.periodic_orbit(both, period=2, state=[x, x, v, v], settle=2)
    assert orbit.stuck_fraction == pytest.approx(known.stuck_fraction, abs=10 * small)
    largest = [np.abs(item.multipliers).max() for item in (orbit, known)]
    assert largest[0] == pytest.approx(largest[1], abs=10 * small)
