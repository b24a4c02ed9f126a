"""All zeros of test functions between two neighbouring points of a curve, none missed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.curve import Curve
from slipfold.continuation.interpolation import lagrange, polynomial_weights, well_spaced
from slipfold.continuation.locate import insert, locate, point_at
from slipfold.continuation.point import P

__all__ = ["Found", "Watch", "locate_test", "search_between"]

Array = NDArray[np.float64]

DEPTH = 7
"""An interval is halved this often, to 1/128 of a step, before its account is left open."""

KNOTS = 4
"""Points that test functions are interpolated through."""

UNSURE = 0.25
"""Share of the difference between a test function and what its neighbours let expect, below which
it may have changed its sign twice: a parabola with that error in its slope falls by so much."""

TOUCH = 0.15
"""A test function that falls between two points to this share of its values there is looked at."""


@dataclass(frozen=True, eq=False)
class Found(Generic[P]):
    """A special point that was located."""

    type: str  # what it is called, e.g. ``"PD"``
    point: P  # where it is
    slope: float  # derivative of the test function along the curve
    # Unit tangent of the other curve at a branch point; None elsewhere, and where none crosses
    other: Array | None = None


class Watch(ABC, Generic[P]):
    """Functions along a curve whose zeros are looked for."""

    def values(self, point: P) -> Array:
        """Return the functions at a point."""
        return point.values

    def foreseen(self, points: Sequence[P], weights: Array) -> Array | None:
        """Return the functions elsewhere as more than their values at points lets expect them.

        None where those are all that is known. Shapes: weights (t, points); returns (t, functions).
        """
        return None

    def excludes(self, a: P, b: P) -> bool:
        """Whether nothing can be found between two points, whatever the functions do."""
        return False

    @abstractmethod
    def located(self, known: list[P], a: P, b: P) -> list[Found[P]]:
        """Return the genuine zeros where a function changes its sign between two points."""

    def accounts_for(self, found: list[Found[P]], a: P, b: P) -> bool:
        """Whether what was found explains how two points differ."""
        return True

    def hidden(self, found: list[Found[P]], known: list[P], a: P, b: P) -> list[Found[P]]:
        """Return special points at which no function changes its sign."""
        return []


def search_between(
    curve: Curve[P], watch: Watch[P], known: list[P], a: P, b: P, depth: int = 0
) -> list[Found[P]]:
    """Find the special points between two points.

    A sign change brackets a zero. Two zeros between the points leave no sign change: so the test
    functions are interpolated, and where one may come near zero the point there is computed and
    both halves are searched. At the end what was found must explain how the two points differ, else
    the interval is halved as well.
    """
    place = _suspicious_place(watch, known, a, b) if depth < DEPTH else None
    if place is not None and watch.excludes(a, b):
        return []
    if place is None:
        found = watch.located(known, a, b)
        explained = watch.accounts_for(found, a, b)
        if depth >= DEPTH and not explained:
            found += watch.hidden(found, known, a, b)
        if depth >= DEPTH or explained:
            return sorted(found, key=lambda item: item.point.arclength)
        place = 0.5 * (a.arclength + b.arclength)
    middle = point_at(curve, known, place)
    insert(known, middle)
    left = search_between(curve, watch, known, a, middle, depth + 1)
    return left + search_between(curve, watch, known, middle, b, depth + 1)


def locate_test(curve: Curve[P], known: list[P], a: P, b: P, kind: str, test: str) -> Found[P]:
    """Locate the zero of a test function between two points."""
    point = locate(curve, known, a, b, lambda item: item.tests[test])
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


def _suspicious_place(watch: Watch[P], known: Sequence[P], a: P, b: P) -> float | None:
    """Where between two points a test function may touch zero without a sign change at the ends.

    Each is interpolated in that way of two which a point less changes less: by its values, or by
    what it follows from.
    """
    near = well_spaced(known, a.arclength, b.arclength, KNOTS)
    grid = np.linspace(a.arclength, b.arclength, 18)[1:-1]
    ends = np.array([watch.values(a), watch.values(b)])
    weights = _weights(near, grid, (a, b))
    values = weights @ np.array([watch.values(point) for point in near])
    place = _Expected.of(values, grid, ends).doubtful_place()
    foreseen = None if place is None else watch.foreseen(near, weights)
    if foreseen is None:
        return place
    return _Expected.of(values, grid, ends, foreseen).doubtful_place()


def _weights(near: Sequence[P], grid: Array, ends: tuple[P, P]) -> Array:
    """Weights of points in what they let expect at other places: a row for each, shape (t, points).

    First on the grid, then there without the point farthest away, then at both ends without these.
    """
    where = np.array([point.arclength for point in near])
    size = len(grid)
    weights = np.zeros((2 * size + 2, len(near)))
    weights[:size] = polynomial_weights(where, grid)
    weights[size:-2, :-1] = polynomial_weights(where[:-1], grid)
    for row, end in zip(weights[-2:], ends, strict=True):
        others = [i for i, point in enumerate(near) if point is not end]
        row[others] = lagrange(where[others].tolist(), end.arclength)
    return weights


@dataclass(frozen=True, eq=False)
class _Expected:
    """Test functions as they are expected between two points."""

    grid: Array  # places between them, shape (t,)
    inside: Array  # the functions there, shape (t, f)
    errors: Array  # by how much these change if the point farthest away is left out, shape (t, f)
    ends: Array  # the functions at the points, shape (2, f)
    surprises: Array  # by how much these differ from what the others let expect, shape (2, f)

    @staticmethod
    def of(values: Array, grid: Array, ends: Array, foreseen: Array | None = None) -> _Expected:
        """Expect the functions from their values, or as they are foreseen where that is better.

        Shapes: values, foreseen as the rows of `_weights`, (2 t + 2, f).
        """
        size = len(grid)
        if foreseen is not None:
            one, other = (np.abs(each[:size] - each[size:-2]) for each in (values, foreseen))
            values = np.where(other.max(axis=0) < one.max(axis=0), foreseen, values)
        inside = values[:size]
        errors = np.abs(inside - values[size:-2])
        return _Expected(grid, inside, errors, ends, np.abs(ends - values[-2:]))

    def doubtful_place(self) -> float | None:
        """Return where a function may touch zero, or pass it more often than its ends tell.

        Between the points it may be as far from its interpolation as that is from the one through a
        point less. At a point where it is far from what its neighbours let expect and near zero,
        its slope is not known, and it may have come from the other side.
        """
        grid = self.grid
        columns = zip(self.inside.T, self.errors.T, self.ends.T, self.surprises.T, strict=True)
        for curve, error, (f_a, f_b), (e_a, e_b) in columns:
            # A function that is not defined everywhere, or is zero everywhere.
            if not np.isfinite(curve).all() or f_a == f_b == 0:
                continue
            inner = (np.sign(f_a) or -np.sign(f_b)) * curve
            if f_a * f_b > 0:
                doubtful = inner - np.maximum(error, TOUCH * min(abs(f_a), abs(f_b)))
                lowest = int(doubtful.argmin())
                if doubtful[lowest] < 0:
                    return float(grid[lowest])
                if abs(f_a) < UNSURE * e_a or abs(f_b) < UNSURE * e_b:
                    return float(0.5 * (grid[0] + grid[-1]))
            else:
                signs = np.sign(np.concatenate([[1.0], inner, [-1.0]]))
                changes = np.flatnonzero(np.diff(signs))
                if len(changes) > 1:
                    return float(grid[min(changes[1], len(grid) - 1)])
        return None
