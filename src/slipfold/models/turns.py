"""Whole turns of angles: states that differ by them are the same."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipfold.arrays import Array
from slipfold.models.parameter import State

TURN = 2 * np.pi
"""Radians in a whole turn."""

NO_TURNS: Array = np.zeros(1)
"""Of states that are no angles."""


def without_turns(difference: Array, whole: Array) -> Array:
    """Return differences of states with angles taken the shorter way round.

    Shapes: difference (..., n); whole (n,), what a turn is, zero for what is no angle.

    >>> without_turns(np.array([6.0, 6.0]), np.array([6.5, 0.0]))
    array([-0.5,  6. ])
    """
    return difference - turns_between(difference, whole) * whole if whole.any() else difference


def mean_state(states: Array, whole: Array) -> Array:
    """Return the mean of states with angles taken next to the last one.

    Shapes: states (m, n); whole (n,).

    >>> mean_state(np.array([[3.0, 1.0], [-3.0, 3.0]]), np.array([6.5, 0.0]))
    array([-3.25,  2.  ])
    """
    last = states[-1]
    return np.asarray(last + without_turns(states - last, whole).mean(axis=0))


def turns_between(difference: Array, whole: Array) -> Array:
    """Return the number of whole turns in differences of states; zero of what is no angle.

    Shapes: difference (..., n); whole (n,).
    """
    return np.round(difference / np.where(whole > 0, whole, np.inf))


def turns_by_name(states: Sequence[State], turns: Array) -> dict[str, int]:
    """Return the whole turns of each angle. Shapes: turns (n,)."""
    pairs = zip(states, turns, strict=True)
    return {state.name: int(count) for state, count in pairs if state.angle}
