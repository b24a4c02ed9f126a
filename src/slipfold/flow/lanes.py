"""Trajectories side by side in the lanes of a batch."""

from __future__ import annotations

from functools import cache
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.flow.precision import LANES

__all__ = ["ARRIVED", "by_lane", "chunks", "finished_lanes", "forget", "padded", "set_out"]

Array = NDArray[np.float64]

ARRIVED = hy.taylor_outcome.time_limit


@cache
def chunks(count: int) -> tuple[slice, ...]:
    """Return which trajectories go into each batch."""
    return tuple(slice(first, min(first + LANES, count)) for first in range(0, count, LANES))


def padded(items: Array) -> Array:
    """Fill the lanes that are left over with copies of the last item."""
    if len(items) == LANES:
        return items
    return np.concatenate([items, np.repeat(items[-1:], LANES - len(items), axis=0)])


def by_lane(values: Array, some: slice) -> Array:
    """Constants by lane: shape (n_c, 1) if all trajectories share them, (n_c, LANES) if not."""
    return values[:, None] if values.ndim == 1 else padded(values[some]).T


def set_out(batch: Any, start: Array) -> None:
    """Begin at these phases."""
    batch.set_time(padded(start))
    forget(batch)


def forget(integrator: Any) -> None:
    """Forget the events of the last run."""
    if integrator.with_events:
        integrator.reset_cooldowns()


def finished_lanes(batch: Any, state: Array, count: int) -> Array:
    """Return one row per lane; NaN where the integrator did not arrive."""
    result = state.T[:count].copy()
    outcomes = [item[0] for item in batch.propagate_res[:count]]
    if outcomes.count(ARRIVED) < count:  # one comparison costs more than a look at all of them
        result[[outcome != ARRIVED for outcome in outcomes]] = np.nan
    return result
