"""The bifurcations of a branch: which zeros of test functions are bifurcations, and which."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.point import Point
from slipfold.branches.search import Found, locate_test, search_between
from slipfold.orbits.boundary_value_problem import PeriodicProblem

__all__ = ["ON_CIRCLE", "find_bifurcations", "is_torus"]

ON_CIRCLE = 1e-4
"""Distance of a critical multiplier from where it should be; located ones have 1e-8 or less."""

ROUNDING = 1e-9
"""What rounding may leave of a test function, or of a multiplier's distance from the circle."""

REAL = 1e-7
"""A multiplier whose imaginary part is below this counts as real: pairs part as a square root."""


def find_bifurcations(
    problem: PeriodicProblem, known: list[Point], a: Point, b: Point
) -> list[Found]:
    """Find the bifurcations between two points of a branch, none missed, none invented.

    Parameters
    ----------
    problem
        The boundary-value problem.
    known
        Points of the branch in order, with `a` and `b`; grows.
    a, b
        Neighbouring points.

    Returns
    -------
    list of Found
        In order of arclength.
    """
    return search_between(problem, _Bifurcations(problem), known, a, b)


class _Bifurcations:
    """What is looked for along a branch."""

    def __init__(self, problem: PeriodicProblem) -> None:
        self._problem = problem

    def located(self, known: list[Point], a: Point, b: Point) -> list[Found]:
        """Return the bifurcations where a test function changes sign between two points."""
        found = []
        for kind in ("PD", "NS", "LP"):
            if kind in a.tests and _changes_sign(a.tests[kind], b.tests[kind]):
                found.append(locate_test(self._problem, known, a, b, kind, kind))
        if a.orientation != b.orientation:
            found.append(locate_test(self._problem, known, a, b, "BP", "fold"))
        return [item for item in found if _is_genuine(item)]

    def accounts_for(self, found: list[Found], a: Point, b: Point) -> bool:
        """Whether what was found explains the change in the number of unstable multipliers."""
        if min(np.abs(np.abs(item.multipliers) - 1).min() for item in (a, b)) < ROUNDING:
            return True  # which side of the circle it is on is not known
        change = abs(b.unstable - a.unstable)
        single = sum(item.type != "NS" for item in found)
        pairs = len(found) - single
        return change <= single + 2 * pairs and (change - single) % 2 == 0


def _changes_sign(before: float, after: float) -> bool:
    """Whether a function is positive at one of two points only, beyond what rounding does.

    Along a family of centres, which have the same value of the parameter, it is zero throughout.
    """
    return (before > 0) != (after > 0) and max(abs(before), abs(after)) > ROUNDING


def _is_genuine(found: Found) -> bool:
    """Whether a multiplier is where the type says.

    A neutral saddle has real multipliers whose product is one. Beside a multiplier of 1e7, rounding
    may change the sign of a test function where nothing is on the unit circle.
    """
    values = found.point.multipliers
    if found.type == "NS":
        return is_torus(values)
    target = -1.0 if found.type == "PD" else 1.0
    return bool(np.abs(values - target).min() < ON_CIRCLE)


def is_torus(values: NDArray[np.complex128]) -> bool:
    """Whether the product nearest to one is that of a complex pair on the unit circle.

    Parameters
    ----------
    values
        Multipliers, shape (n,).
    """
    first, second = np.triu_indices(len(values), k=1)
    closest = np.abs(1 - values[first] * values[second]).argmin()
    pair = values[first[closest]]
    return bool(abs(pair.imag) > REAL and abs(abs(pair) - 1) < ON_CIRCLE)
