"""Motions followed side by side at many values of parameters, and what each of them does."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.equilibrium import PUSH
from slipfold.flow.strobes.crowd import Crowd
from slipfold.flow.strobes.strobe_many import StrobeProgress, models_with
from slipfold.long_term.open_motions import (
    PERIODIC,
    PERIODS,
    STICKS,
    STOPPED,
    UNDECIDED,
    tell_open,
)
from slipfold.long_term.repeats import repeats_of
from slipfold.models.model import Model
from slipfold.models.turns import mean_state

__all__ = ["NOT_DONE", "Places"]

Array = NDArray[np.float64]

NOT_DONE = "not done"

OPEN = "open"
"""Of a motion that is to be followed for longer."""

KEPT = 48
"""Periods after the transient in which a motion is seen to repeat."""

STUCK = 32
"""Periods in which a contact stuck after which a motion is not followed any further."""

TOGETHER = 2048
"""Cells from rest that are followed together: between them an interruption loses nothing."""


class Places:
    """Motions at many values of parameters, in one run or several; what is known of them so far."""

    def __init__(
        self,
        model: Model,
        values: Mapping[str, Array],
        runs: int,
        start: Array,
        transient: int,
        observer: Callable[[StrobeProgress], None] | None,
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
        self.done, self.total = 0, runs * count * (transient + KEPT)

    def from_rest(self, run: int) -> None:
        """Follow a motion from the start in each place."""
        cells = np.arange(len(self.models))
        for first in range(0, len(cells), TOGETHER):
            some = cells[first : first + TOGETHER]
            self.follow(run, some, np.tile(self.start, (len(some), 1)))

    def follow(self, run: int, cells: NDArray[np.intp], starts: Array) -> Array:
        """Follow a motion in some places; return where they came to, or the start if nowhere."""
        models = [self.models[cell] for cell in cells]
        total = self.transient + KEPT
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
        self._judge(run, cells, window, np.where(stopped[:, None], np.nan, states), sticks)
        return np.where(stopped[:, None], self.start, states)

    def _judge(
        self,
        run: int,
        cells: NDArray[np.intp],
        window: Array,
        states: Array,
        sticks: NDArray[np.bool_],
    ) -> None:
        """Say what the motions of some cells do, as far as they repeat, stick or stopped."""
        whole_turns = self.models[0].whole_turns
        periods = repeats_of(window.transpose(1, 0, 2), self.scales, whole_turns)
        kinds = np.full(len(cells), OPEN, object)
        kinds[periods > 0] = PERIODIC
        kinds[sticks] = STICKS
        kinds[np.isnan(states).any(axis=1)] = STOPPED
        means = np.full((len(cells), window.shape[2]), np.nan)
        for row in np.flatnonzero(periods):
            means[row] = mean_state(window[-periods[row] :, row], whole_turns)
        self.kinds[run, cells], self.periods[run, cells] = kinds, periods
        self.states[run, cells], self.means[run, cells] = states, means

    def tell_open(self) -> None:
        """Look longer at motions that neither repeat nor stick, of all runs together."""
        runs, cells = np.nonzero(self.kinds == OPEN)
        self.total += 2 * len(cells) * PERIODS[0]
        for first in range(0, len(cells), TOGETHER):
            run, cell = runs[first : first + TOGETHER], cells[first : first + TOGETHER]
            models = [self.models[each] for each in cell]
            told = tell_open(models, self.states[run, cell], self._tell_pairs)
            known = (told.kinds != UNDECIDED) | (not told.interrupted)
            at = run[known], cell[known]
            self.kinds[at], self.periods[at] = told.kinds[known], told.periods[known]
            self.exponents[at] = told.exponents[known]
            self.states[at], self.means[at] = told.states[known], told.means[known]
            if told.interrupted:
                raise KeyboardInterrupt

    def _tell(self, periods: int) -> None:
        self.done += periods
        if self.observer is not None:
            self.observer(StrobeProgress(self.done, max(self.total, self.done)))

    def _tell_pairs(self, periods: int, more: int) -> None:
        self.total += more
        self._tell(periods)

    @property
    def told_kinds(self) -> NDArray[np.str_]:
        """What the motions do, as far as that is known."""
        return np.where(self.kinds == OPEN, NOT_DONE, self.kinds).astype(str)
