"""Orbits through stick and slip against an integrator with events that shares no code with them."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from helpers.dry_friction import belt

EXACT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
PAIR = np.array([[2.2, -1.2], [-1.2, 2.2]])


def stribeck(static, kinetic, speed):
    """A law, and its coefficient over the size of slip."""
    law = sf.Stribeck(mu_s=static, mu_k=kinetic, vs=speed, exponent=1)
    return law, lambda slip: kinetic + (static - kinetic) * np.exp(-slip / speed)


def coulomb(static, kinetic):
    """A law, and its coefficient over the size of slip."""
    return sf.Coulomb(mu_s=static, mu_k=kinetic), lambda slip: kinetic


class Masses:
    """Masses one by one on surfaces: stiffness, damping, forces, frequency; of each contact its
    surface's speed, load over time, coefficient of slip, static coefficient."""

    def __init__(self, stiffness, damping, force, rate, contacts):
        self.stiffness, self.damping, self.force = map(np.asarray, (stiffness, damping, force))
        self.rate, self.contacts, self.n = rate, contacts, len(force)

    def pull(self, time, state):
        x, v = state[: self.n], state[self.n :]
        return self.force * math.cos(self.rate * time) - self.stiffness @ x - self.damping * v

    def rates(self, time, state, mode):
        """With each contact at rest (0), or in slip."""
        v, gained = state[self.n :], self.pull(time, state)
        for i, (surface, load, mu, _) in enumerate(self.contacts):
            friction = mode[i] * mu(abs(surface - v[i])) * load(time)
            gained[i] = gained[i] + friction if mode[i] else 0.0
        return np.append(v, gained)

    def left(self, time, state, mode, i):
        """Slip, or what friction can hold in excess."""
        surface, load, _, static = self.contacts[i]
        if mode[i]:
            return mode[i] * (surface - state[self.n + i])
        return static * load(time) - abs(self.pull(time, state)[i])

    def mode_at(self, time, state, i):
        surface, load, _, static = self.contacts[i]
        if abs(surface - state[self.n + i]) > 1e-9:
            return int(np.sign(surface - state[self.n + i]))
        needed = -self.pull(time, state)[i]
        return 0 if abs(needed) < static * load(time) else int(np.sign(needed))

    def after(self, state, duration):
        """The state a time later, and for how long something was at rest."""
        time, stuck, state, which = 0.0, 0.0, np.array(state), range(self.n)
        mode = [self.mode_at(time, state, i) for i in which]
        while True:
            events = [lambda t, q, m, i=i: self.left(t, q, m, i) for i in which]
            for event in events:
                event.terminal, event.direction = True, -1
            args = {"args": (tuple(mode),), "events": events, **EXACT}
            motion = solve_ivp(self.rates, (time, duration), state, **args)
            stuck += (motion.t[-1] - time) * (0 in mode)
            time, state = motion.t[-1], motion.y[:, -1].copy()
            if motion.status != 1:
                return state, stuck
            i = next(i for i in which if len(motion.t_events[i]))
            if mode[i]:
                state[self.n + i] = self.contacts[i][0]
                mode[i] = self.mode_at(time, state, i)
            else:
                mode[i] = -int(np.sign(self.pull(time, state)[i]))
            state[self.n + i] = self.contacts[i][0] - 1e-13 * mode[i]


def pair(f, static):
    """Two coupled masses on two belts, one of them shaken."""
    law, mu = coulomb(static, 0.4)
    contacts = [
        sf.FrictionContact("x", law, load=1.0, Vd=0.3, name="a"),
        sf.FrictionContact("y", law, load=1.2, Vd=0.2, name="b"),
    ]
    force = sf.HarmonicForce("x", F=1.5)
    parts = {"names": "x y", "contacts": contacts, "forcing": force, "f": f}
    own = [(0.3, lambda t: 1.0, mu, static), (0.2, lambda t: 1.2, mu, static)]
    model = sf.Structure(np.eye(2), 0.1 * np.eye(2), PAIR, **parts)
    return model, Masses(PAIR, 0.1 * np.ones(2), [1.5, 0.0], 2 * math.pi * f, own)


def pulsed(f, static, kinetic, speed):
    """A shaken mass on a belt under a load that pulsates."""
    (law, mu), rate = stribeck(static, kinetic, speed), 2 * math.pi * f
    model = belt(law, 0.4, 0.15, load=sf.ModulatedLoad(Ns=1.0, Nd=0.6), force=0.5, f=f)
    own = [(0.4, lambda t: 1 + 0.6 * math.cos(rate * t), mu, static)]
    return model, Masses([[1.0]], [0.15], [0.5], rate, own)


def excited(surface, static, kinetic, speed):
    """A mass that its belt excites."""
    law, mu = stribeck(static, kinetic, speed)
    own = [(surface, lambda t: 1.0, mu, static)]
    return belt(law, surface, 0.05), Masses([[1.0]], [0.05], [0.0], 1.0, own)


def row(force):
    """Twelve masses in a row on surfaces at rest: their events are found in closed form."""
    (law, mu), n = coulomb(0.3, 0.3), 12
    stiffness = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    model = sf.Structure(
        np.eye(n), 0.1 * np.eye(n), stiffness, f=0.06, forcing=sf.HarmonicForce("q4", F=force),
        contacts=[sf.FrictionContact(f"q{i + 1}", law, load=1.0, Vd=0.0) for i in range(n)],
    )  # fmt: skip
    own, shaken = [(0.0, lambda t: 1.0, mu, 0.3)] * n, force * np.eye(n)[3]
    return model, Masses(stiffness, 0.1 * np.ones(n), shaken, 0.12 * math.pi, own)


@pytest.mark.parametrize(
    ("model", "other"),
    [
        row(3.0),
        pytest.param(*pair(0.118, 0.4), marks=pytest.mark.long),
        pair(0.1, 0.5),
        pulsed(0.25, 0.8, 0.5, 0.05),
        excited(0.1, 0.5, 0.3, 0.2),
        excited(1.0, 0.8, 0.4, 0.5),
    ],
)
def test_orbits_close_in_another_integrator(model, other):
    start = {} if model.forced else {"state": {"x": 1.0}}
    orbit = sf.periodic_orbit(model, **start)
    end, stuck = other.after(orbit.state, orbit.duration)
    assert end == pytest.approx(orbit.state, abs=1e-10)
    assert orbit.stuck_fraction > 0.01
    assert stuck / orbit.duration == pytest.approx(orbit.stuck_fraction, abs=1e-9)


@pytest.mark.long
def test_the_order_of_changes_that_do_not_affect_each_other_is_no_special_point():
    # Below 0.118107 Hz the other mass begins to slip first. Springs alone couple both: the orbit is
    # smooth there, and its slopes from either side agree to the error of their differences, of h^3.
    model, _ = pair(0.13, 0.5)
    settings = sf.Settings(largest_period=1)
    (branch,) = sf.response(model, "f", (0.13, 0.1), settings=settings).branches
    assert [point.type for point in branch.special] == ["STICK", "STICK"]
    assert branch.stopped.kind == "failed"
    h, places = 2e-5, range(-2, 3)
    near = [sf.periodic_orbit(model.replace(f=0.11810676298277584 + k * h)).state for k in places]
    weights = np.array([[1, -4, 3, 0, 0], [0, 0, -3, 4, -1]]) / (2 * h)
    before, after = weights @ near
    assert after == pytest.approx(before, abs=1e-4)
    # Another branch ends 6e-5 below, and is not joined to this one.
    (other,) = sf.response(model, "f", (0.1095, 0.1135), settings=settings).branches
    assert [point.type for point in other.special] == ["STICK"]
    assert other.stopped.kind == "failed"
    assert other.special[-1].value < branch.special[-1].value - 5e-5
    assert max(point.uncertainty for point in (*branch.special, *other.special)) < 1e-9


PLANE, SHAKEN = np.array([[1.0, 0.3], [0.3, 1.5]]), np.array([1.0, 0.0])


def after_in_the_plane(state, periods, f, force, speed, static, kinetic):
    """A mass on a moving plane: the least slip in the last of some periods, and its stuck part."""
    plate, duration, tiny = np.array([speed, 0.0]), periods / f, 1e-8
    time, state, stuck, least, stops = 0.0, np.array(state), False, np.inf, 0.0

    def needed(t, q):
        return PLANE @ q[:2] + 0.1 * q[2:] - force * math.cos(2 * math.pi * f * t) * SHAKEN

    def rates(t, q):
        slip = plate - q[2:]
        held = needed(t, q) if stuck else kinetic * slip / np.hypot(*slip)
        return np.append(q[2:], held - needed(t, q))

    def changes(t, q):
        return static - np.hypot(*needed(t, q)) if stuck else np.hypot(*(plate - q[2:])) - tiny

    changes.terminal, changes.direction = True, -1
    while True:
        motion = solve_ivp(rates, (time, duration), state, events=changes, max_step=0.1, **EXACT)
        if motion.t[-1] > duration - 1 / f:
            stops += (motion.t[-1] - time) * f * stuck
            slips = np.hypot(speed - motion.y[2], motion.y[3])[motion.t > duration - 1 / f]
            least = least if stuck else min(least, slips.min(initial=np.inf))
        time, state = motion.t[-1], motion.y[:, -1].copy()
        if motion.status != 1:
            return least, stops
        if stuck:  # slip begins along what was needed
            along = needed(time, state) / static
            state[2:] = plate - 2 * tiny * along
        elif np.hypot(*needed(time, state)) < kinetic:
            state[2:] = plate
        stuck = not stuck


@pytest.mark.long
@pytest.mark.parametrize(
    ("span", "end"), [((0.07, 0.12), 0.0885614227), ((0.102, 0.097), 0.0991599894)]
)
def test_slip_that_touches_zero_under_more_static_friction_ends_the_branch(span, end):
    # From stick it ended 8e-7 before, where the equations were too stiff, and did not say why.
    law = sf.Coulomb(mu_s=0.6, mu_k=0.5)
    model = sf.Structure(
        np.eye(2), 0.1 * np.eye(2), PLANE, names="x y", f=span[0],
        contacts=sf.FrictionContact(("x", "y"), law, load=1.0, Vd=0.42),
        forcing=sf.HarmonicForce("x", F=1.0),
    )  # fmt: skip
    (branch,) = sf.response(model, "f", span, settings=sf.Settings(largest_period=1)).branches
    (point,) = branch.special
    assert (point.type, branch.stopped.kind) == ("GRAZE", "failed")
    assert point.value == branch.stopped.value == pytest.approx(end, abs=2e-8)
    last, toward = branch.orbit(-1).state, np.sign(span[1] - span[0])
    (near_slip, near_stops), (slip, _), (_, stops) = (
        after_in_the_plane(last, 5, point.value + toward * way, 1.0, 0.42, 0.6, 0.5)
        for way in (-1e-6, -1e-5, 1e-6)
    )
    assert near_stops == pytest.approx(point.stuck_fraction, abs=3e-3)
    assert near_stops > 0 or near_slip / slip == pytest.approx(0.1, abs=1e-3)
    assert abs(stops - near_stops) > 0.015
