"""Loci of STICK, where a turn begins to stick: against a closed form and another integrator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from helpers.dry_friction import DUFFING_ON_BELT, belt, most_load
from slipfold.bifurcations.loci.follow import follow_loci

SINGLE = sf.Settings(largest_period=1)
MU = 0.2


def sticks_on(model, vary, span):
    """The one turn that begins to stick on a branch."""
    (point,) = [
        item.point
        for item in sf.response(model, vary=vary, span=span, settings=SINGLE).special
        if item.point.type == "STICK"
    ]
    return point


def test_turns_of_den_hartogs_orbit_begin_to_stick_on_his_curve():
    law, load = sf.Coulomb(mu_s=MU, mu_k=MU), 1.02 * most_load(0.1, MU)
    model = belt(law, 0.0, load=load, force=1.0, f=0.1)
    point = sticks_on(sf.periodic_orbit(model), "Ns", (load, 0.98 * most_load(0.1, MU)))
    (locus,) = follow_loci([point], ("f", "Ns"), ((0.09, 0.12), (1.0, 6.0)))
    assert (locus.type, locus.started.kind, locus.stopped.kind) == ("STICK", "window", "window")
    for frequency, load in locus.values:
        assert load == pytest.approx(most_load(frequency, MU), rel=1e-10)


def test_a_locus_is_met_between_points_that_its_own_windows_part():
    tip = {"slip": "-v", "normal": "1", "friction": {"law": "Coulomb", "mu_s": "m", "mu_k": "m"}}
    given = {"forcing": {"period": "2*pi/W"}, "contacts": {"tip": tip}}
    rates = {"x": "v", "v": "cos(W*t) - 0.04*v - x + tip"}
    model = sf.System(parameters={"W": 0.52, "m": 0.6}, states=rates, **given)
    points = [
        sticks_on(sf.periodic_orbit(model.replace(W=frequency, m=start)), "m", (start, end))
        for frequency, start, end in ((0.52, 0.6, 0.2), (0.89, 0.9, 0.6))
    ]
    (locus,) = follow_loci(points, ("W", "m"), ((0.5, 2.0), (0.05, 0.9)))
    assert {locus.started.kind, locus.stopped.kind} == {"window"}


@pytest.fixture(scope="module")
def turning():
    """A locus of an orbit that is not its own mirror image."""
    model = sf.System.from_toml(DUFFING_ON_BELT).replace(A=0.85)
    point = sticks_on(model, "W", (1.46, 1.40))
    (locus,) = sf.locus(point, ("W", "A"), ((1.38, 1.44), (0.75, 0.9))).loci
    return locus


def round_by_hand(frequency, force, start):
    """What friction would take to hold the mass at each of its turns, and the end of a period."""
    period, exact = 2 * np.pi / frequency, {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}

    def needed(time, state):
        x, v = state
        return x + 0.1 * v + 0.3 * x**3 - force * np.cos(frequency * time)

    def turns(time, state):
        return state[1] - 1.0

    turns.terminal = True
    time, state, held = 0.0, np.array(start), []
    sign = np.sign(1.0 - state[1])
    while time < period:
        turns.direction = sign

        def rates(time, state, sign=sign):
            return state[1], 0.4 * sign - needed(time, state)

        motion = solve_ivp(rates, (time, period), state, events=turns, **exact)
        time, state = motion.t[-1], motion.y[:, -1]
        if motion.status == 1:
            held.append(abs(needed(time, state)))
            sign = -sign
            state[1] = 1.0 - 1e-13 * sign
    return held, state


@pytest.mark.parametrize("row", [0, 2, -2, -1])
def test_friction_would_only_just_hold_a_turn(turning, row):
    frequency, force = turning.values[row]
    start = turning.orbit(row).state
    held, end = round_by_hand(frequency, force, start)
    assert end == pytest.approx(start, abs=1e-8)
    assert min(held) == pytest.approx(0.4, abs=1e-8)
    assert turning.stuck_fraction[row] < 1e-6


def test_branches_find_the_same_turns(turning):
    frequency, force = turning.values[1]
    model = sf.System.from_toml(DUFFING_ON_BELT).replace(A=force)
    found = sticks_on(model, "W", (1.01 * frequency, 0.99 * frequency))
    assert found.value == pytest.approx(frequency, abs=1e-9)


def test_a_symmetric_orbit_grazes_along_a_locus_in_both_halves():
    model = sf.System(
        parameters={"W": 0.31, "m": 0.05},
        states={"x": "v", "v": "R - 0.04*v - x + cos(W*t)"},
        contacts={"R": {"slip": "-v", "normal": "1", "friction": {"law": "Coulomb", "mu_k": "m"}}},
        forcing={"period": "2*pi/W"},
    )

    def grazes(m):
        (branch,) = sf.response(model, "W", (0.32, 0.33), settings=SINGLE, m=m).branches
        return next(point for point in branch.special if point.type == "GRAZE")

    (locus,) = sf.locus(grazes(0.05), ("W", "m"), ((0.31, 0.33), (0.045, 0.06))).loci
    assert [point.type for point in locus.special] == ["MEET"]
    assert {locus.started.kind, locus.stopped.kind} == {"window"}
    frequency, friction = locus.values[-1]
    assert grazes(friction).value == pytest.approx(frequency, abs=1e-9)
