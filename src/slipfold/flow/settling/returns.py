"""Returns of an autonomous motion to a plane that it crosses: fixed points there are cycles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.dense_motion import DenseMotion
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.models.turns import without_turns

NEAR = 0.3
"""Crossings farther from where the plane was placed than this share of the motion's extent are
other parts of the motion."""

CORRECTIONS = 12
"""Newton steps to a crossing; five are enough, and a step that leaves its bracket is halved."""


ROUNDING = 1e-6
"""Share of a step by which rounding may place a crossing beyond it."""


@dataclass(frozen=True, eq=False)
class Returns:
    """Where a motion crosses a plane, in one sense."""

    phases: Array  # when, shape (m,)
    states: Array  # where, shape (m, n)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.phases)


def find_returns(
    flow: Flow, constants: Constants, motion: DenseMotion, scales: Array, turns: Array
) -> Returns:
    """Find where a motion comes back to a plane that its own end places, but for whole turns.

    The plane stands across the motion where the speed is typical of its second half, neither at
    rest nor in a jump.
    """
    phases = motion.phases
    states = motion.at(phases) / scales
    half = phases >= 0.5 * motion.end
    places = np.flatnonzero(half)
    directions = _rates(flow, constants, motion.at(phases[half])) / scales
    speeds = np.linalg.norm(directions, axis=1)
    typical = int(np.argsort(speeds)[len(speeds) // 2])
    if not speeds[typical] > 0:
        return Returns(np.empty(0), np.empty((0, states.shape[1])))
    origin, normal = states[places[typical]], directions[typical] / speeds[typical]
    away = without_turns(states - origin, turns / scales)
    ahead = away @ normal
    before = np.flatnonzero((ahead[:-1] < 0) & (ahead[1:] >= 0))
    plane = origin, normal, turns / scales
    crossings = _crossings(flow, constants, motion, scales, plane, before)
    beside = without_turns(motion.at(crossings) / scales - origin, turns / scales)
    extent = float(np.linalg.norm(away[half], axis=1).max())
    near = np.linalg.norm(beside, axis=1) <= NEAR * extent
    return Returns(crossings[near], (origin + beside)[near] * scales)


def _rates(flow: Flow, constants: Constants, states: Array) -> Array:
    return flow.rates(states, np.zeros(len(states)), constants)


def _crossings(
    flow: Flow,
    constants: Constants,
    motion: DenseMotion,
    scales: Array,
    plane: tuple[Array, Array, Array],
    before: NDArray[np.intp],
) -> Array:
    """Correct the crossings inside the steps that hold one, all at once."""
    origin, normal, turns = plane
    low, high = motion.phases[before], motion.phases[before + 1]
    at, slack = 0.5 * (low + high), ROUNDING * (high - low)
    for _ in range(CORRECTIONS):
        states = motion.at(at)
        ahead = without_turns(states / scales - origin, turns) @ normal
        slope = (_rates(flow, constants, states) / scales) @ normal
        low, high = np.where(ahead < 0, at, low), np.where(ahead < 0, high, at)
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = at - ahead / slope
        # Not where it is no number; one at the very end of a step may lie beyond by rounding.
        inside = (moved >= low - slack) & (moved <= high + slack)
        at = np.where(inside, np.clip(moved, low, high), 0.5 * (low + high))
    return at
