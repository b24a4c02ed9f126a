"""Where on a curve of orbits a function is zero."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from slipfold.branches.interpolation import POINTS, arc_between, hermite, well_spaced
from slipfold.branches.point import Point, corrected_point
from slipfold.orbits.newton import correct
from slipfold.orbits.shooting import Shooting

__all__ = ["LostBranchError", "insert", "locate", "orbit_at"]

STILL = 1e-9
"""Located orbits: derivatives taken within this distance, ten times closer than on the way."""

CLOSE = 1e-12
"""Arclength to which a zero is found; the parameter then is right to 1e-12 of the span."""

EVALUATIONS = 40


PATIENCE = 8
"""Evaluations after which every other one bisects, whatever the interpolation says."""


class LostBranchError(ArithmeticError):
    """Newton's method failed between two points of a branch."""


def orbit_at(curve: Shooting, known: Sequence[Point], arclength: float) -> Point:
    """Return the orbit at a place between known points of a branch.

    Parameters
    ----------
    curve
        The equations.
    known
        Points of the branch in order.
    arclength
        The place.

    Raises
    ------
    LostBranchError
        If Newton's method fails there.
    """
    guess, row = hermite(well_spaced(known, arclength, arclength, POINTS), arclength)
    correction = correct(curve, guess, row, still=STILL)
    if not correction.converged:
        raise LostBranchError(correction.failure)
    return _placed(known, corrected_point(curve, correction, arclength))


def _placed(known: Sequence[Point], point: Point) -> Point:
    """Give a point its true place: where the guess was poor the correction moved it along."""
    after = bisect([item.arclength for item in known], point.arclength)
    if not 0 < after < len(known):
        return point
    a, b = known[after - 1], known[after]
    left, right = arc_between(a, point), arc_between(point, b)
    share = left / (left + right) if left + right > 0 else 0.5
    return replace(point, arclength=a.arclength + share * (b.arclength - a.arclength))


def insert(known: list[Point], point: Point) -> None:
    """Add a point to a list that is ordered by arclength.

    Parameters
    ----------
    known
        Points of the branch in order.
    point
        The new one.
    """
    known.insert(bisect([item.arclength for item in known], point.arclength), point)


def locate(
    curve: Shooting,
    known: list[Point],
    a: Point,
    b: Point,
    function: Callable[[Point], float],
    close: float = CLOSE,
) -> Point:
    """Find the zero of a function that has different signs at two points.

    Inverse interpolation through the values found so far, kept inside the bracket by bisection.
    Every orbit computed on the way is added to `known`, so that each guess is better than the
    last.

    Parameters
    ----------
    curve
        The equations.
    known
        Points of the branch in order; grows.
    a, b
        Neighbouring points between which the sign changes.
    function
        Smooth function of a point.
    close
        Arclength to which the zero is found.

    Returns
    -------
    Point
        The point where the function is zero.
    """
    tried = [(a.arclength, function(a)), (b.arclength, function(b))]
    (low, f_low), (high, _) = tried
    for count in range(EVALUATIONS):
        at = _inverse_interpolation(tried, low, high)
        if not low < at < high or (count > PATIENCE and count % 2):
            at = 0.5 * (low + high)
        point = orbit_at(curve, known, at)
        at, value = point.arclength, function(point)
        if value == 0.0 or _error(tried, at, value) <= close or high - low <= close:
            return point
        insert(known, point)
        tried.append((at, value))
        if (value > 0) == (f_low > 0):
            low = at
        else:
            high = at
    return point


def _error(tried: list[tuple[float, float]], at: float, value: float) -> float:
    """Distance to the zero by the secant through the nearest place tried."""
    nearest, other = min(tried, key=lambda item: abs(item[0] - at))
    return abs(value * (at - nearest) / (value - other)) if value != other else np.inf


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
