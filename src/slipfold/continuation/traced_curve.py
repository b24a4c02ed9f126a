"""A curve while it is followed, and what its monitors report at each step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, TypeVar

from slipfold.arrays import Array
from slipfold.continuation.curve import P, Point
from slipfold.continuation.end import End


@dataclass(frozen=True, eq=False)
class Found(Generic[P]):
    """A special point that was located."""

    type: str  # what it is called, e.g. ``"PD"``
    point: P  # where it is
    slope: float  # derivative of the test function along the curve
    # Unit tangent of the other curve at a branch point; None elsewhere, and where none crosses
    other: Array | None = None
    unsure: float = 0.0  # uncertainty of its component along the parameter

    @property
    def nearest(self) -> P:
        """The point nearest to it that is a solution with derivatives: itself, mostly."""
        return self.point


@dataclass(eq=False)
class TracedCurve(Generic[P]):
    """What was followed of a curve so far."""

    curve: Any  # its equations, a `Curve`
    points: list[P]  # accepted points
    # Whether it begins where another curve passes, so that it is singular there
    departs: bool = False
    found: list[Found[P]] = field(default_factory=list)  # what was located, in order
    end: End | None = None  # why it ended; None while it continues
    # What it ended on, if that is known: none or one, two if it has two ends
    reached: tuple[Any, ...] = ()
    closes: bool = False  # whether it came back to its first point
    # A point beyond the end, where the last points predicted it as they predict those before it
    ahead: P | None = None

    def recent(self, count: int) -> list[P]:
        """Return the last points, as far as their unknowns mean the same."""
        last = self.points[-1]
        return [point for point in self.points[-count:] if point.resembles(last)]


@dataclass(frozen=True, eq=False)
class Stop(Generic[P]):
    """A reason for a curve to end between two points."""

    point: P  # where
    end: End  # why
    beyond: P | None = None  # a last point that cannot be computed along the curve itself
    reached: Any = None  # what it ended on, if that is known
    closes: bool = False  # whether that is its first point


@dataclass(frozen=True, eq=False)
class MonitorResult(Generic[P]):
    """The result of a monitor between two points: what is recorded, and whether the curve ends."""

    found: Sequence[Found[P]] = ()
    stop: Stop[P] | None = None


class StepInterval(Generic[P]):
    """The curve from its last point to the next, while monitors look at it."""

    def __init__(self, traced: TracedCurve[P], point: P, memory: int) -> None:
        self.traced = traced
        # What interpolation may use, in order; grows
        self.history = [*traced.recent(memory), point]
        self.before = traced.points[-1]
        self.point = point  # its end, which moves back where a monitor ends the curve

    @property
    def leaves(self) -> bool:
        """Whether it leaves another curve, so that it is singular at its first end."""
        return self.traced.departs and len(self.traced.points) == 1

    @property
    def empty(self) -> bool:
        """Whether nothing is left of it."""
        return self.point is self.before

    def cut(self, point: P) -> None:
        """End it at an earlier point."""
        self.history[:] = [item for item in self.history if item.arclength < point.arclength]
        self.history.append(point)
        self.point = point


Q = TypeVar("Q", bound=Point)


Monitor = Callable[[StepInterval[Q]], MonitorResult[Q]]
"""Looks at each step of a curve, and returns what lies between two neighboring points.

Monitors run one after the other. Where one ends the curve, the others look at what is left, so that
the earliest reason wins, and what was found beyond it is forgotten. An error of numbers that break
down undoes the step: a shorter one is taken.
"""


def joined(backward: TracedCurve[P], forward: TracedCurve[P]) -> TracedCurve[P]:
    """Join the two directions of a curve from one point of it."""
    turned = forward.curve.turned
    return replace(
        forward,
        points=[turned(point) for point in backward.points[:0:-1]] + forward.points,
        found=[replace(item, point=turned(item.point)) for item in reversed(backward.found)]
        + forward.found,
        reached=backward.reached + forward.reached,
    )
