"""Where on a curve a function of its points is zero."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Generic

import numpy as np

from slipfold.continuation.curve import Curve
from slipfold.continuation.interpolation import (
    POINTS,
    arc_between,
    derivatives,
    hermite,
    well_spaced,
)
from slipfold.continuation.newton import correct
from slipfold.continuation.point import P
from slipfold.errors import breakdown

__all__ = [
    "ALONG",
    "LostCurveError",
    "insert",
    "inverse_interpolation",
    "locate",
    "lost_reason",
    "point_at",
]

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

    Inverse interpolation through the values found so far, kept inside the bracket by bisection.
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
    tried = [(0.0, values[0]), (chord.length, values[1])]
    low, high = 0.0, chord.length
    for count in range(EVALUATIONS):
        at = inverse_interpolation(tried, low, high)
        if not low < at < high or (count > PATIENCE and count % 2):
            at = 0.5 * (low + high)
        try:
            point = chord.point_at(at)
        except LostCurveError:  # Newton's method is singular exactly at a branch point
            at += ASIDE * close
            point = chord.point_at(at)
        value = function(point)
        if value == 0.0 or _error(tried, at, value) <= close or high - low <= close:
            return point
        insert(known, point)
        tried.append((at, value))
        if (value > 0) == (values[0] > 0):
            low = at
        else:
            high = at
    if high - low > BLURRED:
        raise LostCurveError(f"a zero was not found in {EVALUATIONS} points")
    return point


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


def _error(tried: list[tuple[float, float]], at: float, value: float) -> float:
    """Distance to the zero by the secant through the nearest place tried."""
    nearest, other = min(tried, key=lambda item: abs(item[0] - at))
    return abs(value * (at - nearest) / (value - other)) if value != other else np.inf


def inverse_interpolation(tried: list[tuple[float, float]], low: float, high: float) -> float:
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
