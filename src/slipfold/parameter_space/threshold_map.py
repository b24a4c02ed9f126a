"""Thresholds of stability over a grid of two parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.bifurcations.branches.batched import BatchedCase, follow_batch
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.continuation.interpolation import polynomial_weights
from slipfold.errors import InputError
from slipfold.flow.scales import measured_within
from slipfold.models.model import Model
from slipfold.parameter_space.batch import FRACTIONS, BatchedThresholds, Paths, StableParts
from slipfold.parameter_space.loss import (
    NO_THRESHOLD,
    NOT_STARTED,
    first_loss,
    followed_to_loss,
    grid_kind,
    lasting_reason,
)
from slipfold.progress import Observer, Progress


class GRIDS:
    """Sizes of the batches and guesses of a grid."""

    # Lines an axis begins with, and from which a line is guessed: a polynomial of degree five
    seeds: int = 6
    # Points that are guessed and corrected in one batch, at least a line
    together: int = 1024
    # Guesses from different neighbors that are tried before the response is followed
    attempts: int = 2


INTERRUPTED = "interrupted"


def find_threshold_map(
    model: Model,
    threshold: str,
    over: Mapping[str, Array],
    span: tuple[float, float],
    observer: Observer | None = None,
) -> tuple[Model, dict[str, Any]]:
    """Find where the response of period 1 first loses its stability, over a grid of parameters.

    The responses of a few points are followed from the first value of the span. Between them the
    threshold, the orbit there and the stable response on the way are guessed by interpolation and
    corrected in batches; a point is accepted if the orbits on the way are stable, keep the limits
    of the model and lie near their guess. Where that cannot be shown, the response of the point
    itself is followed. Return the model with its scales, and the arrays of a `ThresholdMap`.

    Shapes: over (n,).
    """
    first, second = over
    orders = [np.argsort(own) for own in over.values()]
    ordered = (over[first][orders[0]], over[second][orders[1]])

    def report(search: ThresholdSearch) -> None:
        if observer is not None:
            waiting = int(np.count_nonzero(search.kinds == INTERRUPTED))
            found = int(np.count_nonzero(search.kinds == ""))
            total = search.kinds.size
            failures = total - waiting - found
            observer(Progress("points", total - waiting, total, values={"failures": failures}))

    corners = product(*((own[0], own[-1]) for own in ordered), span[1:])
    names = (first, second, threshold)
    at = [dict(zip(names, map(float, corner), strict=True)) for corner in corners]
    model = measured_within(model, at)
    search = ThresholdSearch(model, threshold, (first, second), ordered, span, report)
    search.run()
    found = search.kinds == ""
    arrays = {
        "values": np.where(found, search.ends, np.nan),
        "states": np.where(found[..., None], search.states[:, :, -1], np.nan),
        "multipliers": search.multipliers,
        "residuals": search.residuals,
        "kinds": search.kinds.astype(str),
        "reasons": search.reasons,
        "followed": search.followed,
    }
    # As they were given: the search needs increasing values.
    given = np.ix_(*(np.argsort(order) for order in orders))
    return model, {name: values[given] for name, values in arrays.items()}


# -- the search ----------------------------------------------------------------------------------


class ThresholdSearch:
    """The computation of thresholds over a grid.

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
                count = max(GRIDS.together // len(others), 1)
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
        self._follow([(int(i), int(j)) for i in first for j in second])

    def _path(self, case: BatchedCase) -> Paths | None:
        """Return the stable part of a response, None if it ends otherwise than at a doubling."""
        if case.failure or not case.branches[0].stable:
            return None
        loss = (branch := case.branches[0]).loss
        if branch.end != "span" if loss is None else loss.type != "PD":
            return None
        steps = branch.steps if loss is None else branch.steps[:-1]
        unknowns = [z for z, _, _ in steps] + ([] if loss is None else [loss.point.z])
        values = np.array([branch.orbits.value(z) for z in unknowns])
        states = np.array([branch.orbits.nodes(z)[0] for z in unknowns])
        return self._interpolated(values, states, loss is not None)

    def _interpolated(self, values: Array, states: Array, doubles: bool) -> Paths:
        """Return a response by its states at some values. Shapes: values (k,), states (k, n)."""
        along = (values - self.span[0]) / (values[-1] - self.span[0])
        columns = [np.interp(FRACTIONS, along, column) for column in states.T]
        return Paths(values[-1:], np.array(columns).T[None], np.array([doubles]))

    def _fill(self, axis: int, known: Indices, new: Indices, others: Indices) -> None:
        """Find the thresholds on new lines, most of them from guesses."""
        rows, columns = np.repeat(new, len(others)), np.tile(others, len(new))
        if axis == 1:
            rows, columns = columns, rows
        attempts = np.zeros(len(rows), dtype=np.int64)
        stencils = [stencils_of(self.values[axis], known, int(line)) for line in new]
        for number in range(max(map(len, stencils))):
            for doubles in (True, False):
                waiting = (self.kinds[rows, columns] == INTERRUPTED) & (attempts < GRIDS.attempts)
                if not waiting.any():
                    break
                chosen = [item[number] if number < len(item) else None for item in stencils]
                guess = self._guesses(axis, chosen, others, doubles=doubles)
                points = np.flatnonzero(waiting & np.isfinite(guess.ends))
                if len(points):
                    attempts[points] += 1
                    at = rows[points], columns[points]
                    given = self._parameters[at], self._scales[at], guess.rows(points)
                    self._accept(self._batch.find(*given), at)
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

    def _accept(self, parts: StableParts, where: tuple[Indices, Indices]) -> None:
        """Store the proved results."""
        proved, doubles = parts.proved, parts.paths.doubles[parts.proved]
        at = where[0][proved], where[1][proved]
        self.kinds[at] = np.where(doubles, "", NO_THRESHOLD)
        self.reasons[at] = np.where(doubles, "", lasting_reason(self.vary, self.span[1]))
        self.ends[at], self.states[at] = parts.paths.ends[proved], parts.paths.states[proved]
        found = np.flatnonzero(proved)[doubles]
        at = where[0][found], where[1][found]
        self.multipliers[at], self.residuals[at] = parts.multipliers[found], parts.residuals[found]

    def _follow(self, points: list[tuple[int, int]]) -> None:
        """Follow the responses of points that are still without a result, as a batch if it can."""
        left = [at for at in points if self.kinds[at] == INTERRUPTED]
        if left:
            models, settings = [self._model(at) for at in left], Settings(largest_period=1)
            cases = follow_batch(models, self.vary, self.span, settings, wanted="loss")
            paths = [self._path(case) for case in cases]
            known = [at for at, path in zip(left, paths, strict=True) if path is not None]
            if known:
                where = tuple(np.array(known).T)
                guess = Paths.joined([path for path in paths if path is not None])
                parts = self._batch.find(self._parameters[where], self._scales[where], guess)
                self._accept(parts, (where[0], where[1]))
            self.report(self)
        for at in [at for at in left if self.kinds[at] == INTERRUPTED]:
            self.followed[at] = True
            model = self._model(at)
            try:
                branch = followed_to_loss(model, self.vary, self.span)
            except InputError as error:
                self.kinds[at], self.reasons[at] = NOT_STARTED, str(error)
                continue
            loss = first_loss(branch, self.span[0])
            self.kinds[at], self.reasons[at] = grid_kind(loss, branch, self.span[1])
            if self.kinds[at] in ("", NO_THRESHOLD):
                self._store(at, branch, loss.point)
            self.report(self)

    def _store(self, at: tuple[int, int], branch: Branch, point: SpecialPoint | None) -> None:
        """Store a response that was followed to its doubling, or to the end of the span."""
        values, states = branch.parameter, branch.states
        if point is not None:
            before = branch.arclength < point.arclength
            values = np.append(values[before], point.value)
            states = np.vstack([states[before], point.state])
        guess = self._interpolated(values, states, point is not None)
        exact = self._batch.find(self._parameters[at][None], self._scales[at][None], guess)
        self.ends[at], self.states[at] = values[-1], exact.paths.states[0]
        self.states[at][-1] = states[-1]
        if point is not None:
            self.multipliers[at], self.residuals[at] = point.multipliers, point.residual


# -- lines of a grid -----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Stencil:
    """How the values on one line are guessed from those on others."""

    lines: Indices  # indices of the known lines, shape (k,)
    weights: Array  # their weights, shape (k,)


def seed_lines(count: int) -> Indices:
    """Return the lines of an axis that are computed first, its ends among them."""
    return np.unique(np.linspace(0, count - 1, min(count, GRIDS.seeds)).round().astype(np.int64))


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
    for width in (GRIDS.seeds, 4, 2):
        first = min(max(after - width // 2, 0), max(len(known) - width, 0))
        chosen.append(tuple(known[first : first + width]))
    chosen += [tuple(known[max(after - 3, 0) : after]), tuple(known[after : after + 3])]
    at = values[new : new + 1]
    return [
        Stencil(np.array(item), polynomial_weights(values[list(item)], at)[0])
        for item in dict.fromkeys(chosen)
        if item
    ]
