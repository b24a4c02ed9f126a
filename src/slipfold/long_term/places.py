"""Motions followed side by side at many values of parameters, and what each of them does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.ensembles import Crowd, models_with
from slipfold.flow.equilibrium import PUSH
from slipfold.long_term.open_motions import (
    PERIODIC,
    PERIODS,
    STICKS,
    STOPPED,
    UNDECIDED,
    tell_open,
)
from slipfold.long_term.repeats import FLOOR, repeats_of
from slipfold.models.model import Model
from slipfold.models.turns import mean_state, without_turns
from slipfold.progress import Observer, Progress

NOT_DONE = "not done"

OPEN = "open"
"""Of a motion that is to be followed for longer."""

KEPT = 48
"""Periods after the transient in which a motion is seen to repeat."""

STUCK = 32
"""Periods in which a contact stuck after which a motion is not followed any further."""

TOGETHER = 2048
"""Motions that are followed together: between them an interruption loses nothing."""


@dataclass(frozen=True, eq=False)
class Judged:
    """What motions do, as far as it is known; shapes (k, ...)."""

    kinds: NDArray[np.object_]
    periods: NDArray[np.int64]
    exponents: Array
    states: Array
    means: Array
    changes: Array  # of the state over the period, in scales; NaN where it was not seen

    def put(self, rows: NDArray[np.intp], others: Judged) -> None:
        """Replace some of them."""
        for name, values in vars(others).items():
            getattr(self, name)[rows] = values

    def rows(self, rows: NDArray[Any]) -> Judged:
        """Return some of them."""
        return Judged(*(values[rows] for values in vars(self).values()))


class Places:
    """Motions at many values of parameters, in one run or several; what is known of them so far."""

    def __init__(
        self,
        model: Model,
        values: Mapping[str, Array],
        runs: int,
        start: Array,
        transient: int,
        observer: Observer | None,
    ) -> None:
        count = len(next(iter(values.values())))
        self.models = models_with(model, count, values)
        self.model = model.measured_in(self.models[0].found_sizes)
        self.scales = self.models[0].state_scales()
        # Off a motion that symmetry would keep unstable.
        self.start = start + PUSH * self.scales
        self.transient, self.observer = transient, observer
        shape, n = (runs, count), len(start)
        self.kinds = np.full(shape, NOT_DONE, object)
        self.periods = np.zeros(shape, np.int64)
        self.exponents = np.full(shape, np.nan)
        self.states, self.means = np.full((2, *shape, n), np.nan)
        self.changes = np.full(shape, np.nan)
        self.done, self.total = 0, runs * count * self.periods_of_a_motion

    @property
    def periods_of_a_motion(self) -> int:
        """Forcing periods after which each motion is judged."""
        return self.transient + KEPT

    def from_rest(self, run: int) -> None:
        """Follow a motion from the start in each place."""
        cells = np.arange(len(self.models))
        for first in range(0, len(cells), TOGETHER):
            some = cells[first : first + TOGETHER]
            self.follow(run, some, np.tile(self.start, (len(some), 1)))

    def follow(self, run: int, cells: NDArray[np.intp], starts: Array) -> Array:
        """Follow a motion in some places; return their last states, or the start if they ended."""
        found = self._followed(cells, starts)
        self.store(run, cells, found)
        self.store(run, cells, self._seen_again(cells, found))
        return np.where(np.isnan(found.states).any(axis=1, keepdims=True), self.start, found.states)

    def judged(self, cells: NDArray[np.intp], starts: Array) -> Judged:
        """Follow motions in some places, and say what they do; none of it is stored."""
        return self._seen_again(cells, self._followed(cells, starts))

    def _seen_again(self, cells: NDArray[np.intp], found: Judged) -> Judged:
        """Follow what still comes nearer to a response once more: past a saddle it leaves again."""
        nearer = np.flatnonzero((found.periods > 0) & (found.changes > FLOOR))
        if len(nearer):
            self.total += len(nearer) * self.periods_of_a_motion
            found.put(nearer, self._followed(cells[nearer], found.states[nearer]))
        return found

    def _followed(self, cells: NDArray[np.intp], starts: Array) -> Judged:
        """Follow motions once."""
        models = [self.models[cell] for cell in cells]
        total = self.periods_of_a_motion
        window = np.full((KEPT + 1, *starts.shape), np.nan)
        stuck = np.zeros(len(cells), np.int64)
        sticks = np.zeros(len(cells), bool)
        with Crowd(models, starts) as crowd:
            for period in range(1, total + 1):
                crowd.go_on()
                stuck += crowd.stuck
                crowd.leave(stuck >= STUCK)
                if period > self.transient:
                    sticks |= crowd.stuck
                if period >= self.transient:
                    window[period - self.transient] = crowd.states
                self._tell(len(cells))
            states = crowd.states
            stopped = np.array([stop is not None for stop in crowd.stopped])
        window[:, stuck >= STUCK] = np.nan  # they were left where they were
        return self._judge(window, np.where(stopped[:, None], np.nan, states), sticks)

    def store(self, run: int | NDArray[np.intp], cells: NDArray[np.intp], found: Judged) -> None:
        """Store what motions of one run, or of a run each, do in some places."""
        for name, values in vars(found).items():
            getattr(self, name)[run, cells] = values

    def stored(self, run: NDArray[np.intp], cells: NDArray[np.intp]) -> Judged:
        """Return what is known of motions."""
        names = Judged.__dataclass_fields__
        return Judged(*(getattr(self, name)[run, cells] for name in names))

    def add_run(self, kind: str) -> None:
        """Add a run whose motions are of one kind until something is stored."""
        self.kinds = np.concatenate([self.kinds, np.full_like(self.kinds[:1], kind)])
        self.periods = np.concatenate([self.periods, np.zeros_like(self.periods[:1])])
        for name in ("exponents", "states", "means", "changes"):
            known = getattr(self, name)
            setattr(self, name, np.concatenate([known, np.full_like(known[:1], np.nan)]))

    def _judge(self, window: Array, states: Array, sticks: NDArray[np.bool_]) -> Judged:
        """Say what motions do, as far as they repeat, stick or stopped."""
        whole_turns = self.models[0].whole_turns
        periods = repeats_of(window.transpose(1, 0, 2), self.scales, whole_turns)
        before = window[-1 - periods, np.arange(len(states))]
        apart = without_turns(window[-1] - before, whole_turns) / self.scales
        kinds = np.full(len(states), OPEN, object)
        kinds[periods > 0] = PERIODIC
        kinds[sticks] = STICKS
        kinds[np.isnan(states).any(axis=1)] = STOPPED
        means = np.full_like(states, np.nan)
        for row in np.flatnonzero(periods):
            means[row] = mean_state(window[-periods[row] :, row], whole_turns)
        exponents, changes = np.full(len(states), np.nan), np.abs(apart).max(axis=1)
        return Judged(kinds, periods, exponents, states, means, changes)

    def tell_open(self) -> None:
        """Look longer at motions that neither repeat nor stick, of all runs together."""
        runs, cells = np.nonzero(self.kinds == OPEN)
        self.total += 2 * len(cells) * PERIODS[0]
        for first in range(0, len(cells), TOGETHER):
            run, cell = runs[first : first + TOGETHER], cells[first : first + TOGETHER]
            found, interrupted = self.judged_open(cell, self.states[run, cell])
            known = (found.kinds != UNDECIDED) | (not interrupted)
            self.store(run[known], cell[known], found.rows(known))
            if interrupted:
                raise KeyboardInterrupt

    def judged_open(self, cells: NDArray[np.intp], states: Array) -> tuple[Judged, bool]:
        """Look longer at motions; return what they do, and whether that was interrupted."""
        told = tell_open([self.models[cell] for cell in cells], states, self._tell_pairs)
        changes = np.full(len(cells), np.nan)
        parts = told.kinds, told.periods, told.exponents, told.states, told.means, changes
        return Judged(*parts), told.interrupted

    def _tell(self, periods: int) -> None:
        self.done += periods
        if self.observer is not None:
            self.observer(Progress("forcing periods", self.done, max(self.total, self.done)))

    def _tell_pairs(self, periods: int, more: int) -> None:
        self.total += more
        self._tell(periods)

    @property
    def told_kinds(self) -> NDArray[np.str_]:
        """What the motions do, as far as that is known."""
        return np.where(self.kinds == OPEN, NOT_DONE, self.kinds).astype(str)
