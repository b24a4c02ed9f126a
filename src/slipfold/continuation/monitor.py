"""What is watched along a curve, and what a hit does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

from slipfold.continuation.point import P, Point
from slipfold.continuation.search import Found, Watch, search_between
from slipfold.continuation.trail import Sight, Stretch

__all__ = ["Monitor", "Zeros"]

Q = TypeVar("Q", bound=Point)


class Monitor(Protocol[Q]):
    """Looks at each step of a curve.

    Monitors are asked one after the other. Where one ends the curve, the others look at what is
    left, so that the earliest reason wins, and what was found beyond it is forgotten.
    """

    def watch(self, stretch: Stretch[Q]) -> Sight[Q]:
        """Return what lies between two neighbouring points.

        An error of numbers that break down undoes the step: a shorter one is taken.
        """


class Zeros(Watch[P]):
    """A monitor of functions that change their sign: all their zeros are located, none missed."""

    def watch(self, stretch: Stretch[P]) -> Sight[P]:
        """Locate all zeros between two neighbouring points."""
        curve, known = stretch.trail.curve, stretch.known
        found = search_between(curve, self, known, stretch.before, stretch.point)
        return self.seen(found, stretch)

    def seen(self, found: Sequence[Found[P]], stretch: Stretch[P]) -> Sight[P]:
        """Return what the zeros mean: here they are recorded."""
        return Sight(found)
