"""Where on a branch a function of the orbit is zero."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from slipfold.branches.interpolation import POINTS, arc_between, hermite, well_spaced
from slipfold.branches.point import Point, corrected_point
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.newton import correct

__all__ = ["LostBranchError", "insert", "locate", "orbit_at"]

STILL = 1e-9
"""Located orbits: derivatives taken within this distance, ten times closer than on the way."""

CLOSE = 1e-11
"""Arclength to which a zero is found; the parameter then is right to 1e-11 of the span."""

EVALUATIONS = 40


PATIENCE = 8
"""Evaluations after which every other one bisects, whatever the interpolation says."""


class LostBranchError(ArithmeticError):
    """Newton's method failed between two points of a branch."""


def orbit_at(problem: PeriodicProblem, known: Sequence[Point], arclength: float) -> Point:
    """Return the orbit at a place between known points of a branch.

    Parameters
    ----------
    problem
        The boundary-value problem.
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
    correction = correct(problem, guess, row, still=STILL)
    if not correction.converged:
        raise LostBranchError(correction.failure)
    return _placed(known, corrected_point(correction, arclength))


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
    problem: PeriodicProblem,
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
    problem
        The boundary-value problem.
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
    low, high = a.arclength, b.arclength
    f_low, f_high = function(a), function(b)
    tried = [(low, f_low, a), (high, f_high, b)]
    previous = np.inf
    for count in range(EVALUATIONS):
        at = _inverse_interpolation(tried)
        if not low < at < high:
            at = low - f_low * (high - low) / (f_high - f_low)
        if count > PATIENCE and count % 2:
            at = 0.5 * (low + high)
        point = orbit_at(problem, known, at)
        at, value = point.arclength, function(point)
        found = abs(at - previous) <= close or high - low <= close
        previous = at
        if found or value == 0.0:
            return point
        insert(known, point)
        tried.append((at, value, point))
        if (value > 0) == (f_low > 0):
            low, f_low = at, value
        else:
            high, f_high = at, value
    return point


def _inverse_interpolation(tried: list[tuple[float, float, Point]]) -> float:
    """Arclength where the value is zero: Neville's scheme through the smallest values."""
    best = sorted(tried, key=lambda item: abs(item[1]))[:4]
    f = np.array([item[1] for item in best])
    s = np.array([item[0] for item in best])
    if len(set(f)) < len(f):
        return np.nan
    for order in range(1, len(f)):
        s = (f[order:] * s[:-1] - f[:-order] * s[1:]) / (f[order:] - f[:-order])
    return float(s[0])
