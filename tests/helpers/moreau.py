"""Motions with set-valued friction by Moreau's time-stepping, by hand.

The midpoint rule of Moreau (1988), see Acary and Brogliato, Numerical Methods for Nonsmooth
Dynamical Systems, Springer 2008, section 10.1:

    q_m = q + h/2 v,    M (v' - v) = h f(t_m, q_m, (v + v')/2) + W^T p,    q' = q_m + h/2 v'

where the impulse p of friction lies in its interval, or disk, of size h mu N and is opposed to the
slip s' = plate - W v' at the end of the step: p = proj(p + r s') for any r > 0. Projections are
repeated over the contacts until nothing changes. No event is located: the order is one.

Where the friction coefficient jumps or falls, a step may have several solutions. As in the limit of
small steps the slip goes on if it can: a contact that slips rubs by the coefficient at its last
speed; one that stuck, or turned back within the step, holds up to the static coefficient.

Leading axes of states, plates and loads are motions that run side by side. Nothing of the package
is used.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

MOST_SWEEPS = 100_000
TINY = 1e-300


@dataclass
class Contact:
    """A place that rubs: rows of W, one on a line, two in the plane."""

    rows: np.ndarray  # shape (k, n)
    plate: np.ndarray  # velocity of the moving surface, shape (..., k)
    load: Callable  # (time, q) -> normal force
    coefficient: Callable  # of the slip speed
    static: np.ndarray | float = 0.0  # coefficient up to which it sticks


@dataclass
class System:
    """M q'' + C q' = f(t, q) + friction, shapes (n, n) and (..., n)."""

    mass: np.ndarray
    damping: np.ndarray
    force: Callable  # (time, q) -> f
    contacts: list


@dataclass
class Motion:
    """What a motion went through: states at the ends of steps, forces and stick within them."""

    times: np.ndarray  # shape (steps + 1,)
    q: np.ndarray  # shape (steps + 1, ..., n)
    v: np.ndarray
    friction: np.ndarray  # on the contacts in their order, shape (steps, ..., total k)
    stuck: np.ndarray  # shape (steps, ..., contacts)


def march(system, q, v, span, steps):
    """Follow motions from states q, v over a span of time in equal steps."""
    h = (span[1] - span[0]) / steps
    q, v = np.asarray(q, dtype=float), np.asarray(v, dtype=float)
    step = _Step(system, h)
    path, impulse = [(q, v)], np.zeros((*v.shape[:-1], step.size))
    stuck = [_length(slip) == 0 for slip in step.slips(v)]
    forces, states = [], []
    for i in range(steps):
        time = span[0] + (i + 0.5) * h
        middle = q + h / 2 * v
        v, impulse, stuck = step.velocity(time, middle, v, impulse, stuck)
        q = middle + h / 2 * v
        path.append((q, v))
        forces.append(impulse / h)
        states.append(stuck)
    qs, vs = (np.array(part) for part in zip(*path, strict=True))
    states = np.moveaxis(np.array(states), 1, -1)
    return Motion(np.linspace(*span, steps + 1), qs, vs, np.array(forces), states)


class _Step:
    """The velocity at the end of a step, for steps of one length."""

    def __init__(self, system, h):
        self.system, self.h = system, h
        self.inverse = np.linalg.inv(system.mass + h / 2 * system.damping)
        self.rows = np.vstack([contact.rows for contact in system.contacts])
        self.size = len(self.rows)
        self.lift = self.rows @ self.inverse.T
        # Slip that a unit impulse takes away
        self.answer = self.rows @ self.inverse @ self.rows.T
        ends = np.cumsum([len(contact.rows) for contact in system.contacts])
        self.parts = [
            slice(end - len(contact.rows), end)
            for contact, end in zip(system.contacts, ends, strict=True)
        ]
        self.pull = [1 / np.linalg.norm(self.answer[part, part], 2) for part in self.parts]

    def slips(self, v):
        """Slip of each contact."""
        return [contact.plate - v @ contact.rows.T for contact in self.system.contacts]

    def velocity(self, time, middle, v, impulse, stuck):
        """Velocity, impulses of friction and who sticks."""
        system, h = self.system, self.h
        push = h * (system.force(time, middle) - v @ system.damping.T)
        free = v + push @ self.inverse.T
        before, slips = self.slips(v), self.slips(free)
        loads = [h * np.maximum(contact.load(time, middle), 0.0) for contact in system.contacts]
        speeds = [_length(slip) for slip in before]
        impulse, sticks = self._solve(slips, self._limits(loads, speeds, stuck), impulse)
        after = free + impulse @ self.lift
        turned = [_dot(old, new) < 0 for old, new in zip(before, self.slips(after), strict=True)]
        if any(part.any() for part in turned):
            stuck = [old | new for old, new in zip(stuck, turned, strict=True)]
            impulse, sticks = self._solve(slips, self._limits(loads, speeds, stuck), impulse)
            after = free + impulse @ self.lift
        return after, impulse, sticks

    def _limits(self, loads, speeds, held):
        """Sizes that the impulses may have."""
        return [
            load * np.where(part, contact.static, contact.coefficient(speed))
            for contact, load, speed, part in zip(
                self.system.contacts, loads, speeds, held, strict=True
            )
        ]

    def _solve(self, slips, limits, impulse):
        """Impulses in their cones, opposed to what slip is left, and who sticks."""
        impulse = impulse.copy()
        answer, parts = self.answer, self.parts
        enough = 1e-12 * max(limit.max() for limit in limits)
        sticks = [np.zeros(0)] * len(parts)
        for _ in range(MOST_SWEEPS):
            change = 0.0
            for i, (part, slip, limit) in enumerate(zip(parts, slips, limits, strict=True)):
                old = impulse[..., part]
                wanted = old + self.pull[i] * (slip - impulse @ answer[part].T)
                length = _length(wanted)
                sticks[i] = length < limit
                new = (limit / np.maximum(np.maximum(length, limit), TINY))[..., None] * wanted
                change = max(change, np.abs(new - old).max())
                impulse[..., part] = new
            if change <= enough:
                return impulse, sticks
        raise ArithmeticError("the impulses do not settle")


def _length(vectors):
    return np.sqrt(_dot(vectors, vectors))


def _dot(one, other):
    return np.einsum("...k,...k", one, other)
