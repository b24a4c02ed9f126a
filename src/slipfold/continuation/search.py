"""All zeros of test functions between two neighboring points of a curve, none missed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import Any, Generic

import numpy as np
from numpy.polynomial import Polynomial

from slipfold.arrays import Array, Mask
from slipfold.continuation.curve import Curve, P, Point
from slipfold.continuation.interpolation import lagrange, polynomial_weights, well_spaced
from slipfold.continuation.locate import (
    ZERO,
    Guesses,
    LostCurveError,
    corrected,
    insert,
    locating,
    point_at,
)
from slipfold.continuation.traced_curve import Found, MonitorResult, StepInterval


class Zeros(Generic[P]):
    """A monitor of functions that change their sign: it locates all their zeros.

    This class monitors all test functions of the points, and records zeros by their names.
    """

    def __init__(self, curve: Curve[P]) -> None:
        self.curve = curve

    @property
    def noise(self) -> float:
        """What of the functions at a point is rounding."""
        return self.curve.noise

    def values(self, point: P) -> Array:
        """Return the functions at a point."""
        return point.values

    def extrapolated(self, points: Sequence[P], weights: Array) -> Array | None:
        """Return predictions of the functions that use more than their values at points.

        None where nothing else is known. Shapes: weights (t, points); returns (t, functions).
        """
        return self.curve.extrapolated(points, weights)

    def __call__(self, interval: StepInterval[P]) -> MonitorResult[P]:
        """Locate all zeros between two neighboring points."""
        found = self.search(interval.history, interval.before, interval.point)
        return self.seen(found, interval)

    def seen(self, found: Sequence[Found[P]], interval: StepInterval[P]) -> MonitorResult[P]:
        """Return the consequence of the zeros: here they are recorded."""
        return MonitorResult(found)

    def search(self, history: list[P], a: P, b: P, depth: int = 0) -> list[Found[P]]:
        """Return the special points between two points.

        A sign change brackets a zero. Two zeros between the points leave no sign change. So the
        test functions are interpolated; where one may come near zero, the point there is computed
        and both halves are searched. The interval is halved as well if its special points do not
        explain how the two points differ, and divided between two zeros that lie near each other.
        """
        between, middle, last = _between(self, history, a, b), None, depth >= ZERO.depth
        if between.ambiguous.any() and self.excludes(a, b):
            return []
        arclength = None if last else between.ambiguous_arclength
        if arclength is None:
            found = self.located(history, a, b)
            explained = self.accounts_for(found, a, b)
            if depth <= ZERO.depth + ZERO.deeper and (last or explained):
                middle = self._between_zeros(history, a, b, between)
            if middle is None and last and not explained:
                found = self.hidden(found, history, a, b)
            if middle is None and (last or explained):
                return sorted(found, key=lambda item: item.point.arclength)
            arclength = 0.5 * (a.arclength + b.arclength)
        middle = middle or self._point_between(history, a, b, arclength)
        insert(history, middle)
        left = self.search(history, a, middle, depth + 1)
        return left + self.search(history, middle, b, depth + 1)

    def _between_zeros(self, history: Sequence[P], a: P, b: P, between: Interpolated) -> P | None:
        """Return a point between two zeros of a function near each other, None if none is found.

        Curves may cross where a function has a double zero; beside that point the equations are
        singular, and no interval is divided there. Exact values say how low the function is.
        """
        known, noise = [*history], self.noise
        for index, arclength, sign in between.dips():
            for _ in range(ZERO.corrections):
                try:
                    point = point_at(self.curve, known, arclength)
                except LostCurveError:
                    break
                inside = a.arclength < point.arclength < b.arclength
                if not (inside and _leads_along(point, a, b)):
                    break
                value = sign * self.values(point)[index]
                if value < -noise:
                    return point
                insert(known, point)
                near = well_spaced(known, point.arclength, point.arclength, ZERO.knots)
                values = [sign * self.values(item)[index] for item in near]
                arclength, least = _minimum([item.arclength for item in near], values)
                if value <= noise or not least < ZERO.dip * value:
                    break
        return None

    def _point_between(self, history: list[P], a: P, b: P, arclength: float) -> P:
        """Return a point of the curve between two, at an arclength or elsewhere.

        Near a branch point Newton's method may converge to the curve that crosses: its tangent is
        that of neither end.
        """
        length = b.arclength - a.arclength
        for place in (arclength, *(a.arclength + fraction * length for fraction in ZERO.elsewhere)):
            point = point_at(self.curve, history, place)
            if _leads_along(point, a, b):
                break
        return point

    def excludes(self, a: P, b: P) -> bool:
        """Whether there can be no zero between two points, whatever the functions do."""
        return False

    def located(self, history: list[P], a: P, b: P) -> list[Found[P]]:
        """Return the genuine zeros where a function changes its sign between two points."""
        names = [name for name in a.tests if self.changes_sign(name, a, b)]
        found = [locate_test(self.curve, history, a, b, name, name) for name in names]
        return [item for item in found if self.is_genuine(item)]

    def changes_sign(self, name: str, a: P, b: P) -> bool:
        """Whether a test function is positive at one of two points only."""
        before, after = a.tests[name], b.tests[name]
        return isfinite(before) and isfinite(after) and (before > 0) != (after > 0)

    def is_genuine(self, found: Found[P]) -> bool:
        """Whether a zero is of the type that its name says."""
        return True

    def accounts_for(self, found: list[Found[P]], a: P, b: P) -> bool:
        """Whether the special points between two points explain how these differ."""
        return True

    def hidden(self, found: list[Found[P]], history: list[P], a: P, b: P) -> list[Found[P]]:
        """Return what was found and points that no function shows as they are."""
        return found


def locate_test(curve: Curve[P], history: list[P], a: P, b: P, kind: str, test: str) -> Found[P]:
    """Locate the zero of a test function between two points."""
    return corrected(curve, locating_test(curve, history, a, b, kind, test))


def locating_test(
    curve: Curve[P], history: list[P], a: P, b: P, kind: str, test: str, close: float = ZERO.close
) -> Guesses[Found[P]]:
    """Search for the zero of a test function between two points."""
    point = yield from locating(curve, history, a, b, lambda item: item.tests[test], close)
    apart = max(ZERO.apart, ZERO.many * close)
    return Found(kind, point, slope_at(lambda item: item.tests[test], history, point, a, b, apart))


def slope_at(
    function: Callable[[P], float],
    history: Sequence[P],
    point: P,
    a: P,
    b: P,
    apart: float = ZERO.apart,
) -> float:
    """Return the derivative of a function of points at its zero between two of them.

    It is the secant to the nearest other point that is so far apart, or else that of the two.
    Points far from the origin, in the scales of the unknown, are known less well.
    """
    apart *= max(1.0, float(np.linalg.norm(point.z)))

    def away(item: P) -> float:
        return abs(item.arclength - point.arclength)

    nearest = min((item for item in history if away(item) >= apart), key=away, default=None)
    first, last = (a, b) if nearest is None else (point, nearest)
    return float((function(last) - function(first)) / (last.arclength - first.arclength))


def _leads_along(point: Point, a: Point, b: Point) -> bool:
    """Whether the tangent of a point is near that of one of two others."""
    return max(abs(float(point.tangent @ end.tangent)) for end in (a, b)) > ZERO.along


def _minimum(where: Sequence[float], values: Sequence[float]) -> tuple[float, float]:
    """Return where the polynomial through values is least, next to the first, and its value."""
    places = np.array(where) - where[0]
    found = Polynomial.fit(places, values, len(places) - 1)
    zeros = found.deriv().roots()
    least = zeros.real[(zeros.imag == 0) & (found.deriv(2)(zeros.real) > 0)]
    nearest = least[np.abs(least).argmin()] if len(least) else np.nan
    return float(where[0] + nearest), float(found(nearest))


def _between(monitor: Zeros[P], history: Sequence[P], a: P, b: P) -> Interpolated:
    """Return the test functions between two points.

    Each function is interpolated in two ways: its values, and the quantities it is computed from.
    The interpolation that changes less if a point is left out is the better one.
    """
    near = well_spaced(history, a.arclength, b.arclength, ZERO.knots)
    return Interpolated.between(
        np.array([point.arclength for point in near]),
        np.array([monitor.values(point) for point in near]),
        (a.arclength, b.arclength),
        np.array([monitor.values(a), monitor.values(b)]),
        (_index(near, a), _index(near, b)),
        monitor.noise,
        lambda weights: monitor.extrapolated(near, weights),
    )


def _index(points: Sequence[P], point: P) -> int:
    """Return the index of a point among others, -1 if it is not among them."""
    return next((i for i, item in enumerate(points) if item is point), -1)


# -- test functions between two points, of one curve or of many -----------------------------------


def arclengths_between(first: float | Array, last: float | Array) -> Array:
    """Return arclengths between two points, shape (t,); or of each of many curves, shape (k, t)."""
    spacing = np.asarray((last - first) / (ZERO.grid + 1))[..., None]
    return np.arange(1, ZERO.grid + 1) * spacing + np.asarray(first)[..., None]


def interpolation_weights(
    where: Array, grid: Array, ends: tuple[Any, Any], numbers: tuple[int, int]
) -> Array:
    """Return the weights of points in interpolations, those of one arclength in a row.

    The first rows are for a grid between two ends, the next for the same grid without the last
    point, which is the farthest away, the last two for the ends without the points that lie there.
    These are given by number, -1 where there is none.

    Shapes: where (c,), grid (t,), returns (2 t + 2, c); or of each of many curves (k, ...).
    """
    size, count = grid.shape[-1], where.shape[-1]
    weights = np.zeros((*grid.shape[:-1], 2 * size + 2, count))
    weights[..., :size, :] = inside = polynomial_weights(where, grid)
    farthest = where[..., -1:]
    factors = (where[..., :-1] - farthest)[..., None, :] / (grid - farthest)[..., None]
    weights[..., size:-2, :-1] = inside[..., :-1] * factors
    places: Sequence = where.tolist() if where.ndim == 1 else list(where.T)
    for row, end, number in zip((-2, -1), ends, numbers, strict=True):
        others = [i for i in range(count) if i != number]
        weights[..., row, others] = lagrange([places[i] for i in others], end).T
    return weights


@dataclass(frozen=True, eq=False)
class Interpolated:
    """Test functions between two points of a curve; of many curves with a first axis."""

    grid: Array  # arclengths between the points, shape (t,)
    inside: Array  # the functions there, shape (t, f)
    errors: Array  # their changes if the point farthest away is left out, shape (t, f)
    ends: Array  # the functions at the points, shape (2, f)
    end_errors: Array  # their differences from the interpolation of the others, shape (2, f)
    noise: float  # what of them is rounding

    @staticmethod
    def between(
        where: Array,
        values: Array,
        ends: tuple[Any, Any],
        at_ends: Array,
        numbers: tuple[int, int],
        noise: float,
        predicted: Callable[[Array], Array | None] = lambda weights: None,
    ) -> Interpolated:
        """Interpolate functions between two ends from their values at c points near.

        Where that is ambiguous, predictions with the weights of `interpolation_weights` are taken
        if these are better. Shapes: where (c,), values (c, f), at_ends (2, f).
        """
        grid = arclengths_between(*ends)
        weights, size = interpolation_weights(where, grid, ends, numbers), grid.shape[-1]

        def errors(values: Array) -> Array:
            return np.abs(values[..., :size, :] - values[..., size:-2, :])

        def found(values: Array) -> Interpolated:
            away = np.abs(at_ends - values[..., -2:, :])
            return Interpolated(grid, values[..., :size, :], errors(values), at_ends, away, noise)

        values = weights @ values
        own = found(values)
        better = predicted(weights) if own.ambiguous.any() else None
        if better is None:
            return own
        less = errors(better).max(axis=-2) < errors(values).max(axis=-2)
        return found(np.where(less[..., None, :], better, values))

    @cached_property
    def ambiguous(self) -> Mask:
        """Whether each may reach zero, or have more zeros than its signs show, shape (f,)."""
        return np.asarray(self._near_zero | self._dips)

    @cached_property
    def _near_zero(self) -> Mask:
        """Whether the grid shows that; shape (f,).

        The error between the points is at most the change that one point less would make. If a
        function is near zero at a point and its error there is large, its slope is not known, and
        it may have crossed zero.
        """
        unsure = np.abs(self.ends) < ZERO.unsure * self.end_errors
        found = (self._above_zero.min(axis=-2) < 0) | unsure.any(axis=-2)
        if self._crosses.any():
            several = np.count_nonzero(self._changes, axis=-2) > 1
            found = np.where(self._crosses, several, found)
        return self._defined(found)

    @cached_property
    def _dips(self) -> Mask:
        """Whether each may go beyond zero between two places, by more than rounding; shape (f,)."""
        return self._defined(np.asarray((self._bottoms[0] < -self.noise).any(axis=-2)))

    def _defined(self, found: Mask) -> Mask:
        """Return what holds of functions that are not undefined, or zero, everywhere."""
        if found.any():
            found &= np.isfinite(self.inside).all(axis=-2) & (self.ends != 0).any(axis=-2)
        return np.asarray(found)

    @property
    def ambiguous_arclength(self) -> float | None:
        """Where the first of them on one curve is near zero on the grid, None if none is."""
        grid = self.grid
        for index in self._near_zero.nonzero()[0].tolist():
            if self._crosses[index]:
                changes = self._changes[:, index].nonzero()[0]
                return float(grid[min(changes[1], len(grid) - 1)])
            above = self._above_zero[:, index]
            lowest = int(above.argmin())
            return float(grid[lowest] if above[lowest] < 0 else 0.5 * (grid[0] + grid[-1]))
        return None

    def dips(self) -> Iterator[tuple[int, float, float]]:
        """Yield the numbers of those on one curve that may dip, where, and their signs there."""
        low, away = self._bottoms
        for index in self._dips.nonzero()[0].tolist():
            place = int(low[:, index].argmin())
            arclength = self.grid[place] + away[place, index] * (self.grid[1] - self.grid[0])
            beside = self.inside[place] if self._crosses[index] else self.ends[0]
            yield index, float(arclength), float(np.sign(beside[index]))

    @cached_property
    def _bottoms(self) -> tuple[Array, Array]:
        """Lower bounds of moduli between places, and where, in places; each of shape (t, f).

        They are of the bottoms of parabolas through three values; infinite where there is none.
        """
        inner, crosses = self._inner, self._crosses[..., None, :]
        first, last = np.abs(self.ends[..., :1, :]), np.abs(self.ends[..., 1:, :])
        values = np.concatenate([first, inner, np.where(crosses, -last, last)], axis=-2)
        sides = np.where(crosses, np.sign(inner), 1.0)
        parts = values[..., :-2, :], inner, values[..., 2:, :]
        before, here, after = (sides * part for part in parts)
        bend, slope = before - 2 * here + after, 0.5 * (after - before)
        found = (np.abs(slope) <= bend) & (bend > 0)
        found &= ~crosses | (np.minimum(before, after) >= 0)
        if not found.any():
            return np.full_like(inner, np.inf), slope
        away = np.divide(-slope, bend, out=np.zeros_like(bend), where=found)
        none = np.zeros_like(first)
        errors = np.concatenate([none, self.errors, none], axis=-2)
        beside = np.where(away > 0, errors[..., 2:, :], errors[..., :-2, :])
        error = self.errors + np.abs(away) * (beside - self.errors)
        bound = np.maximum(error, ZERO.bottom * np.minimum(first, last))
        return np.where(found, here + 0.5 * away * slope - bound, np.inf), away

    @cached_property
    def _crosses(self) -> Mask:
        """Whether each does not have one sign at both ends, shape (f,)."""
        return np.asarray(~(self.ends[..., 0, :] * self.ends[..., 1, :] > 0))

    @cached_property
    def _inner(self) -> Array:
        """The functions on the grid, positive where they have the sign of the first end."""
        first, last = self.ends[..., 0, :], self.ends[..., 1, :]
        signs = np.where(first != 0, np.sign(first), -np.sign(last))
        return np.asarray(signs[..., None, :] * self.inside)

    @cached_property
    def _above_zero(self) -> Array:
        """Lower bounds of these, shape (t, f)."""
        minimum = np.abs(self.ends).min(axis=-2)[..., None, :]
        return self._inner - np.maximum(self.errors, ZERO.dip * minimum)

    @cached_property
    def _changes(self) -> Mask:
        """Where these change their sign, if they do so from one end to the other; (t + 1, f)."""
        inner = self._inner
        signs = np.ones((*inner.shape[:-2], inner.shape[-2] + 2, inner.shape[-1]))
        np.sign(inner, out=signs[..., 1:-1, :])
        signs[..., -1, :] = -1.0
        return np.asarray(signs[..., 1:, :] != signs[..., :-1, :])


def contracts_between(a: Point, b: Point) -> bool:
    """Whether perturbations decay on all orbits between two points, so that none bifurcates.

    They decay at both, and the bound of the multipliers changes by less from one to the other than
    its distance below zero.
    """
    growth = max(a.growth, b.growth)
    if not -np.inf < min(a.growth, b.growth) <= growth < 0:
        return False
    same = all((a.tests[name] > 0) == (b.tests[name] > 0) for name in a.tests)
    return (
        same
        and a.orientation == b.orientation
        and abs(a.growth - b.growth) <= ZERO.change * -growth
    )


def contraction_drift(recent: Sequence[Point], point: Point) -> float:
    """Return the extrapolation error of the bound of the multipliers, relative to its tolerance.

    Multipliers rotate with the forcing frequency, and test functions with them, also where nothing
    can bifurcate. The bound, which excludes bifurcations, does not rotate. Infinite where it
    excludes none.
    """
    if not contracts_between(recent[-1], point):
        return np.inf
    if not all(np.isfinite(item.growth) for item in recent):
        return 0.0
    weights = lagrange([item.arclength for item in recent], point.arclength)
    expected = float(weights @ [item.growth for item in recent])
    allowed = ZERO.change * min(-recent[-1].growth, -point.growth)
    change = max(abs(point.growth - expected), abs(point.growth - recent[-1].growth))
    return float(change / allowed)
