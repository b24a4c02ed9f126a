"""Angles: states that differ by revolutions are the same."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from slipfold.arrays import Array
from slipfold.models.quantities import State

REVOLUTION = 2 * np.pi
"""Radians in a revolution."""

NO_ANGLES: Array = np.zeros(1)
"""The `periods` of states none of which is an angle."""


def wrap_angles(difference: Array, periods: Array) -> Array:
    """Reduce differences of angles to less than half a revolution.

    Shapes: difference (..., n); periods (n,) or (..., n), a revolution of each angle and zero for
    other states.
    """
    if not periods.any():
        return difference
    return difference - count_revolutions(difference, periods) * periods


class ScaledStates(Protocol):
    """A model, as far as it measures its states."""

    @property
    def angle_periods(self) -> Array:
        """A revolution of each angle, zero of other states."""

    def state_scales(self) -> Array:
        """Return the size of each state."""


def distances(model: ScaledStates, states: Array, others: Array) -> Array:
    """Return by how much states differ at most, in scaled states; revolutions make no difference.

    Shapes: states, others (..., n); returns (...).
    """
    apart = wrap_angles(states - others, model.angle_periods)
    return np.asarray(np.abs(apart / model.state_scales()).max(axis=-1))


def mean_state(states: Array, periods: Array) -> Array:
    """Return the mean of states, with angles next to those of the last state.

    Shapes: states (m, n); periods (n,).
    """
    last = states[-1]
    return np.asarray(last + wrap_angles(states - last, periods).mean(axis=0))


def embedded(states: Array, scales: Array, periods: Array) -> Array:
    """Return scaled states, with angles on circles. Shapes: states (..., n); others (n,)."""
    angles = periods > 0
    turning = states[..., angles]
    parts = [states[..., ~angles] / scales[~angles], np.cos(turning), np.sin(turning)]
    return np.concatenate(parts, axis=-1)


def count_revolutions(difference: Array, periods: Array) -> Array:
    """Return the revolutions in differences (..., n) of states with periods (n,)."""
    return np.round(difference / np.where(periods > 0, periods, np.inf))


def revolutions_by_name(states: Sequence[State], revolutions: Array) -> dict[str, int]:
    """Return the revolutions of each angle. Shapes: revolutions (n,)."""
    pairs = zip(states, revolutions, strict=True)
    return {state.name: int(count) for state, count in pairs if state.angle}
