"""What is watched along a curve, and what a hit does."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Protocol, TypeVar

from slipfold.arrays import Array
from slipfold.continuation.curve import Curve, P, Point
from slipfold.continuation.search import Found, Watch, locate_test, search_between
from slipfold.continuation.traced_curve import MonitorResult, StepInterval

Q = TypeVar("Q", bound=Point)


class Monitor(Protocol[Q]):
    """Looks at each step of a curve.

    Monitors run one after the other. Where one ends the curve, the others look at what is
    left, so that the earliest reason wins, and what was found beyond it is forgotten.
    """

    def watch(self, interval: StepInterval[Q]) -> MonitorResult[Q]:
        """Return what lies between two neighboring points.

        An error of numbers that break down undoes the step: a shorter one is taken.
        """


class Zeros(Watch[P]):
    """A monitor of functions that change their sign: all their zeros are located, none missed.

    Here of all test functions of the points, recorded by their names.
    """

    def __init__(self, curve: Curve[P]) -> None:
        self.curve = curve

    def foreseen(self, points: Sequence[P], weights: Array) -> Array | None:
        """Return the functions as the derivatives at points let expect them elsewhere."""
        return self.curve.foreseen(points, weights)

    def watch(self, interval: StepInterval[P]) -> MonitorResult[P]:
        """Locate all zeros between two neighboring points."""
        found = search_between(self.curve, self, interval.known, interval.before, interval.point)
        return self.seen(found, interval)

    def seen(self, found: Sequence[Found[P]], interval: StepInterval[P]) -> MonitorResult[P]:
        """Return what the zeros mean: here they are recorded."""
        return MonitorResult(found)

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
