"""Random parameters: a motion never hangs, never is NaN, never does what friction cannot do."""

import math
import signal
from contextlib import contextmanager
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest

import slipfold as sf

PERIODS = 2
LENGTH = 2.0
"""Unit of displacements in the masses on lines, in m."""
LONGEST = 60
"""Seconds of the processor after which a motion hangs, however busy the machine is."""

KINDS = ("Coulomb", "viscous", "Tustin", "Gauss", "rational", "cubic")


class Thrown(NamedTuple):
    """A motion to follow, and what it must obey, by hand."""

    model: sf.Model
    length: float  # its unit of displacements in m
    law: sf.FrictionLaw
    start: np.ndarray
    normal: object  # of time
    slip: object  # of states, shape (m, k)
    energy: object  # of states
    power: object  # of time and states, put in by all but friction


def random_law(rng):
    mu, ratio = rng.uniform(0.05, 1), rng.choice([1.0, rng.uniform(1, 1.5)])
    kind, static, fast = rng.choice(KINDS), ratio * mu, 10 ** rng.uniform(-2, 0)
    if kind == "Coulomb":
        return sf.Coulomb(mu_s=static, mu_k=mu)
    if kind == "viscous":
        return sf.CoulombViscous(mu_s=static, mu_k=mu, s2=rng.uniform(0, 0.5))
    if kind == "rational":
        return sf.RationalStribeck(mu_s=static, d=0.3 / fast)
    if kind == "cubic":
        return sf.CubicStribeck(mu_s=static, mu_m=mu, vm=3 * fast)
    return sf.Stribeck(mu_s=static, mu_k=mu, vs=fast, exponent=1 if kind == "Tustin" else 2)


def random_speed(rng):
    """From 0 to 1, often small."""
    return rng.choice([0.0, rng.uniform(0, 1), 10 ** rng.uniform(-3, 0)])


def on_a_line(rng):
    """A forced mass on a belt or floor under a pulsating normal force."""
    law, speed, damping = random_law(rng), random_speed(rng), rng.uniform(0, 0.2)
    pulse, push = rng.choice([0.999, rng.uniform(0, 1)]), rng.uniform(0, 2)
    f = 10 ** rng.uniform(-1.5, 0)
    rate = 2 * math.pi * f
    model = sf.Structure(
        [[1.0]],
        # A parameter, as all that is thrown but the law: one compiled flow serves all of a law.
        sf.ProportionalDamping(alpha_M=damping),
        [[1.0]],
        names="x",
        contacts=sf.FrictionContact("x", law, sf.ModulatedLoad(Ns=1.0, Nd=pulse), Vd=speed),
        forcing=sf.HarmonicForce("x", F=push),
        f=f,
        length_scale=LENGTH,
    )
    start = rng.choice([0.0, 1.0]) * rng.uniform(-1, 1, 2)
    return Thrown(
        model,
        LENGTH,
        law,
        start / LENGTH,
        lambda t: 1 + pulse * np.cos(rate * t),
        lambda q: speed - q[:, 1:],
        lambda q: (q[:, 0] ** 2 + q[:, 1] ** 2) / 2,
        lambda t, q: push * np.cos(rate * t) * q[:, 1] - damping * q[:, 1] ** 2,
    )


def in_the_plane(rng):
    """The sliding oscillator, often at rest at first."""
    # It sticks on slow plates.
    law, speed, angle = random_law(rng), random_speed(rng) ** 2, rng.uniform(0, 2 * math.pi)
    pulse, f = rng.choice([0.999, rng.uniform(0, 1)]), rng.uniform(6, 16)
    model = sf.SlidingOscillator(friction=law, Vd=speed, alpha=angle, Nd=pulse, f=f)
    start = rng.choice([0.0, 1.0]) * rng.uniform(-1, 1, 4) * [0.5, 0.5, 20, 20]
    plate = speed * np.array([math.cos(angle), math.sin(angle)])
    damping = np.array([model.c2, model.c1])

    def energy(q):
        x, y, vx, vy = q.T
        stretch = np.hypot(x, model.L + y) - model.L
        springs = model.k2 * x**2 + model.k1 * y**2 + model.kext * stretch**2
        return (model.m2 * vx**2 + model.m1 * vy**2 + springs) / 2

    return Thrown(
        model,
        model.L,
        law,
        start,
        lambda t: 1 + pulse * np.cos(2 * math.pi * f * t),
        lambda q: plate - q[:, 2:],
        energy,
        lambda t, q: -(q[:, 2:] ** 2) @ damping,
    )


NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
# Nodes that are dense at both ends, where motions in the plane have roots for derivatives
PLACES = (NODES + 1) ** 2 * (2 - NODES) / 4
SHARES = WEIGHTS * 3 / 4 * (1 - NODES**2)


def faults(thrown):
    """Sentences on what a motion does that it must not."""
    try:
        motion = sf.simulate(thrown.model, PERIODS, thrown.start)
    except sf.InputError as error:
        return [] if str(error) else ["an error that says nothing"]
    if motion.stopped is not None:
        return [f"ended: {motion.stopped.reason}"]
    found = []
    time, states = motion.sample(per_period=32)
    if not (np.isfinite(motion.states).all() and np.isfinite(states).all()):
        return ["NaN"]
    states = thrown.length * states
    slip, normal = thrown.slip(states), thrown.normal(time)
    axes = "xy"[: slip.shape[1]]
    friction = np.transpose([motion.output(f"F{axis}", per_period=32)[1] for axis in axes])
    intervals = motion.sticking.intervals if motion.sticking else ()
    phase = time / motion.forcing_period
    sticks = np.zeros(len(time), dtype=bool)
    for item in intervals:
        if item.state == "stick":
            sticks |= (phase > item.begin + 1e-12) & (phase < item.end - 1e-12)
    speed, force = np.linalg.norm(slip, axis=1), np.linalg.norm(friction, axis=1)
    if np.any(speed[sticks] > 1e-12):
        found.append(f"slips by {speed[sticks].max():.1e} where it sticks")
    over = force[sticks] - thrown.law.stiction * normal[sticks]
    if np.any(over > 1e-12):
        found.append(f"friction leaves its cone by {over.max():.1e}")
    slips = ~sticks & (speed > 1e-9)
    size = np.asarray(thrown.law.coefficient(speed[slips])) * normal[slips]
    wanted = (size / speed[slips])[:, None] * slip[slips]
    if np.any(np.abs(friction[slips] - wanted) > 1e-9):
        found.append(f"friction in slip is off by {np.abs(friction[slips] - wanted).max():.1e}")
    if intervals:
        found += unbalanced(thrown, motion, intervals)
    return found


def unbalanced(thrown, motion, intervals):
    """What is wrong with the energies of a motion and with its history."""
    found = []
    heat = sum(item.heat for item in intervals)
    if any(item.heat < -1e-14 for item in intervals):
        found.append("friction gives heat back")
    if any(before.end != after.begin for before, after in pairwise(intervals)):
        found.append("time has gaps")
    stored = thrown.energy(thrown.length * motion.states)
    # Steps are accurate beside displacements of order one, however small a motion is.
    unit = thrown.energy(thrown.length * np.ones((1, motion.states.shape[1])))[0]
    scale = max(stored.max(), heat, 1e-4 * unit)
    ends = [item.end for item in intervals]
    gained = put_in(thrown, motion, ends, scale) + sum(item.work for item in intervals)
    gap = abs(stored[-1] - stored[0] - gained)
    if gap > 1e-9 * scale:
        found.append(f"energy does not close by {gap:.1e} of {scale:.1e}")
    return found


def put_in(thrown, motion, ends, scale):
    """Work of all but friction: panels between events are halved where that changes anything."""
    edges = np.unique(np.concatenate([np.linspace(0, PERIODS, 16 * PERIODS + 1), ends]))
    lows, highs, work = edges[:-1], edges[1:], 0.0
    while len(lows):
        middles = (lows + highs) / 2
        begins, finishes = [lows, lows, middles], [highs, middles, highs]
        whole, *halves = panels(thrown, motion, np.array(begins), np.array(finishes))
        rough = (abs(sum(halves) - whole) > 1e-13 * scale) & (highs - lows > 1e-9)
        work += sum(halves)[~rough].sum()
        lows, highs = (
            np.concatenate(some)[np.tile(rough, 2)] for some in (begins[1:], finishes[1:])
        )
    return work


def panels(thrown, motion, lows, highs):
    """Work of all but friction in some panels."""
    lengths = (highs - lows)[..., None]
    time = np.minimum(lows[..., None] + lengths * PLACES, PERIODS) * motion.forcing_period
    order = np.argsort(time, axis=None)
    power = np.empty(time.size)
    power[order] = thrown.power(time.ravel()[order], thrown.length * motion.at(time.ravel()[order]))
    return power.reshape(time.shape) @ SHARES * lengths[..., 0] * motion.forcing_period


@contextmanager
def in_time():
    """Raise `TimeoutError` in what hangs."""

    def ring(*_):
        raise TimeoutError(f"still running after {LONGEST} s")

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def thrown_wrong(kind, seeds):
    """Seeds of motions that do what they must not, and what."""
    wrong = {}
    for seed in seeds:
        with in_time():
            found = faults(kind(np.random.default_rng(seed)))
        if found:
            wrong[seed] = found
    return wrong


@pytest.mark.parametrize(("kind", "count"), [(on_a_line, 8), (in_the_plane, 5)])
def test_some_motions(kind, count):
    assert thrown_wrong(kind, range(count)) == {}


def test_energy_closes_where_slip_is_slow_throughout():
    # Friction in slip that begins had too few digits for its direction.
    assert thrown_wrong(in_the_plane, [50392]) == {}


MANY = [(on_a_line, first, 10_000) for first in range(0, 90_000, 10_000)]
MANY += [(in_the_plane, first, 1_000) for first in range(0, 10_000, 1_000)]


@pytest.mark.long
@pytest.mark.parametrize(("kind", "first", "count"), MANY)
def test_a_hundred_thousand_motions(kind, first, count):
    assert thrown_wrong(kind, range(first, first + count)) == {}
