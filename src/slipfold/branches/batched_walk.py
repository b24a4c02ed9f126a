"""Branches of one period of many cases, followed together, each with its own steps.

Step lengths, acceptance and doubt about what lies between two points follow the rules of a single
curve (`continuation.step_length`, `continuation.unseen`). Where that one would be searched, the
step is taken again at half its length. A branch on which anything happens but folds, period
doublings and tori is left: it has to be followed individually.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Indices, Mask
from slipfold.branches.closed_branches import AROUND
from slipfold.branches.stops import ONE
from slipfold.continuation.curve import Curve
from slipfold.continuation.follow import BIRTH, FIRST
from slipfold.continuation.interpolation import POINTS, arcs, hermite_each, polynomial_weights
from slipfold.continuation.search import KNOTS
from slipfold.continuation.settings import Steps
from slipfold.continuation.step_length import (
    HARDER,
    LONGER,
    REACH,
    Measures,
    drift,
    lengthened,
    place_of_bound,
    shortened,
    shortened_where_lost,
)
from slipfold.continuation.unseen import Expected, expectation_weights, places_between
from slipfold.continuation.walk import EDGE
from slipfold.flow.modes import contacts_of
from slipfold.orbits.orbit_batch import TESTS, Corrected, OrbitBatch

CLOSE = 1e-5
"""Corrections shorter than this are the last: what is left is their square."""

ROUGHLY = 1e-8
"""Error that a step in time may make on the way: orbits and multipliers are then known to 1e-6,
enough to choose steps and to bracket what is located more exactly."""

SMALLEST = 1e-6
"""A branch that needs a smaller step is left."""

AMPLIFIED = 1e6
"""So much may errors move an orbit that has a multiplier near one, or any orbit within a period:
beyond, rounding begins to matter, and the branch is left."""

MAX_ROUNDS = 400
"""Rounds of steps after which all branches still on their way are left."""

PD, FOLD, NS, LP = range(len(TESTS))


@dataclass(frozen=True, eq=False)
class BatchStart:
    """Where the branch of a case begins."""

    case: int
    z: Array  # shape (u,)
    tangent: Array  # shape (u,)
    multipliers: NDArray[np.complex128] | None = None  # where it leaves another branch


@dataclass(frozen=True, eq=False)
class Bracket:
    """Two neighboring points between which a test function changes its sign."""

    branch: int  # number of the branch among those walked
    case: int
    kind: str
    z: Array  # shape (2, u)
    tangents: Array  # shape (2, u)
    arclengths: Array  # shape (2,)
    values: Array  # of the test function, shape (2,)
    unstable: tuple[int, int]  # multipliers outside the unit circle at either


class Walk:
    """Branches on their way. How each ended is in `fates`: ``"span"``, ``"limit"`` or why not.

    `brackets` has what is to be located, in order along each branch; `stable` whether the first
    point of each is; `points` has the unknowns, unit tangents and arclengths of each, at the end of
    one that ended at a limit those of the first orbit that breaks it.
    """

    def __init__(
        self,
        orbits: OrbitBatch,
        starts: Sequence[BatchStart],
        span: tuple[float, float],
        steps: Steps,
    ) -> None:
        k, u = len(starts), orbits.size + 1
        self._orbits, self._steps = orbits, steps
        self.cases = np.array([start.case for start in starts])
        self._low, self._high = (value / orbits.width for value in (min(span), max(span)))
        self.fates = [""] * k
        self.brackets: list[list[Bracket]] = [[] for _ in starts]
        self.stable = np.zeros(k, bool)
        self.points: list[list[tuple[Array, Array, float]]] = [[] for _ in starts]
        model = orbits.model
        self._bounds = np.array([limit.bound for limit in model.limits])
        sticking = {name for contact in contacts_of(model) for name in contact.limits}
        self._sticking = np.array([limit.name in sticking for limit in model.limits], bool)
        self._z, self._tangents = np.zeros((2, k, KNOTS, u))
        self._arclengths, self._tests = np.zeros((k, KNOTS)), np.zeros((k, KNOTS, len(TESTS)))
        self._count, self._unstable = np.ones(k, int), np.zeros(k, int)
        self._signs = np.zeros(k)
        self._step, self._growth = np.full(k, FIRST), np.full(k, LONGER)
        self._held = np.zeros(k, bool)
        self._leaves = np.array([start.multipliers is not None for start in starts])
        self._z[:, -1] = [start.z for start in starts]
        self._tangents[:, -1] = [start.tangent for start in starts]
        self.going: Mask = np.ones(k, bool)
        self._begin(starts)
        self._note(np.arange(k))

    def run(self, report: Callable[[float], None] = lambda fraction: None) -> None:
        """Follow all branches to their ends; report after each step how far they have come.

        The parameter may go back at folds; the reported fraction does not.
        """
        fraction = 0.0
        for _ in range(MAX_ROUNDS):
            active = np.flatnonzero(self.going)
            if not len(active):
                return
            self._take_steps(active)
            fraction = max(fraction, self._fraction)
            report(fraction)
        self._leave(np.flatnonzero(self.going), "points")

    @property
    def _fraction(self) -> float:
        """How far they have come through the span, on average; those that ended are through."""
        first = np.array([points[0][0][-1] for points in self.points])
        come = np.abs(self._z[:, -1, -1] - first) / (self._high - self._low)
        return float(np.where(self.going, np.minimum(come, 1.0), 1.0).mean())

    # -- where branches begin --------------------------------------------------------------------

    def _begin(self, starts: Sequence[BatchStart]) -> None:
        everything = np.arange(len(starts))
        regular = everything[~self._leaves]
        if len(regular):
            z, row = self._z[regular, -1], self._tangents[regular, -1]
            found = self._orbits.correct(self.cases[regular], z, row, CLOSE, np.inf, ROUGHLY)
            self._z[regular, -1], self._tangents[regular, -1] = found.z, found.tangents
            self._tests[regular, -1], self._signs[regular] = found.tests, found.signs
            self._unstable[regular] = _outside(found)
            self.stable[regular] = _outside(found) == 0
            clear = found.found & (found.seen.above > self._bounds).all(axis=1)
            self._leave(regular[~clear], "first orbit")
        self._first_steps([start for start in starts if start.multipliers is not None])

    def _first_steps(self, starts: Sequence[BatchStart]) -> None:
        """Leave another branch by a step so short that nothing else can happen within it."""
        active = np.flatnonzero(self._leaves)
        if not len(active):
            return
        others = [
            np.delete(v, np.abs(v - 1).argmin()) for s in starts if (v := s.multipliers) is not None
        ]
        outside = np.array([np.count_nonzero(np.abs(item) > 1) for item in others])
        self._step[active] = BIRTH
        for _ in range(6):
            if not len(active):
                return
            looks = []
            for fraction in (1.0, 0.25):
                guess = (
                    self._z[active, -1]
                    + (fraction * self._step[active])[:, None] * self._tangents[active, -1]
                )
                rows = self._tangents[active, -1]
                looks.append(
                    self._orbits.correct(self.cases[active], guess, rows, CLOSE, REACH, ROUGHLY)
                )
            first, nearer = looks
            more = _outside(first) - outside
            with np.errstate(invalid="ignore"):
                good = first.found & nearer.found & ((more == 0) | (more == 1))
                good &= first.tests[:, LP] * nearer.tests[:, LP] > 0
            active, outside = active[~good], outside[~good]
            self._step[active] /= 4
        self._leave(active, "birth")

    # -- a step of each --------------------------------------------------------------------------

    def _take_steps(self, active: Indices) -> None:
        if self._orbits.period % 2 == 0:
            self._step[active] = np.minimum(
                self._step[active],
                np.maximum(BIRTH, 0.9 * _length(self._halves(self._z[active, -1]))),
            )
        guess, rows, held = self._predicted(active)
        found = self._orbits.correct(self.cases[active], guess, rows, CLOSE, REACH, ROUGHLY)
        found.z[held, -1] = guess[held, -1]
        beyond = found.found & ~held & self._is_beyond(found.z[:, -1], 0.0)
        self._held[active] = beyond
        last = self._tangents[active, -1]
        length, turn = arcs(found.z - self._z[active, -1], last, found.tangents)
        measures = self._measured(active, found, guess, length, turn)
        fits = measures.fits & found.found & ~beyond
        brackets, doubt = self._judged(active, found, length, fits)
        accepted = fits & ~doubt
        # One that leads beyond a bound is taken again, to the bound.
        step, growth = self._step[active], self._growth[active]
        longer = lengthened(step, measures, growth, self._steps.largest)
        shorter = np.where(fits, 0.5 * step, shortened(step, measures))
        shorter = np.where(found.found, shorter, shortened_where_lost(step, found.moved))
        self._step[active] = np.where(accepted, longer, np.where(beyond, step, shorter))
        self._growth[active] = np.where(accepted, LONGER, np.where(beyond, growth, HARDER))
        self._leave(active[~accepted & (self._step[active] < SMALLEST)], "steps")
        for row in np.flatnonzero(accepted & (brackets >= 0)):
            self._bracket(int(active[row]), found, length, int(row), TESTS[brackets[row]])
        self._accept(active[accepted], found, np.flatnonzero(accepted), length)

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

        def component(place: Array) -> Array:
            return self._hermite(here, place)[0][:, -1]

        far = place_of_bound(component, self._arclengths[here, -1], target[which], bound, forward)
        guess[which] = self._hermite(here, far)[0]
        guess[which, -1] = bound
        rows[which] = 0.0
        rows[which, -1] = np.where(forward, 1.0, -1.0)
        return guess, rows, held

    def _hermite(self, active: Indices, target: Array) -> tuple[Array, Array]:
        guess, rows = np.empty((2, len(active), self._z.shape[2]))
        for count, which in self._by_count(active, POINTS):
            here = active[which]
            guess[which], rows[which] = hermite_each(
                self._arclengths[here, -count:],
                self._z[here, -count:],
                self._tangents[here, -count:],
                target[which],
            )
        return guess, rows

    def _by_count(self, active: Indices, most: int) -> Iterator[tuple[int, Indices]]:
        """Yield how many points are interpolated, and which branches have so many."""
        counts = np.minimum(self._count[active], most)
        for count in np.unique(counts).tolist():
            yield count, np.flatnonzero(counts == count)

    def _is_beyond(self, values: Array, slack: float) -> Mask:
        return np.asarray((values < self._low - slack) | (values > self._high + slack))

    def _measured(
        self, active: Indices, found: Corrected, guess: Array, length: Array, turn: Array
    ) -> Measures:
        """Measure how well steps fitted."""
        drifted = np.zeros(len(active))
        for count, which in self._by_count(active, POINTS):
            if count == 1:  # nothing is extrapolated from one point
                continue
            here = active[which]
            values, actual = self._tests[here, -count:], found.tests[which]
            target = self._arclengths[here, -1] + length[which]
            weights = polynomial_weights(self._arclengths[here, -count:], target[:, None])
            drifted[which] = drift(
                np.abs(actual - (weights @ values)[:, 0]), values, actual, Curve.noise
            )
        return Measures.of(_length(found.z - guess), turn, drifted, self._steps.turn)

    # -- what lies between two points ------------------------------------------------------------

    def _judged(
        self, active: Indices, found: Corrected, length: Array, fits: Mask
    ) -> tuple[Indices, Mask]:
        """Return which test function changes its sign, -1 where none does, and what is in doubt."""
        leaves = self._leaves[active] & (self._count[active] == 1)
        doubt = np.zeros(len(active), bool)
        for count, same in self._by_count(active, KNOTS - 1):
            which = same[(fits & ~leaves)[same]]
            here = active[which]
            if not len(which):
                continue
            last = self._arclengths[here, -1]
            new = last + length[which]
            # The nearest first; their two ends are the points of number 1 and 0.
            where = np.column_stack([new, self._arclengths[here, : -count - 1 : -1]])
            known = self._tests[here, : -count - 1 : -1]
            values = np.concatenate([found.tests[which, None], known], axis=1)
            grid = places_between(last, new)
            weights = expectation_weights(where, grid, (last, new), (1, 0))
            expected = Expected.of(weights @ values, values[:, 1::-1])
            doubt[which] = expected.doubtful.any(axis=1)
        changed = (self._tests[active, -1] > 0) != (found.tests > 0)
        changed &= ~leaves[:, None]
        change = np.abs(_outside(found) - self._unstable[active])
        change[leaves] = 0
        brackets = np.full(len(active), -1)
        for place, explained in ((PD, change == 1), (NS, (change == 2) | (change == 0))):
            only = changed[:, place] & (changed.sum(axis=1) == 1) & explained
            brackets[only] = place
        folds = changed[:, LP] & changed[:, FOLD] & (changed.sum(axis=1) == 2) & (change == 1)
        brackets[folds] = LP
        # What is found must lie before a limit: on the last step of a branch is nothing.
        doubt |= (brackets >= 0) & ~(found.seen.above > self._bounds).all(axis=1)
        quiet = ~changed.any(axis=1) & (change == 0)
        self._leave(active[fits & ~doubt & changed[:, FOLD] & ~changed[:, LP]], "crossing")
        return brackets, np.asarray(doubt | ~(quiet | (brackets >= 0)))

    def _bracket(self, branch: int, found: Corrected, length: Array, row: int, kind: str) -> None:
        place = TESTS.index(kind)
        self.brackets[branch].append(
            Bracket(
                branch,
                int(self.cases[branch]),
                kind,
                np.array([self._z[branch, -1], found.z[row]]),
                np.array([self._tangents[branch, -1], found.tangents[row]]),
                np.array(
                    [self._arclengths[branch, -1], self._arclengths[branch, -1] + length[row]]
                ),
                np.array([self._tests[branch, -1, place], found.tests[row, place]]),
                (int(self._unstable[branch]), int(_outside(found)[row])),
            )
        )

    def _accept(self, active: Indices, found: Corrected, rows: Indices, length: Array) -> None:
        """Add points, and see which branches end there."""
        leaves = self._leaves[active] & (self._count[active] == 1)
        before = self._z[active, -1].copy()
        self._leave(
            active[
                (found.signs[rows] != self._signs[active]) & ~leaves & (self._signs[active] != 0)
            ],
            "crossing",
        )
        new = self._arclengths[active, -1] + length[rows]
        for kept, items in (
            (self._z, found.z),
            (self._tangents, found.tangents),
            (self._tests, found.tests),
        ):
            kept[active, :-1] = kept[active, 1:]
            kept[active, -1] = items[rows]
        self._arclengths[active, :-1] = self._arclengths[active, 1:]
        self._arclengths[active, -1] = new
        self._count[active] += 1
        self._note(active)
        self._signs[active], self._unstable[active] = found.signs[rows], _outside(found)[rows]
        multipliers = found.multipliers[rows]
        near_one = np.abs(multipliers - 1).min(axis=1) < ONE
        self._leave(
            active[~leaves & near_one & (found.stiffness[rows] > AMPLIFIED)], "undetermined"
        )
        self._leave(active[np.abs(multipliers).max(axis=1) > AMPLIFIED], "growth")
        if self._orbits.period % 2 == 0:
            here, there = self._halves(before), self._halves(self._z[active, -1])
            near = _length(there) < np.minimum(0.1 * BIRTH, _length(here))
            self._leave(active[~leaves & (((here * there).sum(axis=1) < 0) | near)], "copy")
        # Where it turned back it may come to its beginning.
        regular = ~self._leaves[active] & (self._count[active] > KNOTS)
        first = np.array([self.points[branch][0][0] for branch in active]).reshape(before.shape)
        ahead = ((first - before) * self._tangents[active, -2]).sum(axis=1) > 0
        near = _length(first - before) <= AROUND * length[rows]
        self._leave(active[regular & ahead & near], "returns")
        self._end(active, found.seen.lowest[rows], found.seen.above[rows])

    def _end(self, active: Indices, lowest: Array, above: Array) -> None:
        """End branches at limits and bounds."""
        broken = lowest <= self._bounds
        doubtful = np.flatnonzero((above <= self._bounds).any(axis=1) & ~broken.any(axis=1))
        here = active[doubtful]
        broken[doubtful] = ~(self._orbits.margins(self.cases[here], self._z[here, -1]) > 0)
        self._leave(active[(broken & self._sticking).any(axis=1)], "stick")
        at_end = (self._z[active, -1, -1] == self._low) | (self._z[active, -1, -1] == self._high)
        self._leave(active[broken.any(axis=1)], "limit")
        self._leave(active[at_end], "span")
        self._leave(active[self._count[active] >= self._steps.points], "points")

    def _note(self, active: Indices) -> None:
        """Keep the last point of each."""
        z, tangents = self._z[active, -1], self._tangents[active, -1]
        places = self._arclengths[active, -1].tolist()
        for branch, *point in zip(active.tolist(), z, tangents, places, strict=True):
            self.points[branch].append((point[0], point[1], point[2]))

    def _leave(self, active: Indices, reason: str) -> None:
        for branch in active.tolist():
            if self.going[branch]:
                self.fates[branch], self.going[branch] = reason, False

    def _halves(self, z: Array) -> Array:
        """Return by how much the halves of orbits differ, in scaled states."""
        half = self._orbits.size // 2
        return np.asarray(z[:, :half] - z[:, half : 2 * half])


def _outside(found: Corrected) -> Indices:
    with np.errstate(invalid="ignore"):
        return np.asarray(np.count_nonzero(np.abs(found.multipliers) > 1, axis=1))


def _length(vectors: Array) -> Array:
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=1)))
