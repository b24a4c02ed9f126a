"""Points of trajectories over a parameter: swept up and down, and from many starts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.ensembles import SingleTrajectory, models_with, stroboscopic_samples
from slipfold.flow.explicit_steps import EXPLICIT
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress

UP, DOWN = "up", "down"

NOT_DONE = "not done"
"""Why a run has no points where an interruption came before."""


@dataclass(eq=False)
class SweepRun:
    """Sweeps up, then down from the last state; each value starts from the previous state.

    Then all values are followed from further starts.
    """

    model: Model
    vary: str
    values: Array  # increasing, shape (m,)
    runs: tuple[str, ...]
    start: Array  # shape (n,)
    starts: Array  # each for all values, shape (k, n)
    transient: int
    kept: int  # states of each trajectory at phase zero
    observer: Observer | None = None

    def __post_init__(self) -> None:
        """Prepare arrays for what is to be found."""
        self.models = models_with(self.model, len(self.values), {self.vary: self.values})
        self.model = self.model.with_scales(self.models[0].estimated_scales)
        numbers = range(1, len(self.starts) + 1)
        self.names = (*self.runs, *(f"start {number}" for number in numbers))
        shape = len(self.names), len(self.values)
        self.states = np.full((*shape, self.kept, len(self.start)), np.nan)  # at phase zero
        self.stuck = np.zeros(shape, bool)  # whether it stuck or was open at the end
        self.reasons = np.full(shape, NOT_DONE, object)  # why there are no points
        self.total = shape[0] * shape[1] * (self.transient + self.kept - 1)
        self.done = 0

    def run(self) -> bool:
        """Follow all trajectories; return whether that was interrupted, which keeps those done."""
        try:
            self._run()
        except KeyboardInterrupt:
            return True
        return False

    def _run(self) -> None:
        state = self.start
        for run, name in enumerate(self.runs):
            order = list(range(len(self.values)))
            if name == DOWN:
                order.reverse()
                if run:  # only from the final state of the sweep up
                    order = [index for index in order if not self.reasons[0, index]]
            state = self._sweep(run, order, state)
        count = max(EXPLICIT.ensemble_batch // len(self.values), 1)
        for first in range(0, len(self.starts), count):
            self._from_starts(len(self.runs) + first, self.starts[first : first + count])

    def _sweep(self, run: int, order: list[int], state: Array) -> Array:
        reason = ""
        for index in order:
            if not reason:
                before, periods = self.done, self.transient + self.kept - 1
                reason, state = self._at(run, index, state)
                self._report(before, periods)
            self.reasons[run, index] = reason
        return state

    def _at(self, run: int, index: int, state: Array) -> tuple[str, Array]:
        """Integrate at one value; return why it stopped, if it did, and the final state."""
        model, periods = self.models[index], self.transient + self.kept - 1
        trajectory = SingleTrajectory(model, flow_of(model).constants_of(model), state)
        report = partial(self._report, self.done)
        result = np.concatenate([state[None], trajectory.advance(state, periods, report=report)])
        if trajectory.stopped is not None:
            return trajectory.stopped.reason, state
        self.states[run, index] = result[-self.kept :]
        self.stuck[run, index] = trajectory.stuck
        return "", result[-1]

    def _from_starts(self, first: int, starts: Array) -> None:
        """Follow trajectories from some starts, whose runs are those from `first` on."""
        before, count = self.done, len(starts)
        points = stroboscopic_samples(
            self.models[0],
            np.repeat(starts, len(self.values), axis=0),
            {self.vary: np.tile(self.values, count)},
            self.kept - 1,
            None if self.observer is None else lambda now: self._report(before, now.done),
            transient=self.transient,
        )
        if points.interrupted:
            raise KeyboardInterrupt
        shape, rows = (count, len(self.values)), slice(first, first + count)
        self.states[rows] = points.states.reshape(*shape, self.kept, -1)
        self.stuck[rows] = points.stuck[:, -1].reshape(shape)
        reasons = ["" if stop is None else stop.reason for stop in points.stopped]
        self.reasons[rows] = np.array(reasons, object).reshape(shape)

    def _report(self, before: int, periods: int) -> None:
        self.done = before + periods
        if self.observer is not None:
            self.observer(Progress("forcing periods", self.done, self.total))
