"""A mass shaken off its belt and landing on it again, against SciPy's integrator with events."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf

MU, BELT, NS, KN, RATE, DAMPING = 0.5, 0.3, 0.5, 4.0, 0.4 * np.pi, 0.1
PERIODS = 4


def normal(t, state, _=None):
    return NS - KN * state[1]


def needed(t, state, pull):
    """Friction that keeps the mass at the speed of the belt."""
    return state[0] + DAMPING * BELT - pull * np.cos(RATE * t)


def slip(t, state, _=None):
    return BELT - state[2]


def event(function, direction):
    def found(t, state, _, pull):
        return function(t, state, pull)

    found.terminal, found.direction = True, direction
    return found


PARTS, MEETS = event(normal, -1), event(normal, 1)
YIELDS = event(lambda t, state, pull: MU * normal(t, state) - abs(needed(t, state, pull)), -1)
ENDS = {
    "free": [MEETS],
    "forth": [PARTS, event(slip, -1)],
    "back": [PARTS, event(slip, 1)],
    "stick": [YIELDS],
}


def rates(t, state, mode, pull):
    x, y, vx, vy = state
    pressed = 0.0 if mode == "free" else normal(t, state)
    held = needed(t, state, pull)
    rubbed = {"free": 0.0, "forth": MU * pressed, "back": -MU * pressed, "stick": held}
    ax = pull * np.cos(RATE * t) - x - DAMPING * vx + rubbed[mode]
    ay = 2.0 * np.cos(RATE * t) - y - DAMPING * vy + pressed
    return [vx, vy, 0.0 if mode == "stick" else ax, ay]


def following(mode, met, t, state, pull):
    """The mode after one of the events of another."""
    if mode in ("forth", "back") and met == 0:
        return "free"
    if mode == "free":
        return "forth" if slip(t, state) > 0 else "back"
    if mode != "stick" and abs(needed(t, state, pull)) <= MU * normal(t, state):
        return "stick"
    return "forth" if needed(t, state, pull) > 0 else "back"


def by_hand(end, pull):
    """Modes, when each ends, and the state at the end."""
    t, state, mode, history = 0.0, np.zeros(4), "forth", []
    while True:
        leg = solve_ivp(
            rates, (t, end), state, "DOP853", events=ENDS[mode], args=(mode, pull), rtol=1e-12,
            atol=1e-13, first_step=1e-4,
        )  # fmt: skip
        t, state = leg.t[-1], leg.y[:, -1]
        history.append((mode, t))
        if leg.status == 0:
            return history, state
        (met,) = (place for place, times in enumerate(leg.t_events) if len(times))
        mode = following(mode, met, t, state, pull)


@pytest.mark.parametrize(("pull", "landing"), [(0.3, {"forth"}), (-1.0, {"back"})])
def test_free_flight_and_landing(pull, landing):
    load = sf.ContactLoad(normal="y", Ns=NS, kn=KN)
    contact = sf.FrictionContact("x", sf.Coulomb(mu_k=MU, mu_s=MU), load, Vd=BELT)
    forces = [sf.HarmonicForce("y", F=2.0, name="across"), sf.HarmonicForce("x", F=pull)]
    model = sf.Structure(
        np.eye(2),
        DAMPING * np.eye(2),
        np.eye(2),
        names="x y",
        contacts=contact,
        forcing=forces,
        f=RATE / (2 * np.pi),
    )
    motion = sf.simulate(model, PERIODS)
    history, state = by_hand(PERIODS * motion.forcing_period, pull)
    modes = [mode for mode, _ in history]
    assert {after for mode, after in pairwise(modes) if mode == "free"} == landing
    intervals = motion.sticking.intervals
    shown = {"forth": "slip", "back": "slip"}
    assert [item.state for item in intervals] == [shown.get(mode, mode) for mode in modes]
    assert sum(item.state == "free" for item in intervals) > 3
    ends = [item.end * motion.forcing_period for item in intervals]
    assert ends == pytest.approx([end for _, end in history], abs=1e-9)
    assert motion.states[-1] == pytest.approx(state, abs=1e-9)
    for item in intervals:
        if item.state == "free":
            assert item.work == item.heat == 0
