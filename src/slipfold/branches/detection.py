"""All bifurcations between two neighbouring points of a branch, none missed, none invented."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.interpolation import polynomial, well_spaced
from slipfold.branches.location import insert, locate, orbit_at
from slipfold.branches.point import Point
from slipfold.orbits.boundary_value_problem import PeriodicProblem

__all__ = ["Found", "find_bifurcations"]

Array = NDArray[np.float64]

DEPTH = 7
"""An interval is halved this often, to 1/128 of a step, before its account is left open."""

TOUCH = 0.15
"""A test function that falls between two points to this share of its values there is looked at."""

ON_CIRCLE = 1e-4
"""Distance of a critical multiplier from where it should be; located ones have 1e-8 or less."""

REAL = 1e-7
"""A multiplier whose imaginary part is below this counts as real: pairs part as a square root."""


@dataclass(frozen=True, eq=False)
class Found:
    """A bifurcation that was located.

    Parameters
    ----------
    type
        ``"PD"``, ``"NS"``, ``"LP"`` or ``"BP"``.
    point
        The orbit.
    slope
        Derivative of the test function along the branch.
    """

    type: str
    point: Point
    slope: float


def find_bifurcations(
    problem: PeriodicProblem, known: list[Point], a: Point, b: Point, depth: int = 0
) -> list[Found]:
    """Find the bifurcations between two points.

    A sign change brackets a zero. Two zeros between the points leave no sign change: so the test
    functions are interpolated, and where one may come near zero the orbit there is computed and
    both halves are searched. At the end the change in the number of unstable multipliers must be
    accounted for by what was found, else the interval is halved as well.

    Parameters
    ----------
    problem
        The boundary-value problem.
    known
        Points of the branch in order, with `a` and `b`; grows.
    a, b
        Neighbouring points.
    depth
        Number of halvings so far.

    Returns
    -------
    list of Found
        In order of arclength.
    """
    place = _suspicious_place(known, a, b) if depth < DEPTH else None
    if place is None:
        found = _located(problem, known, a, b)
        if depth >= DEPTH or _accounts_for(found, a, b):
            return found
        place = 0.5 * (a.arclength + b.arclength)
    middle = orbit_at(problem, known, place)
    insert(known, middle)
    left = find_bifurcations(problem, known, a, middle, depth + 1)
    return left + find_bifurcations(problem, known, middle, b, depth + 1)


def _located(problem: PeriodicProblem, known: list[Point], a: Point, b: Point) -> list[Found]:
    found = []
    for kind in ("PD", "NS", "LP"):
        if (a.tests[kind] > 0) != (b.tests[kind] > 0):
            found.append(_locate_one(problem, known, a, b, kind, kind))
    if a.orientation != b.orientation:
        found.append(_locate_one(problem, known, a, b, "BP", "fold"))
    real = [item for item in found if _is_genuine(item)]
    return sorted(real, key=lambda item: item.point.arclength)


def _locate_one(
    problem: PeriodicProblem, known: list[Point], a: Point, b: Point, kind: str, test: str
) -> Found:
    point = locate(problem, known, a, b, lambda item: item.tests[test])
    nearest = min(
        (item for item in known if item.arclength != point.arclength),
        key=lambda item: abs(item.arclength - point.arclength),
    )
    # The nearest evaluations may coincide to rounding; the bracket gives the slope then.
    gap = nearest.arclength - point.arclength
    if abs(gap) < 1e-7:
        slope = (b.tests[test] - a.tests[test]) / (b.arclength - a.arclength)
    else:
        slope = (nearest.tests[test] - point.tests[test]) / gap
    return Found(kind, point, slope)


def _is_genuine(found: Found) -> bool:
    """Whether a multiplier is where the type says.

    A neutral saddle has real multipliers whose product is one. Beside a multiplier of 1e7, rounding
    may change the sign of a test function where nothing is on the unit circle.
    """
    values = found.point.multipliers
    if found.type == "NS":
        return _is_torus(values)
    target = -1.0 if found.type == "PD" else 1.0
    return bool(np.abs(values - target).min() < ON_CIRCLE)


def _is_torus(values: NDArray[np.complex128]) -> bool:
    """Whether the product of one is that of a complex pair on the unit circle."""
    first, second = np.triu_indices(len(values), k=1)
    closest = np.abs(1 - values[first] * values[second]).argmin()
    pair = values[first[closest]]
    return bool(abs(pair.imag) > REAL and abs(abs(pair) - 1) < ON_CIRCLE)


def _accounts_for(found: list[Found], a: Point, b: Point) -> bool:
    """Whether what was found explains the change in the number of unstable multipliers."""
    change = abs(b.unstable - a.unstable)
    single = sum(item.type != "NS" for item in found)
    pairs = len(found) - single
    return change <= single + 2 * pairs and (change - single) % 2 == 0


def _suspicious_place(known: list[Point], a: Point, b: Point) -> float | None:
    """Where between two points a test function may touch zero without a sign change at the ends."""
    near = well_spaced(known, a.arclength, b.arclength, 4)
    where = np.array([point.arclength for point in near])
    grid = np.linspace(a.arclength, b.arclength, 18)[1:-1]
    curves = polynomial(where, np.array([list(point.tests.values()) for point in near]), grid)
    for curve, f_a, f_b in zip(curves.T, a.tests.values(), b.tests.values(), strict=True):
        inner = np.sign(f_a) * curve
        lowest = int(inner.argmin())
        if f_a * f_b > 0:
            if inner[lowest] < TOUCH * min(abs(f_a), abs(f_b)):
                return float(grid[lowest])
        else:
            signs = np.sign(np.concatenate([[1.0], inner, [-1.0]]))
            changes = np.flatnonzero(np.diff(signs))
            if len(changes) > 1:
                return float(grid[min(changes[1], len(grid) - 1)])
    return None
