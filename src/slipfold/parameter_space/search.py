"""Thresholds on a grid: some from their responses, the others in batches from their neighbors."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.continuation.interpolation import polynomial_weights
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.parameter_space.batch import (
    FRACTIONS,
    BatchedThresholds,
    Found,
    Paths,
    proved_doublings,
)
from slipfold.parameter_space.loss import NO_THRESHOLD, lasting_reason, threshold_by_response

INTERRUPTED = "interrupted"

SEEDS = 6
"""Lines an axis begins with, and from which a line is guessed: a polynomial of degree five."""

TOGETHER = 1024
"""Points that are guessed and corrected in one batch, at least a line."""

ATTEMPTS = 2
"""Guesses from different neighbors that are tried before the response is followed."""


class ThresholdSearch:
    """Thresholds of all points of a grid while they are computed.

    Every array has the grid's two axes first. `values` are those of the parameters `axes`, each
    increasing; `report` is called whenever more points are done.
    """

    def __init__(
        self,
        model: Model,
        vary: str,
        axes: tuple[str, str],
        values: tuple[Array, Array],
        span: tuple[float, float],
        report: Callable[[ThresholdSearch], None],
    ) -> None:
        self.model, self.vary, self.axes, self.values, self.span = model, vary, axes, values, span
        self.report = report
        self._batch = BatchedThresholds(model, vary, span)
        shape, n = (len(values[0]), len(values[1])), len(model.states)
        self._parameters = np.tile(model.vector, (*shape, 1))
        self._parameters[..., model.parameter_index(axes[0])] = values[0][:, None]
        self._parameters[..., model.parameter_index(axes[1])] = values[1]
        self._scales = np.full((*shape, n), np.nan)
        self.kinds = np.full(shape, INTERRUPTED, dtype=object)
        self.reasons = np.full(shape, "interrupted before this point was reached", dtype=object)
        self.multipliers = np.full((*shape, n), complex(np.nan, np.nan))
        self.residuals = np.full(shape, np.nan)
        self.followed = np.full(shape, False)
        # Guesses are made from these; NaN where there is no stable part.
        self.ends = np.full(shape, np.nan)
        self.states = np.full((*shape, len(FRACTIONS), n), np.nan)

    def run(self) -> None:
        """Find all thresholds; an interruption leaves the points that were not reached."""
        try:
            self._set_up()
            self._find_seeds()
            for axis, known, new, others in refinements(self.kinds.shape):
                count = max(TOGETHER // len(others), 1)
                for first in range(0, len(new), count):
                    self._fill(axis, known, new[first : first + count], others)
        except KeyboardInterrupt:
            pass

    def _set_up(self) -> None:
        """Take the scales at all points, and note where parameters contradict each other."""
        for at in np.ndindex(self.kinds.shape):
            try:
                self._scales[at] = self._model(at).state_scales()
            except InputError as error:
                self.kinds[at], self.reasons[at] = "contradictory parameters", str(error)

    def _model(self, at: tuple[int, ...]) -> Model:
        own = {name: each[i] for name, each, i in zip(self.axes, self.values, at, strict=True)}
        return self.model.replace(**own, **{self.vary: self.span[0]})

    def _find_seeds(self) -> None:
        """Find the thresholds that all others are guessed from."""
        first, second = (seed_lines(len(values)) for values in self.values)
        seeds = [(int(i), int(j)) for i in first for j in second]
        ready = [at for at in seeds if self.kinds[at] == INTERRUPTED]
        if ready:
            models = [self._model(at) for at in ready]
            some, found = proved_doublings(self._batch, models, self.vary)
            if found is not None:
                rows, columns = np.array(ready)[some].T
                self._accept(found, (rows, columns))
            self.report(self)
        self._follow(ready)

    def _fill(self, axis: int, known: Indices, new: Indices, others: Indices) -> None:
        """Find the thresholds on new lines, most of them from guesses."""
        rows, columns = np.repeat(new, len(others)), np.tile(others, len(new))
        if axis == 1:
            rows, columns = columns, rows
        attempts = np.zeros(len(rows), dtype=np.int64)
        stencils = [stencils_of(self.values[axis], known, int(line)) for line in new]
        for number in range(max(map(len, stencils))):
            for doubles in (True, False):
                waiting = (self.kinds[rows, columns] == INTERRUPTED) & (attempts < ATTEMPTS)
                if not waiting.any():
                    break
                chosen = [item[number] if number < len(item) else None for item in stencils]
                guess = self._guesses(axis, chosen, others, doubles=doubles)
                some = np.flatnonzero(waiting & np.isfinite(guess.ends))
                if len(some):
                    attempts[some] += 1
                    at = rows[some], columns[some]
                    found = self._batch.find(
                        self._parameters[at], self._scales[at], guess.rows(some)
                    )
                    self._accept(found, at)
        self.report(self)
        self._follow(list(zip(rows.tolist(), columns.tolist(), strict=True)))

    def _guesses(
        self, axis: int, stencils: list[Stencil | None], others: Indices, *, doubles: bool
    ) -> Paths:
        """Guess the stable parts on lines, in turn."""
        # The axis that is refined comes first.
        kinds, ends, states = (
            item.swapaxes(0, axis) for item in (self.kinds, self.ends, self.states)
        )
        usable = (kinds == ("" if doubles else NO_THRESHOLD)) & np.isfinite(states).all(axis=(2, 3))
        found = np.full((len(stencils), len(others)), np.nan)
        paths = np.full((*found.shape, *states.shape[2:]), np.nan)
        for line, stencil in enumerate(stencils):
            if stencil is None:
                continue
            where = np.ix_(stencil.lines, others)
            good = usable[where].all(axis=0)
            found[line, good] = (stencil.weights @ ends[where])[good]
            paths[line] = np.tensordot(stencil.weights, states[where], axes=1)
        flat = paths.reshape(-1, *states.shape[2:])
        return Paths(found.ravel(), flat, np.full(found.size, doubles))

    def _accept(self, found: Found, where: tuple[Indices, Indices]) -> None:
        """Store what is proved."""
        proved, doubles = found.proved, found.paths.doubles[found.proved]
        at = where[0][proved], where[1][proved]
        self.kinds[at] = np.where(doubles, "", NO_THRESHOLD)
        self.reasons[at] = np.where(doubles, "", lasting_reason(self.vary, self.span[1]))
        self.ends[at], self.states[at] = found.paths.ends[proved], found.paths.states[proved]
        self.multipliers[at], self.residuals[at] = (
            found.multipliers[proved],
            found.residuals[proved],
        )

    def _follow(self, points: list[tuple[int, int]]) -> None:
        """Follow the responses of points that are still without a result."""
        for at in [at for at in points if self.kinds[at] == INTERRUPTED]:
            found = threshold_by_response(self._model(at), self.vary, self.span)
            self.kinds[at], self.reasons[at] = found.kind, found.reason
            self.followed[at] = True
            if found.branch is not None:
                states = found.path(FRACTIONS, self.span[0])
                doubles = np.array([found.point is not None])
                guess = Paths(np.array([found.value]), states[None], doubles)
                exact = self._batch.find(self._parameters[at][None], self._scales[at][None], guess)
                self.ends[at], self.states[at] = found.value, exact.paths.states[0]
                self.states[at][-1] = states[-1]
            if found.point is not None:
                self.multipliers[at] = found.point.multipliers
                self.residuals[at] = found.point.residual
            self.report(self)


# -- lines of a grid -----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Stencil:
    """How the values on one line are guessed from those on others."""

    lines: Indices  # indices of the known lines, shape (k,)
    weights: Array  # their weights, shape (k,)


def seed_lines(count: int) -> Indices:
    """Return the lines of an axis that are computed first, its ends among them."""
    return np.unique(np.linspace(0, count - 1, min(count, SEEDS)).round().astype(np.int64))


def refinements(counts: tuple[int, ...]) -> Iterator[tuple[int, Indices, Indices, Indices]]:
    """Yield what to compute next until both axes are complete, the sparser axis first.

    Each time lines are added between the known lines of one axis, at the known lines of the other.
    """
    known = [seed_lines(count) for count in counts]
    while any(len(lines) < count for lines, count in zip(known, counts, strict=True)):
        axis = int(np.argmax([np.diff(lines).max(initial=0) for lines in known]))
        middle = (known[axis][1:] + known[axis][:-1]) // 2
        new = np.setdiff1d(middle, known[axis])
        yield axis, known[axis], new, known[1 - axis]
        known[axis] = np.union1d(known[axis], new)


def stencils_of(values: Array, known: Indices, new: int) -> list[Stencil]:
    """Return ways to guess the values on a line, the most accurate first.

    After the widest come narrower ones and those of one side, which serve where the others include
    points without a value. Shapes: values (n,).
    """
    after = int(np.searchsorted(known, new))
    chosen: list[tuple[int, ...]] = []
    for width in (SEEDS, 4, 2):
        first = min(max(after - width // 2, 0), max(len(known) - width, 0))
        chosen.append(tuple(known[first : first + width]))
    chosen += [tuple(known[max(after - 3, 0) : after]), tuple(known[after : after + 3])]
    at = values[new : new + 1]
    return [
        Stencil(np.array(item), polynomial_weights(values[list(item)], at)[0])
        for item in dict.fromkeys(chosen)
        if item
    ]
