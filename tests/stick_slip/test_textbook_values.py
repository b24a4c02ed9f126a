"""Motions with exact dry friction in one dimension, against closed forms and published values."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import slipfold as sf
from helpers.dry_friction import belt, two_masses

COULOMB = sf.Coulomb(mu_s=1.0, mu_k=0.5)
LEINE = sf.RationalStribeck(mu_s=1.0, d=3.0)


def stuck_times(motion, contact=None):
    """Durations of stick in the last round."""
    return [
        item.end - item.begin
        for item in motion.last_round.sticking
        if contact is None or item.contact == contact
    ]


def test_free_decay_loses_the_same_amplitude_every_half_cycle_and_then_rests():
    # 2 mu N/k every half period, exactly; it rests at the first turn with |x| <= mu N/k.
    law, k, m, load = sf.Coulomb(mu_s=0.3, mu_k=0.3), 4.0, 0.25, 2.0
    contact = sf.FrictionContact("x", law, load=load, Vd=0.0)
    model = sf.Structure([[m]], None, [[k]], names="x", contacts=contact)
    motion = sf.simulate(model, state={"x": 1.0})
    assert motion.regime == "stuck"
    assert motion.settlement.kind == "equilibrium"
    turns = 1.0 - 2 * 0.3 * load / k * np.arange(4)
    half = math.pi * math.sqrt(m / k)
    at_turns = motion.at(half * np.arange(4))
    assert np.abs(at_turns[:, 0]) == pytest.approx(turns, abs=1e-12)
    assert motion.states[-1] == pytest.approx([-turns[3], 0.0], abs=1e-12)
    (rest,) = (item for item in motion.sticking.intervals if item.state == "stick")
    assert rest.begin == pytest.approx(3 * half, abs=1e-12)


def test_a_forced_start_in_slip_on_a_floor_at_rest():
    # While v > 0: x'' + x = F cos(W t) - mu.
    F, W, mu, start = 0.5, 0.6, 0.4, np.array([0.5, 0.7])
    model = belt(sf.Coulomb(mu_s=mu, mu_k=mu), 0.0, force=F, f=W / (2 * math.pi))
    V = F / (1 - W * W)
    a, b = start[0] + mu - V, start[1]

    def speed(t):
        return -a * np.sin(t) + b * np.cos(t) - V * W * np.sin(W * t)

    turn = brentq(speed, 0.1, 2.0, xtol=1e-14)
    motion = sf.simulate(model, 1, start)
    assert motion.stopped is None
    assert motion.sticking.intervals[0].end * motion.forcing_period == pytest.approx(turn, 1e-12)
    t = np.linspace(0, turn, 9)
    x = a * np.cos(t) + b * np.sin(t) + V * np.cos(W * t) - mu
    assert motion.at(t) == pytest.approx(np.transpose([x, speed(t)]), abs=1e-12)
    # The instant at which it stops, alone.
    change = motion.sticking.intervals[0].end * motion.forcing_period
    assert motion.at(change) == pytest.approx([x[-1], 0.0], abs=1e-12)


@pytest.mark.parametrize("speed", [0.2, 0.35])
def test_a_belt_under_coulomb_friction(speed):
    drop, motion = 0.5, sf.simulate(belt(COULOMB, speed))
    slips = 2 * (math.pi - math.atan(drop / speed))
    assert motion.settlement.duration == pytest.approx(slips + 2 * drop / speed, abs=1e-10)
    assert stuck_times(motion) == pytest.approx([2 * drop / speed], abs=1e-10)
    assert motion.last_round.maximum[0] == pytest.approx(0.5 + math.hypot(drop, speed), abs=1e-10)


def test_the_slip_time_and_extremum_under_leines_law():
    motion = sf.simulate(belt(LEINE))
    (stuck,) = stuck_times(motion)
    assert motion.settlement.duration == pytest.approx(12.001031294830, abs=1e-10)
    assert motion.settlement.duration - stuck == pytest.approx(4.295999525480, abs=1e-10)
    assert motion.last_round.maximum[0] == pytest.approx(1.133944676442, abs=1e-10)


def test_exponential_stribeck():
    # bSTAB: friction 0.5 + 0.5 exp(-|v|/0.5).
    law = sf.Stribeck(mu_s=1.0, mu_k=0.5, vs=0.5)
    motion = sf.simulate(belt(law, 1.0, damping=0.1))
    assert motion.settlement.duration == pytest.approx(6.4313827982, abs=1e-9)
    beyond = sf.simulate(belt(law, 1.85, damping=0.1), state={"x": 2.0})
    assert beyond.settlement.kind == "equilibrium"
    assert beyond.regime == "slip"


def test_two_masses_and_their_two_attractors():
    motion = sf.simulate(two_masses(), state={"x1": 0.5, "x2": -0.3})
    assert motion.settlement.duration == pytest.approx(12.39295176687, abs=1e-9)
    first, second = (sorted(stuck_times(motion, name)) for name in ("first", "second"))
    assert first == pytest.approx([2.72270329, 4.07266075], abs=1e-8)
    assert second == pytest.approx([1.56790351, 5.00842914], abs=1e-8)
    other = sf.simulate(two_masses(), state={"x1": 0.9, "x2": 1.2})
    assert other.settlement.duration == pytest.approx(30.78198663869, abs=1e-9)


def test_equal_masses_stick_and_slip_at_the_same_instants():
    # In phase they are one belt of stiffness one, and every event is one of both contacts.
    # That cycle is unstable; over a round rounding has not grown yet.
    motion = sf.simulate(two_masses((1.0, 1.0), 0.2), 12, {"x1": 0.0, "x2": 0.0})
    states = motion.at(np.linspace(0, 12, 61))
    assert states[:, 0] == pytest.approx(states[:, 1], abs=1e-10)
    alone = sf.simulate(belt(LEINE), 12)
    assert states[:, 0] == pytest.approx(alone.at(np.linspace(0, 12, 61))[:, 0], abs=1e-10)
    ends = {name: [] for name in ("first", "second")}
    for item in motion.sticking.intervals:
        ends[item.contact].append(item.end)
    assert ends["first"] == pytest.approx(ends["second"], abs=1e-12)


def test_an_equilibrium_ends_where_its_surface_no_longer_slips():
    # A mass that a dashpot holds back: c v = mu N, so that the slip Vd - v is Vd/100 at the end.
    contact = {"slip": "Vd - v", "normal": "1", "friction": {"law": "Coulomb", "mu_k": 0.5}}
    parameters = {"Vd": {"value": 3.0, "above": 0}, "c": 0.4}
    model = sf.System(parameters=parameters, states={"v": "-c*v + F"}, contacts={"F": contact})
    (sliding,) = sf.response(model, vary="Vd", span=(3, 0.5)).branches
    assert sliding.kind == "equilibrium"
    assert sliding.stopped.kind == "limit"
    assert sliding.parameter[-1] == pytest.approx(0.5 / 0.4 / 0.99, rel=1e-9)


def test_a_part_slips_on_a_shaken_trough_where_its_cone_of_friction_is_left():
    # Along 30 degrees to a trough that rises by 2 degrees; its displacement is no state.
    slope, along, mu = math.radians(2), math.radians(30), 0.4
    model = sf.System(
        parameters={"a": 2.0, "mu": mu, "g": 9.81},
        formulas={"w": "2*pi*20"},
        states={"v": {"rate": f"F - g*sin({slope})", "scale": 0.05}},
        contacts={
            "F": {
                "slip": f"-a*cos({along})*sin(w*t)/w - v",
                "normal": f"g*cos({slope}) - a*sin({along})*cos(w*t)",
                "friction": {"law": "Coulomb", "mu_k": "mu"},
            }
        },
        forcing={"period": "1/20", "amplitude": "a"},
    )
    (branch,) = sf.response(model, vary="a", span=(2, 6)).branches
    held = 9.81 * (mu * math.cos(slope) + np.array([1, -1]) * math.sin(slope))
    expected = held / (math.cos(along) + np.array([1, -1]) * mu * math.sin(along))
    assert [item.type for item in branch.special] == ["GRAZE", "GRAZE"]
    assert [item.value for item in branch.special] == pytest.approx(expected, rel=1e-8)
