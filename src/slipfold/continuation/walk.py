"""Pseudo-arclength continuation of one curve or of many at the same time, with adapted steps."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic

import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.continuation.curve import Curve, P
from slipfold.continuation.interpolation import (
    POINTS,
    angles_between,
    arc_between,
    arcs,
    derivatives,
    hermite_each,
    lagrange_each,
    lengths_of,
)
from slipfold.continuation.newton import NEWTON, TOO_SHARP, correct
from slipfold.continuation.search import contraction_drift
from slipfold.continuation.settings import Stepping
from slipfold.continuation.step_length import (
    STEP,
    Measures,
    drift,
    ratio_by_geometry,
    ratio_by_tests,
    shortened_after_failure,
)
from slipfold.errors import BREAKDOWNS, breakdown

Bound = tuple[int, float, float]
"""A component of the unknown, with the smallest and the largest value it may take."""


@dataclass(frozen=True, eq=False)
class Corrections:
    """Solutions nearest guesses, a row each; NaN where Newton's method failed."""

    z: Array  # unknowns, shape (k, u)
    tangents: Array  # unit tangents, shape (k, u)
    tests: Array  # test functions, shape (k, f)
    found: Mask  # whether each has a solution, shape (k,)
    moved: Array  # length of the last correction, infinite where there was none, shape (k,)
    point: Any = None  # that of a curve alone, if there is one


class FrontEquations(ABC):
    """The equations of the curves of a front."""

    noise = Curve.noise
    crossing: tuple[int, ...] = ()  # places of the test functions that the curve names so

    @abstractmethod
    def correct(self, rows: Indices, guesses: Array, normals: Array, arclengths: Array) -> Any:
        """Return the solutions nearest guesses, each in the hyperplane through its own.

        Shapes: rows, arclengths (k,); guesses, normals (k, u).
        """

    def aligned(self, rows: Indices, guesses: Array) -> Array:
        """Return the guesses nearest to the last points of those that symmetry makes equivalent."""
        return guesses

    def leaves(self, rows: Indices, result: Any) -> Mask:
        """Return whether each solution lies on another smooth piece than the last point."""
        return np.zeros(len(rows), bool)

    def extrapolated(self, row: int, weights: Array) -> Array | None:
        """Return test functions from extrapolated derivatives, shape (f,); None where unknown."""
        return None

    def contraction_drift(self, row: int) -> float:
        """Return the error of the bound of multipliers, infinite where it excludes no zeros."""
        return np.inf


@dataclass(frozen=True, eq=False)
class Trial:
    """A step tried on each of a few curves."""

    rows: Indices  # the numbers of the curves
    result: Any  # what was corrected
    length: Array  # arclength from the last point
    measures: Measures
    fits: Mask  # whether the step may be accepted


class Front:
    """Curves that are followed at the same time: the last points of each, and its next step.

    Histories have the newest point last.
    """

    def __init__(
        self,
        equations: FrontEquations,
        z: Array,
        tangents: Array,
        tests: Array,
        arclengths: Array,
        step: Array,
        bounds: Sequence[Bound],
        settings: Stepping,
    ) -> None:
        """Begin with c points of each.

        Shapes: z, tangents (k, c, u); tests (k, c, f); arclengths (k, c); step (k,).
        """
        self._equations, self._settings = equations, settings
        (k, count), u = arclengths.shape, z.shape[2]
        known = np.concatenate([z, tangents, tests, arclengths[..., None]], axis=2)
        self._history = np.pad(known, ((0, 0), (POINTS - count, 0), (0, 0)))
        self.z, self.tangents = self._history[..., :u], self._history[..., u : 2 * u]
        self.tests, self.arclengths = self._history[..., 2 * u : -1], self._history[..., -1]
        self.count = np.full(k, count)
        self.step = np.minimum(step, settings.steps.largest)
        self._growth = np.full(k, STEP.longer)
        # Each bound is two walls, beyond which the component has the sign of the direction.
        self._components = np.repeat([index for index, _, _ in bounds], 2).astype(np.int64)
        self._walls = np.array([value for _, low, high in bounds for value in (low, high)])
        self._directions = np.tile([-1.0, 1.0], len(bounds))
        self._held = np.full(k, -1)  # the wall that the next step leads to, -1 if to none
        self._holds = np.zeros(k, int)
        self._alone = k == 1

    def _at(self, rows: Indices) -> Any:
        """Return what selects some curves: of one alone a slice, which copies nothing."""
        return slice(None) if self._alone and len(rows) else rows

    def take(self, rows: Indices) -> Trial:
        """Try a step of each of some curves; where it does not fit, the next one is shorter."""
        at, smallest = self._at(rows), self._settings.steps.smallest
        step = self.step[at]
        target = self.arclengths[at, -1] + step
        guesses, normals = self._predicted(rows, target)
        result = self._equations.correct(rows, guesses, normals, target)
        beyond = self._first_wall(rows, result.z, target, 0.0)
        # In a corner of the window, a point on one wall may lie beyond another.
        beyond[self._holds[at] >= len(self._walls) // 2] = -1
        found, inside = result.found, beyond < 0
        difference, last = result.z - self.z[at, -1], self.tangents[at, -1]
        length, turn = arcs(difference, last, result.tangents)
        on_wall = (np.abs(normals) == 1).any(axis=1)  # there normals predict no tangents
        mistaken = angles_between(normals, result.tangents)
        turn = np.minimum(turn, np.maximum(turn / STEP.turns, np.where(on_wall, 0.0, mistaken)))
        distance = lengths_of(result.z - guesses)
        bends = (mistaken > STEP.angle) & (length > STEP.emanating)  # else rounding decides
        measures = self._measured(rows, result, distance, length, turn, bends)
        # No extrapolation holds from one smooth piece to the next; a monitor locates its end.
        fits = measures.fits | (step <= 4 * smallest) | self._equations.leaves(rows, result)
        # A point that is the last one but for rounding is no step.
        fits &= found & inside & (self.arclengths[at, -1] + length > self.arclengths[at, -1])
        rejected = (inside > fits).nonzero()[0]
        if len(rejected):
            ratio = np.where(
                found,
                np.minimum(measures.factor, STEP.rejected),
                shortened_after_failure(result.moved),
            )
            self.shorten(rows[rejected], ratio[rejected])
        self._held[at] = beyond
        self._holds[at] += ~inside
        return Trial(rows, result, length, measures, fits)

    def shorten(self, rows: Indices, ratio: Array | float) -> None:
        """Shorten the next steps of some curves."""
        self.step[rows] *= ratio
        self._growth[rows], self._held[rows], self._holds[rows] = STEP.harder, -1, 0

    def accept(self, trial: Trial, which: Indices) -> None:
        """Add points of a trial, by their numbers in it."""
        result, which = trial.result, self._at(which)
        rows = self._at(trial.rows[which])
        factor = np.minimum(trial.measures.factor[which], self._growth[rows])
        large = np.maximum(1.0, lengths_of(self.z[rows, -1]) / STEP.large)
        self.step[rows] = np.minimum(self.step[rows] * factor, self._settings.steps.largest * large)
        new = self.arclengths[rows, -1] + trial.length[which]
        parts = (part[which] for part in (result.z, result.tangents, result.tests))
        self._history[rows, :-1] = self._history[rows, 1:]
        self._history[rows, -1] = np.concatenate([*parts, new[:, None]], axis=1)
        self.count[rows] += 1
        self._growth[rows] = np.minimum(STEP.easier * self._growth[rows], STEP.longer)
        self._held[rows], self._holds[rows] = -1, 0

    def by_count(self, rows: Indices) -> Iterator[tuple[int, slice | Indices]]:
        """Yield how many points are known, and which of some curves have so many."""
        counts = np.minimum(self.count[rows], POINTS).tolist()
        if counts.count(counts[0]) == len(counts):
            yield counts[0], slice(None)  # which copies nothing
            return
        for count in sorted(set(counts)):
            yield count, np.flatnonzero(np.equal(counts, count))

    # -- predictions -------------------------------------------------------------------------------

    def _predicted(self, rows: Indices, target: Array) -> tuple[Array, Array]:
        """Return guesses and the normals of their hyperplanes; a guess beyond a wall lies on it."""
        guesses, normals = self._extrapolated(rows, target)
        guesses, held = self._equations.aligned(rows, guesses), self._held[rows]
        held = np.where(held < 0, self._first_wall(rows, guesses, target, STEP.edge), held)
        for i in (held >= 0).nonzero()[0].tolist():
            wall, row = int(held[i]), rows[i : i + 1]
            index, value = self._components[wall], self._walls[wall]
            arclength = self._arclength_at(int(row[0]), wall, target[i])
            guesses[i] = self._equations.aligned(row, self._extrapolated(row, arclength)[0])[0]
            guesses[i, index] = value
            normals[i] = 0.0
            normals[i, index] = np.sign(value - self.z[row[0], -1, index]) or 1.0
        return guesses, normals

    def _extrapolated(self, rows: Indices, target: Array) -> tuple[Array, Array]:
        guesses, normals = np.empty((2, len(rows), self.z.shape[2]))
        for count, which in self.by_count(rows):
            here, last = self._at(rows[which]), slice(-count, None)
            given = self.arclengths[here, last], self.z[here, last], self.tangents[here, last]
            guesses[which], normals[which] = hermite_each(*given, target[which])
        return guesses, normals

    def _first_wall(self, rows: Indices, z: Array, target: Array, tolerance: float) -> Indices:
        """Return the wall that each curve passes first before an unknown, -1 if none."""
        first = np.full(len(rows), -1)
        beyond = self._directions * (z[:, self._components] - self._walls) > tolerance
        for i in beyond.any(axis=1).nonzero()[0].tolist() if beyond.any() else ():
            walls = beyond[i].nonzero()[0].tolist()
            reached = [0.0]  # of one alone it does not matter
            if len(walls) > 1:
                reached = [self._arclength_at(int(rows[i]), wall, target[i])[0] for wall in walls]
            first[i] = min(zip(reached, walls, strict=True))[1]
        return first

    def _arclength_at(self, row: int, wall: int, beyond: float) -> Array:
        """Bisect for the arclength at which the prediction of a curve reaches a wall.

        A fold may lead the curve back to a wall that the prediction leaves: return `beyond` then.
        """
        index, value, rows = self._components[wall], self._walls[wall], np.array([row])

        def component(arclength: Array) -> float:
            return float(self._extrapolated(rows, arclength)[0][0, index])

        near, far = self.arclengths[rows, -1], np.array([beyond])
        rising = self._directions[wall] > 0
        if (component(far) > value) != rising:
            return far
        for _ in range(STEP.bisections):
            middle = 0.5 * (near + far)
            if (component(middle) > value) == rising:
                far = middle
            else:
                near = middle
        return far

    # -- how well steps fit ------------------------------------------------------------------------

    def _measured(
        self,
        rows: Indices,
        result: Any,
        distance: Array,
        length: Array,
        turn: Array,
        bends: Mask,
    ) -> Measures:
        coarse = self._settings.coarse
        error = np.maximum(distance, 1e-12) / (STEP.error * coarse)
        turn = turn / self._settings.steps.turn
        drifted = np.zeros(len(rows))
        for count, which in self.by_count(rows):
            if count > 1:  # nothing is extrapolated from one point
                given = error[which], turn[which], length[which], bends[which]
                drifted[which] = self._drift(rows[which], count, result.tests[which], *given)
        return Measures(error, turn, drifted)

    def _drift(
        self,
        rows: Indices,
        count: int,
        actual: Array,
        error: Array,
        turn: Array,
        length: Array,
        bends: Mask,
    ) -> Array:
        """Return the errors of extrapolated test functions, as far as they limit the steps."""
        noise, coarse = self._equations.noise, self._settings.coarse
        at = self._at(rows)
        values, known = self.tests[at, -count:], self.arclengths[at, -count:]
        expected, weights = lagrange_each(known, values, known[:, -1] + length)
        errors = np.abs(actual - expected)
        drifted = drift(errors, values, actual, noise, coarse)
        allowed = np.minimum(ratio_by_geometry(error, turn), STEP.longer)
        limiting = ratio_by_tests(drifted) < allowed
        jumping = (limiting & (error < STEP.straight)).nonzero()[0]
        if len(jumping):
            own = values[jumping], actual[jumping]
            errors[jumping] = _without_jumps(errors[jumping], *own)
            others = drift(errors[jumping], *own, noise, coarse)
            limiting[jumping] = ratio_by_tests(others) < allowed[jumping]
            drifted[jumping] = np.where(limiting[jumping], drifted[jumping], others)
        # On another curve the tangent turns by the angle between both, which no prediction knows.
        strays = bends & self._strays(values[:, -1], expected, actual) if bends.any() else bends
        # Better predictions, and whether they matter, take longer to compute.
        for i in (limiting | strays).nonzero()[0].tolist():
            row = int(rows[i])
            extrapolated = self._equations.extrapolated(row, weights[i : i + 1])
            if extrapolated is not None:
                better = np.fmin(errors[i], np.abs(actual[i] - extrapolated))
                lines = STEP.lines * min(1.0, error[i] / STEP.straight) * drifted[i]
                drifted[i] = max(drift(better, values[i], actual[i], noise, coarse), lines)
                predicted = np.where(np.isnan(extrapolated), expected[i], extrapolated)
                strays[i] &= self._strays(values[i, -1:], predicted[None], actual[i : i + 1])[0]
            if strays[i]:
                drifted[i] = max(drifted[i], 2 * STEP.reject)
            drifted[i] = min(drifted[i], self._equations.contraction_drift(row) / coarse)
        return drifted

    def _strays(self, last: Array, expected: Array, actual: Array) -> Mask:
        """Return whether steps may lead across a branch point onto the other curve.

        On that the function that is zero there has the opposite sign. So near its zero, if no
        parameter turns there, its prediction must say which sign it has. Shapes: (k, f).
        """
        if not self._equations.crossing:
            return np.zeros(len(last), bool)
        functions = np.array([last, expected, actual])
        (was, due, now), slope = (functions[..., place] for place in self._equations.crossing)
        approaches = (due * np.sign(was) < np.abs(was)) & (slope * slope[0] > 0).all(axis=0)
        falls = np.abs(now * slope[0]) < STEP.falls * np.abs(was * slope[2])
        unsure = np.abs(due - now) > np.maximum(np.abs(now), self._equations.noise)
        return np.asarray(approaches & unsure & (falls | (due * now < 0)))


def _without_jumps(errors: Array, values: Array, actual: Array) -> Array:
    """Return the errors of extrapolated test functions, zero for those that jump.

    Where the curve is nearly straight, but multipliers pass the unit circle within a small part of
    a step, no shorter step predicts that. The jump is located anyway, as all changes of sign are;
    the values before it say nothing about those after it.

    Shapes: errors, actual (k, f); values (k, c, f).
    """
    last = values[:, -1]
    jumped = ((values > 0) != (last[:, None] > 0)).any(axis=1)
    errors = np.where(jumped, np.abs(actual - last), errors)
    return np.where((last > 0) != (actual > 0), 0.0, errors)


# -- a curve alone ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Failure:
    """Why no further point was found."""

    kind: str  # ``"failed"`` or ``"points"``
    reason: str  # a sentence


ONLY: Indices = np.zeros(1, dtype=np.int64)
"""The number of a curve alone."""


def first_point(curve: Curve[P], start: P, step: float, settings: Stepping) -> P | Failure:
    """Return the point a step beyond another, whatever the bounds."""
    return CurveSteps(curve, [start], step, (), settings).next_point()


def reaches(point: P, bounds: Sequence[Bound]) -> bool:
    """Whether a point lies on a bound."""
    return any(point.z[index] in (low, high) for index, low, high in bounds)


class CurveSteps(FrontEquations, Generic[P]):
    """Steps along one curve: its corrections use the derivatives at its last points."""

    def __init__(
        self,
        curve: Curve[P],
        start: Sequence[P],
        step: float,
        bounds: Sequence[Bound],
        settings: Stepping,
    ) -> None:
        self.recent = list(start)[-NEWTON.known :]
        self.noise = curve.noise
        self._curve, self._settings, self._bounds = curve, settings, bounds
        self._reason = TOO_SHARP
        self._corrected: P | None = None
        self.predicted = True  # whether the last step fits, also if it leaves its smooth piece
        self._nears_end = False  # whether a step failed since it went beyond the end of the model
        self.crossing = tuple(map(list(self.recent[-1].tests).index, curve.crossing))
        names = ("z", "tangent", "values", "arclength")
        last = self.recent[-POINTS:]
        z, *rest = (np.array([[getattr(point, name) for point in last]]) for name in names)
        self.front = Front(self, z, rest[0], rest[1], rest[2], np.array([step]), bounds, settings)

    def points(
        self, cap: Callable[[P], float] | None = None, taken: int = 0
    ) -> Iterator[P | Failure]:
        """Follow the curve, on which steps were taken, until a parameter leaves its bounds."""
        for _ in range(taken, self._settings.steps.points):
            if cap is not None:
                self.front.step = np.minimum(self.front.step, cap(self.recent[-1]))
            point = self.next_point()
            yield point
            if isinstance(point, Failure) or reaches(point, self._bounds):
                return
        points = self._settings.steps.points
        yield Failure("points", f"{points} points were not enough; allow more points")

    def next_point(self) -> P | Failure:
        """Take a step, shortening it until it is accepted."""
        front, smallest = self.front, self._settings.steps.smallest
        self._reason = TOO_SHARP
        if self._nears_end:
            front.step = np.minimum(front.step, self._before_end)
        while front.step[0] >= smallest:
            tried = front.step[0]
            trial = front.take(ONLY)
            if trial.fits[0]:
                front.accept(trial, ONLY)
                self.predicted = bool(trial.measures.fits[0])
                self.recent = [*self.recent, trial.result.point][-NEWTON.known :]
                return self.recent[-1]
            if not trial.result.found[0] and self._before_end < tried:
                self._nears_end = True
                front.step[:] = self._before_end
        return Failure("failed", f"the step fell below {smallest:g}: {self._reason}")

    @property
    def _before_end(self) -> float:
        """Longest step that stays before the end of the model, as far as that is in sight."""
        return STEP.toward_end * self._curve.ahead(self.recent)

    def correct(
        self, rows: Indices, guesses: Array, normals: Array, arclengths: Array
    ) -> Corrections:
        """Return the solution nearest the guess."""
        guess, row, arclength = guesses[0], normals[0], float(arclengths[0])
        newton, reach = self._settings.newton, STEP.reach * self._settings.coarse
        moved, self._corrected = np.inf, None
        try:
            expected = derivatives(self._curve, self.recent, arclength)
            given = newton.tolerance, newton.iterations, reach, expected
            correction = correct(self._curve, guess, row, *given)
            moved, self._reason = correction.moved, correction.failure or TOO_SHARP
            if correction.converged:
                solution, last = self._curve.point(correction, arclength), self.recent[-1]
                arclength = last.arclength + arc_between(last, solution)
                self._corrected = replace(solution, arclength=arclength)
        except BREAKDOWNS as error:
            moved, self._reason = np.inf, breakdown(error)
        point, last = self._corrected, self.recent[-1]
        parts = (getattr(point or last, name)[None] for name in ("z", "tangent", "values"))
        z, tangents, tests = parts if point else (part * np.nan for part in parts)
        found = np.array([point is not None])
        return Corrections(z, tangents, tests, found, np.array([moved]), point)

    def aligned(self, rows: Indices, guesses: Array) -> Array:
        """Return the guess nearest to the last point of those that symmetry makes equivalent."""
        return self._curve.aligned(guesses[0], self.recent[-1].z)[None]

    def leaves(self, rows: Indices, result: Corrections) -> Mask:
        """Return whether the solution lies on another smooth piece than the last point."""
        point = result.point
        return np.array([point is not None and point.piece != self.recent[-1].piece])

    def extrapolated(self, row: int, weights: Array) -> Array | None:
        """Return test functions from extrapolated derivatives, shape (f,); None where unknown."""
        found = self._curve.extrapolated(self.recent[-weights.shape[1] :], weights)
        return None if found is None else found[0]

    def contraction_drift(self, row: int) -> float:
        """Return the error of the bound of multipliers, infinite where it excludes no zeros."""
        assert self._corrected is not None
        return contraction_drift(self.recent[-POINTS:], self._corrected)
