"""Where on a curve a function of its points is zero."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Generic

import numpy as np

from slipfold.continuation.curve import Curve, P
from slipfold.continuation.interpolation import (
    POINTS,
    SPACING,
    arc_between,
    derivatives,
    hermite,
    well_spaced,
)
from slipfold.continuation.newton import correct
from slipfold.errors import breakdown

CLOSE = 1e-12
"""Arclength to which a zero is found; the parameter then is right to 1e-12 of the span."""

EVALUATIONS = 40
"""Points after which a zero counts as not found; 8 are seldom needed."""

ASIDE = 0.5
"""Where a point cannot be found exactly at a zero, one this much of `close` beside it is taken."""

BLURRED = 1e-6
"""Arclength within which rounding, magnified by large multipliers, may hide a zero. The point's
uncertainty, computed apart, says how much it does."""

ALONG = 0.3
"""A curve whose tangent makes a smaller cosine than this with a chord is halved first."""


PATIENCE = 8
"""Evaluations after which every other one bisects, whatever the interpolation says."""

BESIDE = 2
"""Points beside a bracket that are interpolated as well: they save one of four evaluations."""

KNOTS = 6
"""Values that a polynomial goes through."""

CORRECTIONS = 5
"""Newton steps to its zero, from the value nearest to zero."""


class LostCurveError(ArithmeticError):
    """Newton's method failed between two points of a curve."""


def lost_reason(error: Exception) -> str:
    """Say why what lies between two points was not found."""
    return str(error) if isinstance(error, LostCurveError) else breakdown(error)


def point_at(curve: Curve[P], known: Sequence[P], arclength: float) -> P:
    """Return the point at a place between known points of a curve."""
    near = well_spaced(known, arclength, arclength, POINTS)
    guess, row = hermite(near, arclength)
    expected = derivatives(curve, near, arclength)
    correction = correct(curve, curve.aligned(guess, near[0].z), row, expected=expected)
    if not correction.converged:
        raise LostCurveError(correction.failure)
    return _placed(known, curve.point(correction, arclength))


def _placed(known: Sequence[P], point: P) -> P:
    """Give a point its true place: where the guess was poor the correction moved it along."""
    after = bisect([item.arclength for item in known], point.arclength)
    if not 0 < after < len(known):
        return point
    return _between(known[after - 1], point, known[after])


def _between(a: P, point: P, b: P) -> P:
    """Give a point its place between two others, by its distances from them."""
    left, right = arc_between(a, point), arc_between(point, b)
    share = left / (left + right) if left + right > 0 else 0.5
    return replace(point, arclength=a.arclength + share * (b.arclength - a.arclength))


def insert(known: list[P], point: P) -> None:
    """Add a point to a list that is ordered by arclength."""
    known.insert(bisect([item.arclength for item in known], point.arclength), point)


def locate(
    curve: Curve[P],
    known: list[P],
    a: P,
    b: P,
    function: Callable[[P], float],
    close: float = CLOSE,
) -> P:
    """Find the zero of a function that has different signs at two points.

    It is that of the polynomial through the values known so far, also of points beside the two;
    where that has none in the bracket, inverse interpolation and bisection lead on.
    Every point computed on the way is added to `known`, so that each guess is better than the
    last.
    """
    values = function(a), function(b)
    while not (chord := _Chord(curve, a, b)).is_crossed_once:
        middle = point_at(curve, known, 0.5 * (a.arclength + b.arclength))
        if not a.arclength < middle.arclength < b.arclength:
            raise LostCurveError("the curve turns too sharply between two points")
        insert(known, middle)
        value = function(middle)
        if (value > 0) == (values[0] > 0):
            a, values = middle, (value, values[1])
        else:
            b, values = middle, (values[0], value)
    beside = [(place, function(point)) for place, point in chord.use_beside(known)]
    zero = Enclosed(chord.length, values, beside)
    for _ in range(EVALUATIONS):
        at = zero.next_place()
        try:
            point = chord.point_at(at)
        except LostCurveError:  # Newton's method is singular exactly at a branch point
            at += ASIDE * close
            point = chord.point_at(at)
        value = function(point)
        if value == 0.0 or zero.error(at, value) <= close or zero.width <= close:
            return point
        insert(known, point)
        zero.add(at, value)
    if zero.width > BLURRED:
        raise LostCurveError(f"a zero was not found in {EVALUATIONS} points")
    return point


class Enclosed:
    """A zero of a function that has different signs at zero and at some length.

    Places and values beside the two may be known as well.
    """

    def __init__(
        self,
        length: float,
        values: tuple[float, float],
        beside: Sequence[tuple[float, float]] = (),
    ) -> None:
        self._tried = [(0.0, values[0]), (length, values[1])]
        self._beside = beside
        self._low, self._high, self._positive = 0.0, length, values[0] > 0

    @property
    def width(self) -> float:
        """Length within which it is known to lie."""
        return self._high - self._low

    def next_place(self) -> float:
        """Return where to look next, inside of what encloses it."""
        least = min(self._tried, key=lambda item: abs(item[1]))[0]
        at, count = _polynomial_zero([*self._tried, *self._beside], least), len(self._tried) - 2
        if not self._low < at < self._high:
            at = _inverse_interpolation(self._tried, self._low, self._high)
        if not self._low < at < self._high or (count > PATIENCE and count % 2):
            return 0.5 * (self._low + self._high)
        return at

    def error(self, at: float, value: float) -> float:
        """Return the distance of a place to the zero by the secant through the nearest one."""
        nearest, other = self._nearest(at)
        return abs(value * (at - nearest) / (value - other)) if value != other else np.inf

    def slope(self, at: float, value: float) -> float:
        """Return the slope of that secant."""
        nearest, other = self._nearest(at)
        return (value - other) / (at - nearest)

    def add(self, at: float, value: float) -> None:
        """Note a value of the function."""
        self._tried.append((at, value))
        if (value > 0) == self._positive:
            self._low = at
        else:
            self._high = at

    def _nearest(self, at: float) -> tuple[float, float]:
        return min(self._tried, key=lambda item: abs(item[0] - at))


class _Chord(Generic[P]):
    """The part of a curve between two points, over its place along the chord.

    The place of a point is that of its projection. Unlike the arclength, which is summed from one
    guess to the next, it belongs to the solution alone, so that an interpolated zero stays where
    it is as more points become known.
    """

    def __init__(self, curve: Curve[P], a: P, b: P) -> None:
        self._curve = curve
        self._a, self._b = a, b
        difference = b.z - a.z
        self.length = float(np.linalg.norm(difference)) or 1.0
        self._row = difference / self.length
        self._known: list[P] = []
        if self.is_crossed_once:
            self._known = [self._projected(a, 0.0), self._projected(b, self.length)]

    @property
    def is_crossed_once(self) -> bool:
        """Whether the curve runs along the chord at both ends, not back or across."""
        return all(float(item.tangent @ self._row) > ALONG for item in (self._a, self._b))

    def use_beside(self, known: Sequence[P]) -> list[tuple[float, P]]:
        """Let guesses go through points beside the chord; return the nearest with their places."""
        apart, found = SPACING * self.length, list[tuple[float, P]]()
        for point in known:
            if (point.curve, point.piece) != (self._a.curve, self._a.piece):
                continue
            place = float((point.z - self._a.z) @ self._row)
            beside = not -apart <= place <= self.length + apart
            alone = all(abs(place - other) > apart for other, _ in found)
            if beside and alone and float(point.tangent @ self._row) > ALONG:
                found.append((place, point))
        found = sorted(found, key=lambda item: abs(item[0] - 0.5 * self.length))[:BESIDE]
        self._known += [self._projected(point, place) for place, point in found]
        return found

    def point_at(self, place: float) -> P:
        """Return the point at a place along the chord."""
        near = well_spaced(self._known, place, place, POINTS)
        guess, _ = hermite(near, place)
        guess = guess + (place - float((guess - self._a.z) @ self._row)) * self._row
        expected = derivatives(self._curve, near, place)
        correction = correct(self._curve, guess, self._row, expected=expected)
        if not correction.converged:
            raise LostCurveError(correction.failure)
        point = self._curve.point(correction, place)
        if float(point.tangent @ self._row) <= 0:
            raise LostCurveError("the curve turns too sharply between two points")
        self._known.append(self._projected(point, place))
        return _between(self._a, point, self._b)

    def _projected(self, point: P, place: float) -> P:
        """Return a point with its place along the chord and the derivative with respect to it."""
        return replace(point, arclength=place, tangent=point.tangent / (point.tangent @ self._row))


def _polynomial_zero(known: Sequence[tuple[float, float]], start: float) -> float:
    """Place of the zero near a start of the polynomial through places and their values; or NaN.

    In Newton's form and plain floats: there are few of them.
    """
    nearest = sorted(known, key=lambda item: abs(item[0] - start))[:KNOTS]
    where, factors = [item[0] for item in nearest], [item[1] for item in nearest]
    if len(set(where)) < len(where):
        return np.nan
    for order in range(1, len(where)):
        for i in range(len(where) - 1, order - 1, -1):
            factors[i] = (factors[i] - factors[i - 1]) / (where[i] - where[i - order])
    at = start
    for _ in range(CORRECTIONS):
        value, slope = 0.0, 0.0
        for x, factor in zip(reversed(where), reversed(factors), strict=True):
            slope = slope * (at - x) + value
            value = value * (at - x) + factor
        if slope == 0.0:
            return np.nan
        at -= value / slope
    return at


def _inverse_interpolation(tried: list[tuple[float, float]], low: float, high: float) -> float:
    """Place of the zero by Neville's scheme through both ends of the bracket and the last two."""
    ends = [item for item in tried if item[0] in (low, high)]
    others = [item for item in tried if item[0] not in (low, high)]
    chosen = np.array(ends + others[-2:])
    s, f = chosen[:, 0], chosen[:, 1]
    if len(set(f)) < len(f):
        return np.nan
    for order in range(1, len(f)):
        s = (f[order:] * s[:-1] - f[:-order] * s[1:]) / (f[order:] - f[:-order])
    return float(s[0])
