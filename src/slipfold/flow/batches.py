"""Batches of trajectories in the lanes of one integrator, and their step budget.

The environment sets tolerance and lanes, so that tests can vary them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, Protocol

import heyoka as hy
import numpy as np

from slipfold.arrays import Array, Mask

TOLERANCE = float(os.environ.get("SLIPFOLD_TOLERANCE", "1e-13"))
"""Local error of a step. It gives multipliers to about 1e-13 for a tenth more time than 1e-12."""

ROUNDING = 10 * TOLERANCE
"""Change of a constant quantity, in scales, that is an error of steps and rounding."""

LANES = int(os.environ.get("SLIPFOLD_LANES", "8"))
"""Trajectories integrated together: two registers of AVX2, one of AVX-512."""


class BUDGET:
    """Numbers of integrator steps after which a trajectory is given up."""

    call: int = 500  # steps a call, milliseconds, after which Ctrl-C is noticed
    steep: int = 50_000  # without progress where formulas turn sharply: a contact may creep
    trajectory: int = 2_000_000  # of a trajectory, seconds: two hundred thousand vibrations
    segment: int = 4_500  # of a segment, since Newton's method needs hundreds: 800 vibrations
    progress: float = 1e-5  # fraction of the remainder that a call gains, except at a singularity

    @classmethod
    def is_exceeded(cls, maximum: int, taken: int, free: int, left: Array, gained: Array) -> bool:
        """Whether trajectories hardly gained in the last call, or will not end in most steps."""
        if np.any(gained < cls.progress * left):
            return True
        return taken >= free and not np.all(left * cls.call <= gained * (maximum - taken))


STOPPED = hy.taylor_outcome.step_limit
STEP_LIMIT, ARRIVED = int(STOPPED), int(hy.taylor_outcome.time_limit)
ALL_ARRIVED = np.ones(LANES, dtype=bool)


class Rest(Protocol):
    """Another method to continue one trajectory."""

    def is_due(self, single: Any) -> bool:
        """Whether the other method is faster from the present state on."""

    def through(self, single: Any, times: Array) -> Array:
        """Return the states of the remainder at some times, shape (m, n). Shapes: times (m,)."""


def run(integrate: Callable[..., Any], *given: Any, **named: Any) -> Any:
    """Integrate; heyoka refuses times that are no numbers, where a computation broke down."""
    try:
        return integrate(*given, **named)
    except ValueError as error:
        raise ArithmeticError(str(error)) from None


def arrive(batch: Any, ends: Array) -> Mask:
    """Integrate a batch to its ends, unless one of its trajectories exceeds the step budget.

    Return which lanes arrived. All lanes share one budget.
    """
    taken = 0
    while True:
        before = batch.time.copy()
        run(batch.propagate_until, ends, max_steps=BUDGET.call)
        if batch.time.tobytes() == ends.tobytes():  # in a tenth of the time of comparing numbers
            return ALL_ARRIVED
        free = BUDGET.steep if _turns(batch) else BUDGET.call
        # The times are sums of steps with rounding errors.
        arrived = np.abs(batch.time - ends) <= 4 * np.finfo(float).eps * (1 + np.abs(ends))
        if arrived.all() or STOPPED not in _outcomes(batch):
            return arrived
        taken += BUDGET.call
        left, gained = np.abs(ends - batch.time), np.abs(batch.time - before)
        if BUDGET.is_exceeded(BUDGET.segment, taken, free, left, gained):
            return arrived


def _turns(integrator: Any) -> bool:
    """Whether formulas turn sharply, which adds terminal events."""
    return integrator.with_events and bool(integrator.t_events)


def _outcomes(batch: Any) -> list[Any]:
    """Return how the last integration ended in each lane."""
    return [item[0] for item in batch.propagate_res]


def sampled(batch: Any, times: Array) -> Array:
    """Integrate a batch through given times; return its states, NaN beyond its end.

    Shapes: times (m, n_lanes); returns (m, n, n_lanes).
    """
    start = batch.state.copy()
    most = BUDGET.steep if _turns(batch) else BUDGET.call
    result = np.asarray(run(batch.propagate_grid, times, max_steps=most)[1])
    if (batch.time == times[-1]).all() or STOPPED not in _outcomes(batch):
        return result
    states = np.full((len(times), *start.shape), np.nan)
    batch.set_time(times[0])
    batch.state[:] = start
    for index, ends in enumerate(times):
        arrived = arrive(batch, ends)
        states[index] = np.where(arrived, batch.state, np.nan)
        if not arrived.any():
            break
    return states


def continue_to(single: Any, end: float, rest: Rest, *, steep: bool) -> int | None:
    """Integrate one trajectory to its end within the budget; return the last outcome.

    The outcome is None if the other method should continue.
    """
    free, taken = BUDGET.steep if steep else BUDGET.call, 0
    while True:
        if rest.is_due(single):
            return None
        before = float(single.time)
        outcome = int(run(single.propagate_until, end, max_steps=BUDGET.call)[0])
        if outcome != STEP_LIMIT:
            return outcome
        taken += BUDGET.call
        left, gained = np.array(abs(end - single.time)), np.array(abs(single.time - before))
        if BUDGET.is_exceeded(BUDGET.trajectory, taken, free, left, gained):
            return outcome


def pass_through(single: Any, times: Array, rest: Rest, *, patient: bool = True) -> Array:
    """Integrate one trajectory through given times; return its states, NaN after its end.

    Shapes: times (m,).
    """
    states = np.full((len(times), len(single.state)), np.nan)
    index = 0
    while index < len(times):
        left = times[index:]
        most = min(BUDGET.call * len(left), BUDGET.steep)
        outcome, *_, known = run(single.propagate_grid, left, max_steps=most)
        states[index : index + len(known)] = known
        index += len(known)
        if int(outcome) != STEP_LIMIT or index == len(times) or not patient:
            break
        outcome = continue_to(single, times[index], rest, steep=_turns(single))
        if outcome is None:
            states[index:] = rest.through(single, times[index:])
        if outcome in (None, STEP_LIMIT):
            break
    return states


@cache
def chunks(count: int) -> tuple[Any, ...]:
    """Return which trajectories go into the lanes of each batch; copies of the last one fill it."""
    lanes = np.minimum(np.arange(count + -count % LANES).reshape(-1, LANES), count - 1)
    whole = (slice(first, first + LANES) for first in range(0, count - LANES + 1, LANES))
    return (*whole, *lanes[count // LANES :])


def set_out(batch: Any, start: Array) -> None:
    """Set the initial phases."""
    run(batch.set_time, start)
    forget(batch)


def forget(integrator: Any) -> None:
    """Forget the events of the last run."""
    if integrator.with_events:
        integrator.reset_cooldowns()


def propagated(batch: Any, end: Array) -> Array:
    """Integrate a batch; return one row per lane, NaN if it did not arrive."""
    arrived, rows = arrive(batch, end), batch.state.T.copy()
    if arrived is not ALL_ARRIVED:
        rows[~arrived] = np.nan
    return np.asarray(rows)


def joined(batches: Sequence[Array], count: int) -> Array:
    """Return the rows of all batches but those that fill lanes."""
    return (batches[0] if len(batches) == 1 else np.concatenate(batches))[:count]
