"""Branches of one period of many cases, followed together, each with its own steps.

Step lengths, acceptance and tests of what lies between two points follow the rules of a single
curve (`continuation.step_length`, `continuation.search`). Where that one would be searched, the
step is taken again at half its length. A branch is left, to be followed individually, if anything
happens on it but folds, period doublings and tori.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Indices, Mask
from slipfold.branches.closed_branches import AROUND
from slipfold.branches.stops import ONE
from slipfold.continuation.curve import Curve
from slipfold.continuation.end import End
from slipfold.continuation.follow import BIRTH, FIRST
from slipfold.continuation.interpolation import POINTS, arcs, hermite_each, polynomial_weights
from slipfold.continuation.search import (
    KNOTS,
    Interpolated,
    arclengths_between,
    interpolation_weights,
)
from slipfold.continuation.settings import Steps
from slipfold.continuation.step_length import (
    HARDER,
    LONGER,
    REACH,
    Measures,
    arclength_of_bound,
    drift,
    lengthened,
    shortened,
    shortened_after_failure,
)
from slipfold.continuation.traced_curve import Found
from slipfold.continuation.walk import EDGE
from slipfold.flow.modes import contacts_of
from slipfold.orbits.orbit_batch import TESTS, Corrected, OrbitBatch
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits

CLOSE = 1e-5
"""A correction shorter than this is the last: the next one would be as long as its square."""

ROUGHLY = 1e-8
"""Error of a step in time along a branch. Orbits and multipliers are then known to 1e-6: enough to
choose steps and to bracket what is located more exactly."""

SMALLEST = 1e-6
"""A branch that needs a smaller step is left."""

AMPLIFIED = 1e6
"""Largest multiplier, and largest change of an orbit by an error where a multiplier is near one.
Beyond, rounding begins to matter, and the branch is left."""

MAX_ROUNDS = 400
"""Steps of each branch after which those that have not ended are left."""

PD, FOLD, NS, LP = range(len(TESTS))

Step = tuple[Array, Array, float]
"""Unknown and unit tangent, both of shape (u,), and arclength of a point of a branch."""


@dataclass(eq=False)
class BatchedBranch:
    """A branch of one of the cases."""

    case: int  # number of the case
    orbits: Orbits
    steps: list[Step]  # where it begins; then all points of the walk
    parent: int | None = None  # number of the branch on which it begins, from 1
    birth: Found[OrbitPoint] | None = None  # the period doubling at which it begins
    first: OrbitPoint | None = None  # its first orbit, if it begins on another branch
    stable: bool = False  # whether the first orbit is; not known of one that begins on another
    end: str = ""  # "span", "limit", "loss" of stability, or why it was left
    brackets: list[Bracket] = field(default_factory=list)  # of its bifurcations, in order
    located: list[Located] = field(default_factory=list)  # its bifurcations, in order
    found: list[Found[OrbitPoint]] = field(default_factory=list)  # the same, by the flow itself
    # Of complete branches alone: all points, and the end in words
    points: list[OrbitPoint] = field(default_factory=list)
    stopped: End | None = None

    @property
    def loses_stability(self) -> bool:
        """Whether it is stable before the last bifurcation that was bracketed, but not after it."""
        before, after = self.brackets[-1].unstable if self.brackets else (0, 0)
        return before == 0 < after

    @property
    def ordinary(self) -> bool:
        """Whether it ended in a way that a batch can describe."""
        return self.end in ("span", "limit", "loss")


@dataclass(frozen=True, eq=False)
class Bracket:
    """Two neighboring points of a branch between which a function changes its sign."""

    case: int
    kind: str
    z: Array  # shape (2, u)
    tangents: Array  # shape (2, u)
    arclengths: Array  # shape (2,)
    values: Array  # of the function, shape (2,)
    unstable: tuple[int, int] = (0, 0)  # multipliers outside the unit circle at either


@dataclass(frozen=True, eq=False)
class Located:
    """A zero within a bracket."""

    bracket: Bracket
    z: Array  # shape (u,)
    tangent: Array  # shape (u,)
    multipliers: NDArray[np.complex128]  # shape (n,)
    slope: float  # of the function along the branch
    arclength: float


class Walk:
    """Follows branches to their ends, and brackets what is to be located on them.

    The last point of a branch that ends at a limit is the first orbit that breaks it. If `to_loss`,
    a branch ends at the first point after it has lost its stability.
    """

    def __init__(
        self,
        orbits: OrbitBatch,
        branches: Sequence[BatchedBranch],
        span: tuple[float, float],
        steps: Steps,
        to_loss: bool = False,
    ) -> None:
        self._to_loss = to_loss
        k, u = len(branches), orbits.size + 1
        self._orbits, self._branches, self._steps = orbits, branches, steps
        self._cases = np.array([branch.case for branch in branches])
        self._low, self._high = (value / orbits.width for value in (min(span), max(span)))
        model = orbits.model
        self._bounds = np.array([limit.bound for limit in model.limits])
        sticking = {name for contact in contacts_of(model) for name in contact.limits}
        self._sticking = np.array([limit.name in sticking for limit in model.limits], bool)
        # The last points of each, the newest last
        self._z, self._tangents = np.zeros((2, k, KNOTS, u))
        self._arclengths, self._tests = np.zeros((k, KNOTS)), np.zeros((k, KNOTS, len(TESTS)))
        self._count, self._unstable = np.ones(k, int), np.zeros(k, int)
        self._signs = np.zeros(k)
        self._step, self._growth = np.full(k, FIRST), np.full(k, LONGER)
        self._held = np.zeros(k, bool)  # whether the next step leads to a bound
        self._departs = np.array([branch.first is not None for branch in branches])
        self._z[:, -1] = [branch.steps[0][0] for branch in branches]
        self._tangents[:, -1] = [branch.steps[0][1] for branch in branches]
        self._active: Mask = np.ones(k, bool)
        self._correct_first_orbits()
        self._choose_first_steps()
        for branch in branches:
            branch.steps.clear()
        self._store_points(np.arange(k))

    def run(self, report: Callable[[float], None] = lambda fraction: None) -> None:
        """Follow all branches to their ends; report after each step how far they have come.

        The parameter may go back at folds; the reported fraction does not.
        """
        fraction = 0.0
        for _ in range(MAX_ROUNDS):
            active = np.flatnonzero(self._active)
            if not len(active):
                return
            self._take_steps(active)
            fraction = max(fraction, self._fraction)
            report(fraction)
        self._stop(np.flatnonzero(self._active), "points")

    @property
    def _fraction(self) -> float:
        """How far they have come through the span, on average; those that ended are through."""
        first = np.array([branch.steps[0][0][-1] for branch in self._branches])
        come = np.abs(self._z[:, -1, -1] - first) / (self._high - self._low)
        return float(np.where(self._active, np.minimum(come, 1.0), 1.0).mean())

    # -- where branches begin --------------------------------------------------------------------

    def _correct_first_orbits(self) -> None:
        rows = np.flatnonzero(~self._departs)
        if not len(rows):
            return
        z, normals = self._z[rows, -1], self._tangents[rows, -1]
        result = self._orbits.correct(self._cases[rows], z, normals, CLOSE, np.inf, ROUGHLY)
        self._z[rows, -1], self._tangents[rows, -1] = result.z, result.tangents
        self._tests[rows, -1], self._signs[rows] = result.tests, result.signs
        self._unstable[rows] = _unstable(result)
        for row, count in zip(rows.tolist(), self._unstable[rows], strict=True):
            self._branches[row].stable = bool(count == 0)
        clear = result.found & (result.seen.above > self._bounds).all(axis=1)
        self._stop(rows[~clear], "first orbit")

    def _choose_first_steps(self) -> None:
        """Leave another branch by a step so short that nothing else can happen within it."""
        active = np.flatnonzero(self._departs)
        firsts = [branch.first for branch in self._branches if branch.first is not None]
        others = [np.delete(p.multipliers, np.abs(p.multipliers - 1).argmin()) for p in firsts]
        outside = np.array([np.count_nonzero(np.abs(item) > 1) for item in others])
        self._step[active] = BIRTH
        for _ in range(6):
            if not len(active):
                return
            z, tangents, step = self._z[active, -1], self._tangents[active, -1], self._step[active]
            given = CLOSE, REACH, ROUGHLY
            result, nearer = (
                self._orbits.correct(
                    self._cases[active], z + fraction * step[:, None] * tangents, tangents, *given
                )
                for fraction in (1.0, 0.25)
            )
            more = _unstable(result) - outside
            with np.errstate(invalid="ignore"):
                good = result.found & nearer.found & ((more == 0) | (more == 1))
                good &= result.tests[:, LP] * nearer.tests[:, LP] > 0
            active, outside = active[~good], outside[~good]
            self._step[active] /= 4
        self._stop(active, "birth")

    # -- a step of each --------------------------------------------------------------------------

    def _take_steps(self, active: Indices) -> None:
        if self._orbits.period % 2 == 0:
            apart = 0.9 * _length(self._halves(self._z[active, -1]))
            self._step[active] = np.minimum(self._step[active], np.maximum(BIRTH, apart))
        guess, rows, held = self._predicted(active)
        result = self._orbits.correct(self._cases[active], guess, rows, CLOSE, REACH, ROUGHLY)
        result.z[held, -1] = guess[held, -1]
        beyond = result.found & ~held & self._is_beyond(result.z[:, -1], 0.0)
        self._held[active] = beyond
        last = self._tangents[active, -1]
        length, turn = arcs(result.z - self._z[active, -1], last, result.tangents)
        measures = self._measured(active, result, guess, length, turn)
        fits = measures.fits & result.found & ~beyond
        tests, ambiguous = self._examined(active, result, length, fits)
        accepted = fits & ~ambiguous
        # One that leads beyond a bound is taken again, to the bound.
        step, growth = self._step[active], self._growth[active]
        longer = lengthened(step, measures, growth, self._steps.largest)
        shorter = np.where(fits, 0.5 * step, shortened(step, measures))
        shorter = np.where(result.found, shorter, shortened_after_failure(step, result.moved))
        self._step[active] = np.where(accepted, longer, np.where(beyond, step, shorter))
        self._growth[active] = np.where(accepted, LONGER, np.where(beyond, growth, HARDER))
        self._stop(active[~accepted & (self._step[active] < SMALLEST)], "steps")
        for row in np.flatnonzero(accepted & (tests >= 0)).tolist():
            self._add_bracket(int(active[row]), result, length, row, int(tests[row]))
        self._accept(active[accepted], result, np.flatnonzero(accepted), length)
        if self._to_loss:
            lost = [row for row in active.tolist() if self._branches[row].loses_stability]
            self._stop(np.array(lost, dtype=int), "loss")

    def _predicted(self, active: Indices) -> tuple[Array, Array, Mask]:
        """Return guesses, rows of their hyperplanes, and which hold the parameter on a bound."""
        target = self._arclengths[active, -1] + self._step[active]
        guess, rows = self._hermite(active, target)
        held = self._held[active] | self._is_beyond(guess[:, -1], EDGE)
        which = np.flatnonzero(held)
        if not len(which):
            return guess, rows, held
        here, forward = active[which], rows[which, -1] > 0
        bound = np.where(forward, self._high, self._low)

        def component(arclengths: Array) -> Array:
            return self._hermite(here, arclengths)[0][:, -1]

        far = arclength_of_bound(
            component, self._arclengths[here, -1], target[which], bound, forward
        )
        guess[which] = self._hermite(here, far)[0]
        guess[which, -1] = bound
        rows[which] = 0.0
        rows[which, -1] = np.where(forward, 1.0, -1.0)
        return guess, rows, held

    def _hermite(self, active: Indices, target: Array) -> tuple[Array, Array]:
        guess, rows = np.empty((2, len(active), self._z.shape[2]))
        for count, which in self._by_count(active, POINTS):
            here, last = active[which], slice(-count, None)
            given = self._arclengths[here, last], self._z[here, last], self._tangents[here, last]
            guess[which], rows[which] = hermite_each(*given, target[which])
        return guess, rows

    def _by_count(self, active: Indices, maximum: int) -> Iterator[tuple[int, Indices]]:
        """Yield how many points are interpolated, and which branches have so many."""
        counts = np.minimum(self._count[active], maximum)
        for count in np.unique(counts).tolist():
            yield count, np.flatnonzero(counts == count)

    def _is_beyond(self, values: Array, tolerance: float) -> Mask:
        return np.asarray((values < self._low - tolerance) | (values > self._high + tolerance))

    def _measured(
        self, active: Indices, result: Corrected, guess: Array, length: Array, turn: Array
    ) -> Measures:
        """Measure how well steps fitted."""
        drifted = np.zeros(len(active))
        for count, which in self._by_count(active, POINTS):
            if count == 1:  # nothing is extrapolated from one point
                continue
            here = active[which]
            values, actual = self._tests[here, -count:], result.tests[which]
            target = self._arclengths[here, -1] + length[which]
            weights = polynomial_weights(self._arclengths[here, -count:], target[:, None])
            errors = np.abs(actual - (weights @ values)[:, 0])
            drifted[which] = drift(errors, values, actual, Curve.noise)
        return Measures.of(_length(result.z - guess), turn, drifted, self._steps.turn)

    # -- what lies between two points ------------------------------------------------------------

    def _examined(
        self, active: Indices, result: Corrected, length: Array, fits: Mask
    ) -> tuple[Indices, Mask]:
        """Return which test function has a zero, -1 where none has, and which steps are ambiguous.

        A step is ambiguous if zeros may hide in it, or if changes of sign do not explain how the
        number of unstable multipliers changes.
        """
        departs = self._departs[active] & (self._count[active] == 1)
        ambiguous = np.zeros(len(active), bool)
        for count, same in self._by_count(active, KNOTS - 1):
            which = same[(fits & ~departs)[same]]
            here = active[which]
            if not len(which):
                continue
            last = self._arclengths[here, -1]
            new = last + length[which]
            # The nearest first; their two ends are the points of number 1 and 0.
            where = np.column_stack([new, self._arclengths[here, : -count - 1 : -1]])
            history = self._tests[here, : -count - 1 : -1]
            values = np.concatenate([result.tests[which, None], history], axis=1)
            grid = arclengths_between(last, new)
            weights = interpolation_weights(where, grid, (last, new), (1, 0))
            tests_between = Interpolated.from_values(weights @ values, values[:, 1::-1])
            ambiguous[which] = tests_between.ambiguous.any(axis=1)
        changed = (self._tests[active, -1] > 0) != (result.tests > 0)
        changed &= ~departs[:, None]
        change = np.abs(_unstable(result) - self._unstable[active])
        change[departs] = 0
        tests, alone = np.full(len(active), -1), changed.sum(axis=1) == 1
        tests[changed[:, PD] & alone & (change == 1)] = PD
        tests[changed[:, NS] & alone & ((change == 2) | (change == 0))] = NS
        folds = changed[:, LP] & changed[:, FOLD] & (changed.sum(axis=1) == 2) & (change == 1)
        tests[folds] = LP
        # What is located must lie before a limit: on the last step of a branch is nothing.
        ambiguous |= (tests >= 0) & ~(result.seen.above > self._bounds).all(axis=1)
        uneventful = ~changed.any(axis=1) & (change == 0)
        self._stop(active[fits & ~ambiguous & changed[:, FOLD] & ~changed[:, LP]], "crossing")
        return tests, np.asarray(ambiguous | ~(uneventful | (tests >= 0)))

    def _add_bracket(
        self, number: int, result: Corrected, length: Array, row: int, test: int
    ) -> None:
        branch, last = self._branches[number], self._arclengths[number, -1]
        bracket = Bracket(
            branch.case,
            TESTS[test],
            np.array([self._z[number, -1], result.z[row]]),
            np.array([self._tangents[number, -1], result.tangents[row]]),
            np.array([last, last + length[row]]),
            np.array([self._tests[number, -1, test], result.tests[row, test]]),
            (int(self._unstable[number]), int(_unstable(result)[row])),
        )
        branch.brackets.append(bracket)

    def _accept(self, active: Indices, result: Corrected, rows: Indices, length: Array) -> None:
        """Add points, and stop branches that end there or are left."""
        regular = ~(self._departs[active] & (self._count[active] == 1))
        before, signs = self._z[active, -1].copy(), self._signs[active]
        crosses = (result.signs[rows] != signs) & (signs != 0)
        self._stop(active[regular & crosses], "crossing")
        new = self._arclengths[active, -1] + length[rows]
        for history, values in (
            (self._z, result.z[rows]),
            (self._tangents, result.tangents[rows]),
            (self._tests, result.tests[rows]),
            (self._arclengths, new),
        ):
            history[active, :-1] = history[active, 1:]
            history[active, -1] = values
        self._count[active] += 1
        self._store_points(active)
        self._signs[active], self._unstable[active] = result.signs[rows], _unstable(result)[rows]
        multipliers = result.multipliers[rows]
        near_one = np.abs(multipliers - 1).min(axis=1) < ONE
        undetermined = near_one & (result.stiffness[rows] > AMPLIFIED)
        self._stop(active[regular & undetermined], "undetermined")
        self._stop(active[np.abs(multipliers).max(axis=1) > AMPLIFIED], "growth")
        if self._orbits.period % 2 == 0:
            here, there = self._halves(before), self._halves(self._z[active, -1])
            near = _length(there) < np.minimum(0.1 * BIRTH, _length(here))
            self._stop(active[regular & (((here * there).sum(axis=1) < 0) | near)], "copy")
        # Where it turned back it may come to its beginning.
        away = ~self._departs[active] & (self._count[active] > KNOTS)
        starts = [self._branches[number].steps[0][0] for number in active.tolist()]
        first = np.array(starts).reshape(before.shape)
        ahead = ((first - before) * self._tangents[active, -2]).sum(axis=1) > 0
        near = _length(first - before) <= AROUND * length[rows]
        self._stop(active[away & ahead & near], "returns")
        self._stop_at_bounds(active, result.seen.lowest[rows], result.seen.above[rows])

    def _stop_at_bounds(self, active: Indices, lowest: Array, above: Array) -> None:
        """End branches at limits and bounds. Shapes: lowest, above (k, n_limits)."""
        broken = lowest <= self._bounds
        unsure = np.flatnonzero((above <= self._bounds).any(axis=1) & ~broken.any(axis=1))
        here = active[unsure]
        broken[unsure] = ~(self._orbits.margins(self._cases[here], self._z[here, -1]) > 0)
        self._stop(active[(broken & self._sticking).any(axis=1)], "stick")
        at_end = (self._z[active, -1, -1] == self._low) | (self._z[active, -1, -1] == self._high)
        self._stop(active[broken.any(axis=1)], "limit")
        self._stop(active[at_end], "span")
        self._stop(active[self._count[active] >= self._steps.points], "points")

    def _store_points(self, active: Indices) -> None:
        z, tangents = self._z[active, -1], self._tangents[active, -1]
        arclengths = self._arclengths[active, -1].tolist()
        for number, *step in zip(active.tolist(), z, tangents, arclengths, strict=True):
            self._branches[number].steps.append((step[0], step[1], step[2]))

    def _stop(self, rows: Indices, reason: str) -> None:
        """End branches; the first reason counts."""
        for number in rows[self._active[rows]].tolist():
            self._branches[number].end = reason
        self._active[rows] = False

    def _halves(self, z: Array) -> Array:
        """Return by how much the halves of orbits differ, in scaled states."""
        half = self._orbits.size // 2
        return np.asarray(z[:, :half] - z[:, half : 2 * half])


def _unstable(result: Corrected) -> Indices:
    """Return how many multipliers of each orbit lie outside the unit circle."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.count_nonzero(np.abs(result.multipliers) > 1, axis=1))


def _length(vectors: Array) -> Array:
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=1)))
