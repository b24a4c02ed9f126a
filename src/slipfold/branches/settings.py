"""Options of continuation in small groups, with defaults that hold on all reference cases."""

from __future__ import annotations

from dataclasses import dataclass, field

from slipfold.errors import InputError

__all__ = ["Newton", "Settings", "Steps"]


@dataclass(frozen=True)
class Newton:
    """When an orbit counts as found.

    Parameters
    ----------
    tolerance
        Largest residual of an accepted orbit, in scaled states.
    iterations
        Corrections before a step counts as failed.
    """

    tolerance: float = 1e-10
    iterations: int = 8

    def __post_init__(self) -> None:
        """Refuse tolerances that mean nothing in double precision."""
        if not 1e-13 <= self.tolerance <= 1e-3:
            raise InputError(
                f"Newton tolerance = {self.tolerance:g} is outside 1e-13 to 1e-3; give e.g. 1e-10"
            )
        if self.iterations < 2:
            raise InputError(f"iterations = {self.iterations} cannot converge; give at least 2")


@dataclass(frozen=True)
class Steps:
    """How far a branch goes from one point to the next.

    Lengths are arclengths in scaled variables: displacements in their own scale, the parameter in
    units of the span.

    Parameters
    ----------
    largest
        Cap on the step.
    smallest
        A branch that needs a smaller step stops and says so.
    turn
        Cap on the angle between neighbouring tangents, in rad.
    points
        Points after which a branch stops and says so.
    """

    largest: float = 0.5
    smallest: float = 1e-9
    turn: float = 0.35
    points: int = 2000

    def __post_init__(self) -> None:
        """Refuse steps that contradict each other."""
        if self.points < 1:
            raise InputError(f"points = {self.points} leaves no branch; give at least 1")
        if not 0 < self.turn <= 1.5:
            raise InputError(f"turn = {self.turn:g} rad is outside 0 to 1.5; give e.g. 0.35")
        if not 0 < self.smallest < self.largest:
            raise InputError(
                f"largest step = {self.largest:g} must exceed the smallest, {self.smallest:g} > 0"
            )


@dataclass(frozen=True)
class Settings:
    """All options of continuation.

    Parameters
    ----------
    newton
        When an orbit counts as found.
    steps
        How far a branch goes from one point to the next.
    largest_period
        Doubled branches are followed up to this period, in forcing periods.
    largest_duration
        A branch of cycles ends where one round lasts this many times as long as at its first point.
        Near a homoclinic orbit the duration grows without bound; then eight segments of equal time
        are few, and there may be infinitely many bifurcations.

    Examples
    --------
    >>> Settings(steps=Steps(largest=0.05)).newton.tolerance
    1e-10
    """

    newton: Newton = field(default_factory=Newton)
    steps: Steps = field(default_factory=Steps)
    largest_period: int = 8
    largest_duration: float = 20.0

    def __post_init__(self) -> None:
        """Refuse a period or a duration that no response has."""
        if not self.largest_duration > 1:
            raise InputError(
                f"largest_duration = {self.largest_duration:g} leaves no branch of cycles; give "
                "more than 1, in units of the first cycle's duration"
            )
        if self.largest_period < 1:
            raise InputError(
                f"largest_period = {self.largest_period} is below 1; give 1 to follow the response "
                "alone, 8 for its doublings"
            )
