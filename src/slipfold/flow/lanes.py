"""Trajectories side by side in the lanes of a batch."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.patience import arrive
from slipfold.flow.precision import LANES


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


def carried(batch: Any, end: Array) -> Array:
    """Integrate a batch; return one row a trajectory, NaN where the integrator did not arrive.

    Shapes: end (m,); returns (m, N).
    """
    arrived, count = arrive(batch, padded(end)), len(end)
    rows = batch.state.T[:count].copy()
    if not arrived.all():
        rows[~arrived[:count]] = np.nan
    return np.asarray(rows)


def joined(batches: Sequence[Array]) -> Array:
    """Return the rows of all batches."""
    return batches[0] if len(batches) == 1 else np.concatenate(batches)
