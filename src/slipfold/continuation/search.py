"""All zeros of test functions between two neighboring points of a curve, none missed."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Generic

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.curve import Curve, P
from slipfold.continuation.interpolation import well_spaced
from slipfold.continuation.locate import insert, locate, point_at
from slipfold.continuation.traced_curve import Found, MonitorResult, StepInterval
from slipfold.continuation.unseen import Expected, expectation_weights, places_between

DEPTH = 7
"""Maximum number of halvings of an interval, to 1/128 of a step."""

KNOTS = 4
"""Points that test functions are interpolated through."""


class Zeros(Generic[P]):
    """A monitor of functions that change their sign: all their zeros are located, none missed.

    Here of all test functions of the points, recorded by their names.
    """

    def __init__(self, curve: Curve[P]) -> None:
        self.curve = curve

    def values(self, point: P) -> Array:
        """Return the functions at a point."""
        return point.values

    def foreseen(self, points: Sequence[P], weights: Array) -> Array | None:
        """Return predictions of the functions that use more than their values at points.

        None where those are all that is known. Shapes: weights (t, points); returns (t, functions).
        """
        return self.curve.foreseen(points, weights)

    def watch(self, interval: StepInterval[P]) -> MonitorResult[P]:
        """Locate all zeros between two neighboring points."""
        found = self.search(interval.known, interval.before, interval.point)
        return self.seen(found, interval)

    def seen(self, found: Sequence[Found[P]], interval: StepInterval[P]) -> MonitorResult[P]:
        """Return what the zeros mean: here they are recorded."""
        return MonitorResult(found)

    def search(self, known: list[P], a: P, b: P, depth: int = 0) -> list[Found[P]]:
        """Find the special points between two points.

        A sign change brackets a zero. Two zeros between the points leave no sign change: so the
        test functions are interpolated, and where one may come near zero the point there is
        computed and both halves are searched. At the end what was found must explain how the two
        points differ, else the interval is halved as well.
        """
        place = _suspicious_place(self, known, a, b) if depth < DEPTH else None
        if place is not None and self.excludes(a, b):
            return []
        if place is None:
            found = self.located(known, a, b)
            explained = self.accounts_for(found, a, b)
            if depth >= DEPTH and not explained:
                found += self.hidden(found, known, a, b)
            if depth >= DEPTH or explained:
                return sorted(found, key=lambda item: item.point.arclength)
            place = 0.5 * (a.arclength + b.arclength)
        middle = point_at(self.curve, known, place)
        insert(known, middle)
        left = self.search(known, a, middle, depth + 1)
        return left + self.search(known, middle, b, depth + 1)

    def excludes(self, a: P, b: P) -> bool:
        """Whether nothing can be found between two points, whatever the functions do."""
        return False

    def located(self, known: list[P], a: P, b: P) -> list[Found[P]]:
        """Return the genuine zeros where a function changes its sign between two points."""
        names = [name for name in a.tests if self.changes_sign(name, a, b)]
        found = [locate_test(self.curve, known, a, b, name, name) for name in names]
        return [item for item in found if self.is_genuine(item)]

    def changes_sign(self, name: str, a: P, b: P) -> bool:
        """Whether a test function is positive at one of two points only."""
        before, after = a.tests[name], b.tests[name]
        return isfinite(before) and isfinite(after) and (before > 0) != (after > 0)

    def is_genuine(self, found: Found[P]) -> bool:
        """Whether a zero is what its name says."""
        return True

    def accounts_for(self, found: list[Found[P]], a: P, b: P) -> bool:
        """Whether what was found explains how two points differ."""
        return True

    def hidden(self, found: list[Found[P]], known: list[P], a: P, b: P) -> list[Found[P]]:
        """Return special points at which no function changes its sign."""
        return []


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


def _suspicious_place(watch: Zeros[P], known: Sequence[P], a: P, b: P) -> float | None:
    """Where between two points a test function may touch zero without a sign change at the ends.

    Each is interpolated in that way of two which a point less changes less: by its values, or by
    what it follows from.
    """
    near = well_spaced(known, a.arclength, b.arclength, KNOTS)
    grid = places_between(a.arclength, b.arclength)
    ends = np.array([watch.values(a), watch.values(b)])
    where = np.array([point.arclength for point in near])
    own = _number(near, a), _number(near, b)
    weights = expectation_weights(where, grid, (a.arclength, b.arclength), own)
    values = weights @ np.array([watch.values(point) for point in near])
    place = Expected.of(values, ends).doubtful_place(grid)
    foreseen = None if place is None else watch.foreseen(near, weights)
    if foreseen is None:
        return place
    return Expected.of(values, ends, foreseen).doubtful_place(grid)


def _number(points: Sequence[P], point: P) -> int:
    """Return the index of a point among others, -1 if it is not among them."""
    return next((i for i, item in enumerate(points) if item is point), -1)
