"""Branches of one period of many cases, followed together, each with its own steps.

Step lengths, acceptance and tests of what lies between two points follow the rules of a single
curve (`continuation.step_length`, `continuation.search`). Where that one would be searched, the
step is taken again at half its length. A branch is left, to be followed individually, if anything
happens on it but folds, period doublings and tori.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.bifurcations.branches.closed_branches import CLOSING
from slipfold.bifurcations.branches.stops import STOP
from slipfold.continuation.curve import Point
from slipfold.continuation.end import End
from slipfold.continuation.interpolation import POINTS, lengths_of
from slipfold.continuation.locate import Guesses
from slipfold.continuation.search import Interpolated, locating_test
from slipfold.continuation.settings import Stepping, Steps
from slipfold.continuation.step_length import STEP
from slipfold.continuation.traced_curve import Found
from slipfold.continuation.walk import Front, FrontEquations, Trial
from slipfold.flow.modes import limits_of_contacts
from slipfold.orbits.orbit_batch import TESTS, Corrected, OrbitBatch
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.test_functions import are_neutral


class BATCH:
    """Rules for following responses in batches."""

    # A correction shorter than this is the last: the next one would be as long as its square
    close: float = 1e-5
    # Error of a step in time along a branch. Orbits and multipliers are then known to 1e-6: enough
    # to choose steps and to bracket what is located more exactly
    roughly: float = 1e-8
    # A branch that needs a smaller step is left
    smallest: float = 1e-6
    # Largest multiplier, and largest change of an orbit by an error where a multiplier is near one.
    # Beyond, rounding begins to matter, and the branch is left
    amplified: float = 1e6
    # Steps of each branch after which those that have not ended are left
    max_rounds: int = 400
    # A correction shorter than this is the last: test functions are those before it
    last_step: float = 1e-8
    # Arclength to which a zero is located: less than on a curve alone, whose values are all exact
    zero: float = 1e-13
    # Orbits at the end of a branch between which a limit may lie: near a singularity explicit steps
    # are too inexact to show on which side of it they lie
    last: int = 3
    # Step beyond a limit, over its estimated distance; less if there is no orbit at its end, so
    # near to a singularity
    beyond: float = 1.5
    # Ratio of such a step to one before it that met no orbit
    shorter: float = 0.7
    # Maximum number of such steps; one is enough where margins fall in proportion to arclengths
    attempts: int = 12
    # Maximum of such a step, over the distance of the last two orbits: explicit steps may break the
    # limit up to three of these before the flow itself does
    max_distance: float = 5.0
    # Minimum number of cases for a batch: four are as quick individually, and compiling takes
    # seconds
    minimum_size: int = 16
    # Cases of a batch, in a small study and a large one: each takes a sixth longer in one of 64
    sizes: tuple[int, int] = 64, 128


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
    origin: Found[OrbitPoint] | None = None  # the period doubling at which it begins
    first: OrbitPoint | None = None  # its first orbit, if it begins on another branch
    stable: bool = False  # whether the first orbit is; not known of one that begins on another
    end: str = ""  # "span", "limit", "loss" of stability, or why it was left
    brackets: list[Bracket] = field(default_factory=list)  # of its bifurcations, in order
    found: list[Found[OrbitPoint]] = field(default_factory=list)  # its bifurcations, in order
    loss: Found[OrbitPoint] | None = None  # the one at which it loses its stability
    # Of complete branches alone: all points, and the end in words
    points: list[OrbitPoint] = field(default_factory=list)
    stopped: End | None = None

    @property
    def ordinary(self) -> bool:
        """Whether it ended in a way that a batch can describe."""
        return self.end in ("span", "limit", "loss")


@dataclass(frozen=True, eq=False)
class Bracket:
    """Two neighboring points of a branch between which a function changes its sign."""

    case: int
    orbits: Orbits
    kind: str
    # The two points, and others near them that are interpolated as well
    z: Array  # shape (k, u)
    tangents: Array  # shape (k, u)
    arclengths: Array  # shape (k,)
    values: Array  # of the function, shape (k,)
    unstable: tuple[int, int] = (0, 0)  # multipliers outside the unit circle at either

    def locating(self, close: float) -> Guesses[Found[Any]]:
        """Search for the zero between them, of a test of points that is called as its kind."""
        curve: Any = self.orbits
        tests = [{self.kind: value} for value in self.values.tolist()]
        parts = zip(self.z, self.tangents, self.arclengths.tolist(), tests, strict=True)
        a, b, *others = (Point(*part, 0, np.nan) for part in parts)
        history = sorted([a, b, *others], key=lambda item: item.arclength)
        return locating_test(curve, history, a, b, self.kind, self.kind, close)


class Walk(FrontEquations):
    """Follows branches to their ends, and brackets what is to be located on them.

    The last point of a branch that ends at a limit is the first orbit that breaks it. If `to_loss`,
    a branch ends at the first point after it has lost its stability.
    """

    crossing = FOLD, LP

    def __init__(
        self,
        orbits: OrbitBatch,
        branches: Sequence[BatchedBranch],
        span: tuple[float, float],
        steps: Steps,
        *,
        to_loss: bool,
    ) -> None:
        k = len(branches)
        self._orbits, self._branches, self._to_loss = orbits, branches, to_loss
        self._cases = np.array([branch.case for branch in branches])
        self._low, self._high = (value / orbits.width for value in (min(span), max(span)))
        model = orbits.model
        self._bounds = np.array([limit.bound for limit in model.limits])
        sticking = limits_of_contacts(model)
        self._sticking = np.array([limit.name in sticking for limit in model.limits], bool)
        self._unstable, self._signs = np.zeros(k, int), np.zeros(k)
        self._departs = np.array([branch.first is not None for branch in branches])
        self._active: Mask = np.ones(k, bool)
        z, tangents = (np.array([branch.steps[0][i] for branch in branches]) for i in (0, 1))
        tests, step = np.zeros((k, len(TESTS))), np.full(k, STEP.first)
        self._correct_first_orbits(z, tangents, tests)
        self._choose_first_steps(z, tangents, step)
        start = z[:, None], tangents[:, None], tests[:, None], np.zeros((k, 1))
        settings = Stepping(steps=replace(steps, smallest=BATCH.smallest / 4))
        self._front = Front(self, *start, step, [(-1, self._low, self._high)], settings)
        self._points = steps.points
        for branch in branches:
            branch.steps.clear()
        self._store_points(np.arange(k))

    def run(self, report: Callable[[float], None] = lambda fraction: None) -> None:
        """Follow all branches to their ends; report after each step how far they have come.

        The parameter may go back at folds; the reported fraction does not.
        """
        fraction = 0.0
        for _ in range(BATCH.max_rounds):
            active = np.flatnonzero(self._active)
            if not len(active):
                return
            self._take_steps(active)
            fraction = max(fraction, self._fraction)
            report(fraction)
        self._stop(np.flatnonzero(self._active), "points")

    def correct(
        self, rows: Indices, guesses: Array, normals: Array, arclengths: Array
    ) -> Corrected:
        """Return the orbits nearest guesses, those on an end of the span exactly on it."""
        given = self._cases[rows], guesses, normals
        result = self._orbits.correct(*given, BATCH.close, STEP.reach, BATCH.roughly)
        at_end = np.abs(normals[:, -1]) == 1
        result.z[at_end, -1] = guesses[at_end, -1]
        return result

    @property
    def _fraction(self) -> float:
        """How far they have come through the span, on average; those that ended are through."""
        first = np.array([branch.steps[0][0][-1] for branch in self._branches])
        come = np.abs(self._front.z[:, -1, -1] - first) / (self._high - self._low)
        return float(np.where(self._active, np.minimum(come, 1.0), 1.0).mean())

    # -- where branches begin --------------------------------------------------------------------

    def _correct_first_orbits(self, z: Array, tangents: Array, tests: Array) -> None:
        """Correct the first orbits of branches that begin on no other. Shapes: (k, ...)."""
        rows = np.flatnonzero(~self._departs)
        if not len(rows):
            return
        given = self._cases[rows], z[rows], tangents[rows]
        result = self._orbits.correct(*given, BATCH.close, np.inf, BATCH.roughly)
        z[rows], tangents[rows], tests[rows] = result.z, result.tangents, result.tests
        self._signs[rows], self._unstable[rows] = result.signs, _unstable(result)
        for row, count in zip(rows.tolist(), self._unstable[rows], strict=True):
            self._branches[row].stable = bool(count == 0)
        clear = result.found & (result.seen.above > self._bounds).all(axis=1)
        self._stop(rows[~clear], "first orbit")

    def _choose_first_steps(self, z: Array, tangents: Array, step: Array) -> None:
        """Leave another branch by a step so short that nothing else can happen within it."""
        active = np.flatnonzero(self._departs)
        firsts = [branch.first for branch in self._branches if branch.first is not None]
        others = [np.delete(p.multipliers, np.abs(p.multipliers - 1).argmin()) for p in firsts]
        outside = np.array([np.count_nonzero(np.abs(item) > 1) for item in others])
        step[active] = STEP.emanating
        for _ in range(6):
            if not len(active):
                return
            along = step[active, None] * tangents[active]
            result, nearer = (
                self._orbits.correct(
                    self._cases[active],
                    z[active] + fraction * along,
                    tangents[active],
                    *(BATCH.close, STEP.reach, BATCH.roughly),
                )
                for fraction in (1.0, 0.25)
            )
            more = _unstable(result) - outside
            with np.errstate(invalid="ignore"):
                good = result.found & nearer.found & ((more == 0) | (more == 1))
                good &= result.tests[:, LP] * nearer.tests[:, LP] > 0
            active, outside = active[~good], outside[~good]
            step[active] /= 4
        self._stop(active, "emanating branch")

    # -- a step of each --------------------------------------------------------------------------

    def _take_steps(self, active: Indices) -> None:
        front = self._front
        if self._orbits.period % 2 == 0:
            apart = 0.9 * lengths_of(self._halves(front.z[active, -1]))
            front.step[active] = np.minimum(front.step[active], np.maximum(STEP.emanating, apart))
        trial = front.take(active)
        tests, ambiguous = self._examined(trial)
        accepted = trial.fits & ~ambiguous
        front.shorten(active[trial.fits & ambiguous], 0.5)
        self._stop(active[~accepted & (front.step[active] < BATCH.smallest)], "steps")
        for row in np.flatnonzero(accepted & (tests >= 0)).tolist():
            self._add_bracket(trial, row, int(tests[row]))
        self._accept(trial, np.flatnonzero(accepted))

    # -- what lies between two points ------------------------------------------------------------

    def _examined(self, trial: Trial) -> tuple[Indices, Mask]:
        """Return which test function has a zero, -1 where none has, and which steps are ambiguous.

        A step is ambiguous if zeros may hide in it, or if changes of sign do not explain how the
        number of unstable multipliers changes.
        """
        front, active, result, fits = self._front, trial.rows, trial.result, trial.fits
        regular = self._is_regular(active)
        ambiguous = np.zeros(len(active), bool)
        chosen = np.flatnonzero(fits & regular)
        for count, same in front.by_count(active[chosen]) if len(chosen) else ():
            which = chosen[same]
            here = active[which]
            last = front.arclengths[here, -1]
            new = last + trial.length[which]
            # The nearest first; their two ends are the points of number 1 and 0.
            where = np.column_stack([new, front.arclengths[here, : -count - 1 : -1]])
            history = front.tests[here, : -count - 1 : -1]
            values = np.concatenate([result.tests[which, None], history], axis=1)
            noise, at_ends = self._branches[0].orbits.noise, values[:, 1::-1]
            given = where, values, (last, new), at_ends, (1, 0), noise
            ambiguous[which] = Interpolated.between(*given).ambiguous.any(axis=1)
        changed = (front.tests[active, -1] > 0) != (result.tests > 0)
        changed &= regular[:, None]
        change = np.where(regular, np.abs(_unstable(result) - self._unstable[active]), 0)
        tests, explained = single_events(changed, change)
        # What is located must lie before a limit: on the last step of a branch is nothing.
        ambiguous |= (tests >= 0) & ~(result.seen.above > self._bounds).all(axis=1)
        self._stop(active[fits & ~ambiguous & changed[:, FOLD] & ~changed[:, LP]], "crossing")
        return tests, np.asarray(ambiguous | ~explained)

    def _is_regular(self, rows: Indices) -> Mask:
        """Whether the last point of each branch is not one of another branch, too."""
        return np.asarray(~(self._departs[rows] & (self._front.count[rows] == 1)))

    def _add_bracket(self, trial: Trial, row: int, test: int) -> None:
        number, front, result = int(trial.rows[row]), self._front, trial.result
        branch, last = self._branches[number], front.arclengths[number, -1]
        bracket = Bracket(
            branch.case,
            branch.orbits,
            TESTS[test],
            np.array([front.z[number, -1], result.z[row]]),
            np.array([front.tangents[number, -1], result.tangents[row]]),
            np.array([last, last + trial.length[row]]),
            np.array([front.tests[number, -1, test], result.tests[row, test]]),
            (int(self._unstable[number]), int(_unstable(result)[row])),
        )
        branch.brackets.append(bracket)

    def _accept(self, trial: Trial, rows: Indices) -> None:
        """Add points, and stop branches that end there or are left."""
        front, result, active = self._front, trial.result, trial.rows[rows]
        regular, before, signs = self._is_regular(active), front.z[active, -1], self._signs[active]
        crosses = (result.signs[rows] != signs) & (signs != 0)
        self._stop(active[regular & crosses], "crossing")
        front.accept(trial, rows)
        self._store_points(active)
        unstable, was_stable = _unstable(result)[rows], self._unstable[active] == 0
        self._signs[active], self._unstable[active] = result.signs[rows], unstable
        multipliers = result.multipliers[rows]
        near_one = np.abs(multipliers - 1).min(axis=1) < STOP.one
        undetermined = near_one & (result.stiffness[rows] > BATCH.amplified)
        self._stop(active[regular & undetermined], "undetermined")
        self._stop(active[np.abs(multipliers).max(axis=1) > BATCH.amplified], "growth")
        self._stop(active[regular & are_neutral(multipliers).any(axis=1)], "undamped")
        if self._orbits.period % 2 == 0:
            here, there = self._halves(before), self._halves(front.z[active, -1])
            near = lengths_of(there) < np.minimum(0.1 * STEP.emanating, lengths_of(here))
            self._stop(active[regular & (((here * there).sum(axis=1) < 0) | near)], "copy")
        # Where it turned back it may come to its beginning.
        away = ~self._departs[active] & (front.count[active] > POINTS + 1)
        starts = [self._branches[number].steps[0][0] for number in active.tolist()]
        first = np.array(starts).reshape(before.shape)
        ahead = ((first - before) * front.tangents[active, -2]).sum(axis=1) > 0
        near = lengths_of(first - before) <= CLOSING.around * trial.length[rows]
        self._stop(active[away & ahead & near], "returns")
        if self._to_loss:
            self._stop(active[was_stable & (unstable > 0)], "loss")
        self._stop_at_bounds(active, result.seen.lowest[rows], result.seen.above[rows])

    def _stop_at_bounds(self, active: Indices, lowest: Array, above: Array) -> None:
        """End branches at limits and bounds. Shapes: lowest, above (k, n_limits)."""
        front, broken = self._front, np.asarray(lowest <= self._bounds)
        unsure = np.flatnonzero((above <= self._bounds).any(axis=1) & ~broken.any(axis=1))
        here = active[unsure]
        broken[unsure] = ~(self._orbits.margins(self._cases[here], front.z[here, -1]) > 0)
        self._stop(active[(broken & self._sticking).any(axis=1)], "stick")
        at_end = (front.z[active, -1, -1] == self._low) | (front.z[active, -1, -1] == self._high)
        self._stop(active[broken.any(axis=1)], "limit")
        self._stop(active[at_end], "span")
        self._stop(active[front.count[active] >= self._points], "points")

    def _store_points(self, active: Indices) -> None:
        front = self._front
        z, tangents = front.z[active, -1], front.tangents[active, -1]
        arclengths = front.arclengths[active, -1].tolist()
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


def single_events(changed: Mask, change: Indices) -> tuple[Indices, Mask]:
    """Return the test function whose zero explains each step, and which steps are explained.

    At most one function has a zero in a step, -1 stands for none; a fold has one of two. `change`
    is by how much the number of unstable multipliers differs. Shapes: changed (k, f), change (k,).
    """
    tests, alone = np.full(len(changed), -1), changed.sum(axis=1) == 1
    tests[changed[:, PD] & alone & (change == 1)] = PD
    tests[changed[:, NS] & alone & ((change == 2) | (change == 0))] = NS
    folds = changed[:, LP] & changed[:, FOLD] & (changed.sum(axis=1) == 2) & (change == 1)
    tests[folds] = LP
    return tests, np.asarray((tests >= 0) | (~changed.any(axis=1) & (change == 0)))


def _unstable(result: Corrected) -> Indices:
    """Return how many multipliers of each orbit lie outside the unit circle."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.count_nonzero(np.abs(result.multipliers) > 1, axis=1))
