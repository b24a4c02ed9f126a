"""Thresholds on a grid: a few side by side, the others in batches from their neighbours."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.thresholds.batched_thresholds import BatchedThresholds, Found
from slipfold.thresholds.grid_lines import Stencil, refinements, seed_lines, stencils
from slipfold.thresholds.side_by_side import proved_doublings
from slipfold.thresholds.stable_segment import SHARES, Segments
from slipfold.thresholds.threshold_by_response import (
    NO_THRESHOLD,
    OnePoint,
    lasting_reason,
    threshold_by_response,
)

INTERRUPTED = "interrupted"

CONTRADICTION = "contradictory parameters"

TOGETHER = 1024
"""Points that are guessed and corrected in one go, at least a line."""

ATTEMPTS = 2
"""Guesses from different neighbours that are tried before the response is followed."""


class ThresholdSearch:
    """Thresholds of all points of a grid, being found.

    Every array has the grid's two axes first.

    `places` are the values of the parameters `axes`, each increasing; `report` is called whenever
    some more points are done.
    """

    def __init__(
        self,
        model: Model,
        vary: str,
        axes: tuple[str, str],
        places: tuple[Array, Array],
        span: tuple[float, float],
        report: Callable[[ThresholdSearch], None],
    ) -> None:
        self.model, self.vary, self.axes, self.places, self.span = model, vary, axes, places, span
        self.report = report
        self.batches = BatchedThresholds(model, vary, span)
        shape, n = (len(places[0]), len(places[1])), len(model.states)
        self.parameters = np.tile(model.vector, (*shape, 1))
        self.parameters[..., model.parameter_index(axes[0])] = places[0][:, None]
        self.parameters[..., model.parameter_index(axes[1])] = places[1]
        self.scales = np.full((*shape, n), np.nan)
        self.kinds = np.full(shape, INTERRUPTED, dtype=object)
        self.reasons = np.full(shape, "interrupted before this point was reached", dtype=object)
        self.values = np.full(shape, np.nan)
        self.multipliers = np.full((*shape, n), complex(np.nan, np.nan))
        self.residuals = np.full(shape, np.nan)
        self.followed = np.full(shape, False)
        # What guesses are made from: NaN where there is nothing to go by.
        self.segments = Segments(np.full(shape, np.nan), np.full((*shape, len(SHARES), n), np.nan))
        self.states = np.full((*shape, n), np.nan)

    def run(self) -> None:
        """Find all thresholds; an interruption leaves the points that were not reached."""
        try:
            self._set_up()
            self._sow()
            for axis, known, new, others in refinements(self.values.shape):
                count = max(TOGETHER // len(others), 1)
                for first in range(0, len(new), count):
                    self._fill(axis, known, new[first : first + count], others)
        except KeyboardInterrupt:
            pass

    def _set_up(self) -> None:
        """Take the scales at all points, and note where parameters contradict each other."""
        for at in np.ndindex(self.kinds.shape):
            try:
                self.scales[at] = self._model(at).state_scales()
            except InputError as error:
                self.kinds[at], self.reasons[at] = CONTRADICTION, str(error)

    def _model(self, at: tuple[int, ...]) -> Model:
        values = {
            name: places[i] for name, places, i in zip(self.axes, self.places, at, strict=True)
        }
        return self.model.replace(**values, **{self.vary: self.span[0]})

    def _sow(self) -> None:
        """Find the thresholds that all others are guessed from."""
        first, second = (seed_lines(len(places)) for places in self.places)
        seeds = [(int(i), int(j)) for i in first for j in second]
        ready = [at for at in seeds if self.kinds[at] == INTERRUPTED]
        if ready:
            models = [self._model(at) for at in ready]
            some, found = proved_doublings(self.batches, models, self.vary)
            rows, columns = np.array(ready)[some].T
            self._accept(found, (rows, columns))
            self.report(self)
        self._follow([at for at in ready if self.kinds[at] == INTERRUPTED])

    # -- lines of the grid from known ones -------------------------------------------------------

    def _fill(self, axis: int, known: Indices, new: Indices, others: Indices) -> None:
        """Find the thresholds on new lines; what comes first on each is guessed first."""
        rows, columns = np.repeat(new, len(others)), np.tile(others, len(new))
        if axis == 1:
            rows, columns = columns, rows
        attempts = np.zeros(len(rows), dtype=np.int64)
        ways = [stencils(self.places[axis], known, int(line)) for line in new]
        for way in range(max(map(len, ways))):
            for kind, solve in (("", self.batches.doublings), (NO_THRESHOLD, self.batches.lasting)):
                waiting = self.kinds[rows, columns] == INTERRUPTED
                if not waiting.any():
                    break
                guess = self._guesses(axis, [item[way : way + 1] for item in ways], others, kind)
                some = np.flatnonzero(waiting & np.isfinite(guess.ends) & (attempts < ATTEMPTS))
                if len(some):
                    attempts[some] += 1
                    at = rows[some], columns[some]
                    self._accept(solve(self.parameters[at], self.scales[at], guess.of(some)), at)
        self.report(self)
        left = np.flatnonzero(self.kinds[rows, columns] == INTERRUPTED)
        self._follow([(int(rows[i]), int(columns[i])) for i in left])

    def _guesses(
        self, axis: int, ways: Sequence[Sequence[Stencil]], others: Indices, kind: str
    ) -> Segments:
        """Guess the stable parts on lines, one way each, one line after the other."""
        # The axis that is refined comes first.
        kinds, ends, paths = (
            item.swapaxes(0, axis) for item in (self.kinds, self.segments.ends, self.segments.paths)
        )
        shape = len(ways), len(others)
        found = Segments(np.full(shape, np.nan), np.full((*shape, *paths.shape[2:]), np.nan))
        usable = (kinds == kind) & np.isfinite(paths).all(axis=(2, 3))
        for line, way in enumerate(ways):
            for stencil in way:
                where = np.ix_(stencil.lines, others)
                good = usable[where].all(axis=0)
                found.ends[line, good] = (stencil.weights @ ends[where])[good]
                found.paths[line] = np.tensordot(stencil.weights, paths[where], axes=1)
        return Segments(found.ends.ravel(), found.paths.reshape(-1, *paths.shape[2:]))

    def _accept(self, found: Found, where: tuple[Indices, Indices]) -> None:
        """Keep what was proved."""
        for mask, kind, reason in (
            (found.loses, "", ""),
            (found.lasts, NO_THRESHOLD, lasting_reason(self.vary, self.span[1])),
        ):
            rows, columns = where[0][mask], where[1][mask]
            self.kinds[rows, columns], self.reasons[rows, columns] = kind, reason
            self.segments.ends[rows, columns] = found.segments.ends[mask]
            self.segments.paths[rows, columns] = found.segments.paths[mask]
        rows, columns = where[0][found.loses], where[1][found.loses]
        self.values[rows, columns] = found.segments.ends[found.loses]
        self.states[rows, columns] = found.segments.paths[found.loses, -1]
        self.multipliers[rows, columns] = found.multipliers[found.loses]
        self.residuals[rows, columns] = found.residuals[found.loses]

    # -- points by themselves --------------------------------------------------------------------

    def _follow(self, points: list[tuple[int, int]]) -> None:
        """Follow the response of each point to where it loses its stability."""
        for at in points:
            found = threshold_by_response(self._model(at), self.vary, self.span)
            self._keep_point(at, found)
            self.report(self)

    def _keep_point(self, at: tuple[int, int], found: OnePoint) -> None:
        self.kinds[at], self.reasons[at] = found.kind, found.reason
        self.followed[at] = True
        if not found.kind:
            self.values[at], self.residuals[at] = found.value, found.residual
            self.states[at], self.multipliers[at] = found.states[-1], found.multipliers
        if np.isnan(found.value):
            return
        first = self.span[0]
        shares = (found.values - first) / (found.value - first)
        path = np.array([np.interp(SHARES, shares, column) for column in found.states.T]).T
        guess = Segments(np.array([found.value]), path[None])
        paths, _ = self.batches.walk(self.parameters[at][None], self.scales[at][None], guess)
        self.segments.ends[at], self.segments.paths[at] = found.value, paths[0]
