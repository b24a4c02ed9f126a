"""Ensembles of trajectories, each with its own parameters, from one forcing period to the next."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import chain
from typing import Self

import numpy as np

from slipfold.arrays import Array, Mask
from slipfold.flow.equations import Constants
from slipfold.flow.explicit_steps import EXPLICIT, explicit_steps_of
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import GuardedFlow, GuardStop
from slipfold.flow.hybrid_flow import hybrid_system
from slipfold.flow.hybrid_trajectory import Broken, first_mode, smooth_phases
from slipfold.flow.modes import Status, reported_mode
from slipfold.flow.scales import measured, measured_within
from slipfold.flow.simulate import (
    LARGEST,
    HybridIntegration,
    limits_are_defined,
    reaches_stick_limit,
    unbounded_at,
)
from slipfold.models.angles import wrap_angles
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress
from slipfold.threads import cores


class BatchSteps:
    """Explicit steps of trajectories in a batch.

    Steps that are too long for some trajectories, or might meet a limit, are halved for these only.
    Their fraction determines the number of steps in the next period.
    """

    def __init__(self, model: Model, constants: Constants) -> None:
        self._steps = explicit_steps_of(model)
        self._n = n = len(model.states)
        known = np.atleast_2d(constants.known).T
        self._work = np.zeros((n + 2 + len(known), known.shape[1]))
        self._work[n + 2 :] = known
        self._values = np.empty((n + 1, known.shape[1]))
        # Four calls in the first period, if they are of four steps
        self._place = EXPLICIT.calls.index(4 * EXPLICIT.steps_per_call // self._steps.count)

    def period(self, states: Array) -> Array:
        """Propagate states over a forcing period; NaN where a trajectory is left behind.

        Shapes: states (n, m); returns (n, m).
        """
        return self._through(states, EXPLICIT.calls[self._place])[-1]

    def samples(self, states: Array, count: int) -> Array:
        """Return states at equal intervals of a period, from its start.

        Shapes: states (n, m); returns (count, n, m).
        """
        return self._through(states, count, every=True)[:-1]

    def _through(self, states: Array, calls: int, *, every: bool = False) -> Array:
        """Propagate states over a period in some calls; return the last states, or all."""
        n, work, values = self._n, self._work, self._values
        behind = np.zeros(states.shape[1], bool)
        result = np.empty((calls + 1 if every else 1, *states.shape))
        result[0] = states
        work[:n], work[n + 1], repeated, worst = states, 1 / (calls * self._steps.count), 0, 0.0
        for call in range(calls):
            work[n] = call / calls
            self._steps.function(work, outputs=values)
            error = float(values[n].max())
            if not error <= EXPLICIT.ensemble_tolerance:
                again = self._too_long(values) & ~behind
                error = float(values[n].max(initial=0.0, where=~again & ~behind))
                repeated += int(np.count_nonzero(again))
                self._halve(again, behind)
                values[:n, behind] = states[:, behind]
            worst = max(worst, error)
            work[:n] = values[:n]
            if every:
                result[call + 1] = values[:n]
                result[call + 1, :, behind] = np.nan
        if not every:
            self._pace(repeated / (calls * states.shape[1]), worst)
            result[0] = work[:n]
            result[0][:, behind] = np.nan
        return result

    def _halve(self, again: Mask, behind: Mask) -> None:
        """Repeat the last steps of some trajectories at half their length, and again if needed."""
        which = np.flatnonzero(again)
        ends, arrived = self._in_halves(self._work[:, which], 9)  # halvings until it is left behind
        self._values[: self._n, which] = ends
        behind[which[~arrived]] = True

    def _in_halves(self, work: Array, left: int) -> tuple[Array, Mask]:
        """Return the states after some steps, and for which trajectories they are accurate."""
        n = self._n
        arrived = np.full(work.shape[1], left > 0)
        if left == 0:
            return work[:n], arrived
        here = work.copy()
        here[n + 1] /= 2
        for _ in range(2):
            going = np.flatnonzero(arrived)
            part = np.ascontiguousarray(here[:, going])
            values = self._steps.function(part)
            again = np.flatnonzero(self._too_long(values))
            if len(again):
                redone, fine = self._in_halves(part[:, again], left - 1)
                values[:n, again] = redone
                arrived[going[again]] = fine
            here[:n, going] = values[:n]
            here[n] += here[n + 1] * self._steps.count
        return here[:n], arrived

    def _too_long(self, values: Array) -> Mask:
        return ~(values[self._n] <= EXPLICIT.ensemble_tolerance)

    def _pace(self, repeated: float, worst: float) -> None:
        """Choose the number of steps in the next period."""
        index = self._place
        if repeated > 0.2:  # of all calls, for single trajectories
            self._place = min(index + 1, len(EXPLICIT.calls) - 1)
        elif repeated < 0.02 and index > 0:
            longer = EXPLICIT.calls[index] / EXPLICIT.calls[index - 1]
            self._place -= 2 * worst * longer**EXPLICIT.order < EXPLICIT.ensemble_tolerance


class SingleTrajectory:
    """One trajectory, a few periods at a time.

    `stuck` says whether a contact stuck or was open in the last one.
    """

    def __init__(self, model: Model, constants: Constants, start: Array) -> None:
        self.model = model
        self.stopped: GuardStop | None = None
        self.stuck = False
        self._constants = constants
        # Without defined limits contacts may stick at any time.
        self._sticks = not limits_are_defined(model, start[None], constants)
        self._flow = GuardedFlow(model, constants, start)
        self._hybrid: HybridIntegration | None = None
        self._before = 0

    def advance(
        self,
        state: Array,
        periods: int,
        done: int = 0,
        report: Callable[[int], None] = lambda count: None,
    ) -> Array:
        """Propagate a state over some periods, after some that are done, as far as it comes.

        `report` is called with the number of periods now and then, until all are done.

        Shapes: state (n,); returns (m, n), m <= periods.
        """
        result = [state]
        while len(result) <= periods and self.stopped is None:
            so_far = done + len(result) - 1
            if self._hybrid is None and not self._sticks:
                result += self._slipping(result[-1], periods + 1 - len(result), so_far)
            else:
                result += self._through_stick(result[-1], so_far)
            if len(result) <= periods:
                report(len(result) - 1)
        return np.array(result[1:]).reshape(-1, len(state))

    def to_period_end(self, state: Array, phase: float) -> Array:
        """Propagate a state from a phase to the end of the period; NaN if it stops before.

        Shapes: state (n,); returns (n,).
        """
        if not self._sticks:
            states, self.stopped, _ = self._flow.to_period_end(state, phase)
            if self.stopped is None:
                return np.asarray(states[-1])
            if not reaches_stick_limit(self.stopped, self.model):
                return np.full_like(state, np.nan)
            self.stopped = None
        system = hybrid_system(self.model, state)
        mode = first_mode(system, state, phase)
        state = system.held(reported_mode(mode), state, phase)
        try:
            for smooth, _ in smooth_phases(system, mode, state, 1.0, begin=phase):
                state = smooth.state
        except Broken as broken:
            time = (broken.stop.time - phase) * self._constants.period
            self.stopped, state = replace(broken.stop, time=time), np.full_like(state, np.nan)
        return state

    def _slipping(self, state: Array, periods: int, done: int) -> list[Array]:
        result = list[Array]()
        for piece in self._flow.pieces(state, periods, done):
            result += list(piece.states)
            if piece.stop is not None and reaches_stick_limit(piece.stop, self.model):
                last = result[-1] if result else state
                return result + self._through_stick(last, done + len(result))
            self.stopped = piece.stop
        self.stuck = False
        return result

    def _through_stick(self, state: Array, done: int) -> list[Array]:
        """Propagate a state over a period in which a contact may stick."""
        if self._hybrid is None:
            self._hybrid, self._before = HybridIntegration(self.model, state), done
            self._hybrid.kept = 1
        trajectory = self._hybrid
        trajectory.advance(1)
        if trajectory.stopped is not None:
            later = self._before * trajectory.constants.period
            self.stopped = replace(trajectory.stopped, time=trajectory.stopped.time + later)
            return []
        seen = chain.from_iterable(trajectory.recorder.modes)
        self.stuck = any(status in (Status.STICK, Status.OPEN) for status in seen)
        if not self.stuck and not self._sticks:
            self._hybrid = None  # the next period may have no events
        return [trajectory.states[-1]]


def released(model: Model, starts: Array, phases: Array) -> tuple[Array, dict[int, GuardStop]]:
    """Return the states at the end of the period, and stops of trajectories by index.

    States of stopped trajectories are NaN. Contacts may stick. Shapes: starts (k, n); phases (k,),
    from 0 to 1; returns (k, n).
    """
    result, stops = starts.copy(), dict[int, GuardStop]()
    constants = flow_of(model).constants_of(model)
    for index in np.flatnonzero((phases > 0) & (phases < 1)).tolist():
        own = SingleTrajectory(model, constants, starts[index])
        result[index] = own.to_period_end(starts[index], float(phases[index]))
        if own.stopped is not None:
            stops[index] = own.stopped
    return result, stops


class Ensemble:
    """Trajectories from one forcing period to the next; a context with a pool of threads.

    They take steps in batches while they can, and continue individually where contacts stick.
    """

    def __init__(self, models: list[Model], starts: Array, threads: int | None = None) -> None:
        self._models, self._states = models, starts.copy()
        count, first, flow = len(models), models[0], flow_of(models[0])
        self._ends: list[GuardStop | None] = [None] * count
        self.stuck = np.zeros(count, bool)  # whether a contact stuck or was open in the last period
        self._left = np.zeros(count, bool)
        self._over = np.zeros(count, bool)  # which have stopped
        self._scales = flow.constants_of(first).scales
        parameters = np.array([model.vector for model in models])
        self._constants = flow.constants(parameters, np.tile(self._scales, (count, 1)))
        self._own: dict[int, SingleTrajectory] = {}
        self._done = 0
        self._batches = list[tuple[slice, BatchSteps | None]]()
        for begin in range(0, count, EXPLICIT.ensemble_batch):
            rows = slice(begin, min(begin + EXPLICIT.ensemble_batch, count))
            constants = self._constants.rows(np.arange(rows.start, rows.stop))
            # Without defined limits contacts may stick at any time.
            slips = limits_are_defined(first, starts[rows], constants)
            self._batches.append((rows, BatchSteps(first, constants) if slips else None))
        self._pool = ThreadPoolExecutor(min(threads or cores(), len(self._batches)))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._pool.shutdown()

    @property
    def states(self) -> Array:
        """Present states, NaN of trajectories that stopped, shape (k, n)."""
        return self._states.copy()

    @property
    def stopped(self) -> tuple[GuardStop | None, ...]:
        """Why and when each trajectory ended early."""
        return tuple(self._ends)

    def advance(self) -> None:
        """Propagate all trajectories over a period."""
        if len(self._batches) == 1:  # without another thread
            self._advance(self._batches[0])
        else:
            list(self._pool.map(self._advance, self._batches))
        self._done += 1

    def move(self, states: Array) -> None:
        """Replace states of trajectories; NaN keeps a state. Shapes: states (k, n)."""
        moved = np.isfinite(states).all(axis=1)
        self._states[moved] = states[moved]

    def leave(self, which: Mask) -> None:
        """Stop some trajectories. Shapes: which (k,)."""
        self._left |= which

    def _advance(self, batch: tuple[slice, BatchSteps | None]) -> None:
        """Propagate the trajectories of a batch over a period."""
        rows, steps = batch
        before, left = self._states[rows].T, self._left[rows]
        over = left | self._over[rows]
        if over.all():
            return
        alone = over | self.stuck[rows]
        # Trajectories that continue individually keep their rows, filled with another state.
        going = np.flatnonzero(~alone)
        after = np.full_like(before, np.nan)
        if steps is not None and len(going):
            after = steps.period(np.where(alone, before[:, going[:1]], before))
            after[:, alone] = np.nan
            after[:, np.abs(after / self._scales[:, None]).max(axis=0) > LARGEST] = np.nan
        missing = np.isnan(after).any(axis=0)
        self.stuck[rows] &= missing | left
        after[:, left] = before[:, left]
        for lane in np.flatnonzero(missing & ~over):
            after[:, lane] = self._alone(rows.start + int(lane), before[:, lane])
        self._states[rows] = wrap_angles(after.T, self._models[0].angle_periods)

    def _alone(self, row: int, state: Array) -> Array:
        if row not in self._own:
            self._own[row] = SingleTrajectory(self._models[row], self._constants.rows(row), state)
        own, after = self._own[row], np.full_like(state, np.nan)
        for reached in own.advance(state, 1, self._done):
            after = reached
        size = np.abs(after / self._scales).max()
        if own.stopped is None and not size <= LARGEST:
            time = (self._done + 1) * self._constants.rows(row).period
            own.stopped, after = unbounded_at(time, size), np.full_like(after, np.nan)
        self._ends[row], self.stuck[row] = own.stopped, own.stuck
        self._over[row] = own.stopped is not None
        return after


@dataclass(frozen=True, eq=False)
class StroboscopicSamples:
    """States of many trajectories at phase zero of each forcing period."""

    # Shape (k, periods + 1, n); NaN from where a trajectory stopped or was interrupted
    states: Array
    stopped: tuple[GuardStop | None, ...]  # why and when each trajectory ended early, length k
    # Whether a contact stuck or was open in the period before each point, shape (k, periods + 1)
    stuck: Mask
    interrupted: bool = False


def stroboscopic_samples(
    model: Model,
    starts: Array,
    values: Mapping[str, Array] | None = None,
    periods: int = 1000,
    observer: Observer | None = None,
    *,
    transient: int = 0,
    threads: int | None = None,
) -> StroboscopicSamples:
    """Follow trajectories from many starts; each may have parameter values of its own.

    A trajectory with stick continues individually; one at another limit stops with a reason. The
    first stored point is that after `transient` periods. Periods of an autonomous model are
    intervals of its duration. With an observer an interruption keeps results so far.

    Shapes: starts (k, n); values (k,) each.
    """
    models, shape = models_with(model, len(starts), values or {}), (len(starts), periods + 1)
    states, stuck = np.full((*shape, starts.shape[1]), np.nan), np.zeros(shape, bool)
    total, interrupted = len(starts) * (transient + periods), False
    with Ensemble(models, starts, threads) as ensemble:
        try:
            for period in range(transient + periods + 1):
                if period:
                    ensemble.advance()
                    if observer is not None:
                        observer(Progress("forcing periods", period * len(starts), total))
                if period >= transient:
                    states[:, period - transient] = ensemble.states
                    stuck[:, period - transient] = ensemble.stuck
        except KeyboardInterrupt:
            if observer is None:
                raise
            interrupted = True
        return StroboscopicSamples(states, ensemble.stopped, stuck, interrupted)


def models_with(model: Model, count: int, values: Mapping[str, Array]) -> list[Model]:
    """Return the model of each trajectory."""
    if not values:
        return [measured(model)] * count
    each = zip(*values.values(), strict=True)
    rows = [dict(zip(values, map(float, row), strict=True)) for row in each]
    model = measured_within(model, [rows[0], rows[count // 2], rows[-1]])
    return [model.replace(**row) for row in rows]
