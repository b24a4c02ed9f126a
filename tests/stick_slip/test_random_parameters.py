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
"""Unit of displacements in the models, in m."""
LONGEST = 60
"""Seconds after which a motion hangs."""

KINDS = ("Coulomb", "viscous", "Tustin", "Gauss", "rational", "cubic")


class Thrown(NamedTuple):
    """A motion to follow, and what it must obey, by hand."""

    model: sf.Model
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
        law,
        start,
        lambda t: 1 + pulse * np.cos(rate * t),
        lambda q: speed - q[:, 1:],
        lambda q: (q[:, 0] ** 2 + q[:, 1] ** 2) / 2,
        lambda t, q: push * np.cos(rate * t) * q[:, 1] - damping * q[:, 1] ** 2,
    )


NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
# Nodes that are dense at both ends, where motions in the plane have roots for derivatives
PLACES = (NODES + 1) ** 2 * (2 - NODES) / 4
SHARES = WEIGHTS * 3 / 4 * (1 - NODES**2)


def faults(thrown):
    """Sentences on what a motion does that it must not."""
    try:
        motion = sf.simulate(thrown.model, PERIODS, thrown.start / LENGTH)
    except sf.InputError as error:
        return [] if str(error) else ["an error that says nothing"]
    if motion.stopped is not None:
        return [f"ended: {motion.stopped.reason}"]
    found = []
    time, states = motion.sample(per_period=64)
    if not (np.isfinite(motion.strobe).all() and np.isfinite(states).all()):
        return ["NaN"]
    states = LENGTH * states
    size = len(thrown.slip(states).T)
    friction = np.transpose([motion.output(f"F{axis}")[1] for axis in "xy"[:size]])
    slip, normal = thrown.slip(states), thrown.normal(time)
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
    if any(item.heat < -1e-14 for item in intervals):
        found.append("friction gives heat back")
    if any(before.end != after.begin for before, after in pairwise(intervals)):
        found.append("time has gaps")
    ends = [item.end for item in intervals]
    gained, scale = put_in(thrown, motion, ends)
    gained += sum(item.work for item in intervals)
    stored = thrown.energy(LENGTH * motion.strobe)
    gap = abs(stored[-1] - stored[0] - gained)
    if gap > 1e-9 * scale:
        found.append(f"energy does not close by {gap:.1e} of {scale:.1e}")
    return found


def put_in(thrown, motion, ends):
    """Work of all but friction, from as many panels as it takes, and a size of the energies."""
    work, found = math.inf, 0.0
    for panels in 20 * 4 ** np.arange(5):
        edges = np.unique(np.concatenate([np.linspace(0, PERIODS, panels + 1), ends]))
        lengths = np.diff(edges)
        time = (edges[:-1, None] + lengths[:, None] * PLACES).ravel()
        time = np.minimum(time, PERIODS) * motion.forcing_period
        states = LENGTH * motion.at(time)
        power = thrown.power(time, states).reshape(-1, len(NODES))
        work, found = lengths @ power @ SHARES * motion.forcing_period, work
        scale = 1e-3 + thrown.energy(states).max()
        if abs(work - found) < 1e-10 * scale:
            break
    return work, scale


@contextmanager
def in_time():
    """Raise `TimeoutError` in what hangs."""

    def ring(*_):
        raise TimeoutError(f"still running after {LONGEST} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(LONGEST)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def thrown_wrong(kind, seeds):
    """Seeds of motions that do what they must not, and what."""
    wrong = {}
    for seed in seeds:
        with in_time():
            found = faults(kind(np.random.default_rng(seed)))
        if found:
            wrong[seed] = found
    return wrong


@pytest.mark.long
def test_masses_on_lines():
    assert thrown_wrong(on_a_line, range(200)) == {}
