"""How a curve is followed: when a solution counts as found, and how far the next one lies."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from slipfold.errors import InputError
from slipfold.text.one_line import call_text


@dataclass(frozen=True, repr=False)
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

    def __repr__(self) -> str:
        """What was given."""
        return call_text(self)

    def __post_init__(self) -> None:
        """Refuse tolerances that mean nothing in double precision."""
        if not 1e-13 <= self.tolerance <= 1e-3:
            raise InputError(
                f"Newton tolerance = {self.tolerance:g} is outside 1e-13 to 1e-3; give e.g. 1e-10"
            )
        if self.iterations < 2:
            raise InputError(f"iterations = {self.iterations} cannot converge; give at least 2")


@dataclass(frozen=True, repr=False)
class Steps:
    """How far a branch goes from one point to the next.

    Lengths are arclengths in scaled variables: displacements in their own scale, the parameter in
    units of the span.

    Parameters
    ----------
    largest
        Cap on the step. Where an unknown is longer than 10, as at a resonance, it is a tenth of its
        length times as much.
    smallest
        A branch that needs a smaller step stops and says so.
    turn
        Cap on the angle between neighboring tangents, in rad.
    points
        Points after which a branch stops and says so. Of the branches that are tested the canards
        of a neuron a thousand times as slow as it is fast take most, 2,500.
    """

    largest: float = 1.0
    smallest: float = 1e-9
    turn: float = 0.35
    points: int = 3000

    def __repr__(self) -> str:
        """What was given."""
        return call_text(self)

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


@dataclass(frozen=True, repr=False)
class Stepping:
    """What is needed to follow any curve.

    Parameters
    ----------
    newton
        When a solution counts as found.
    steps
        How far the curve goes from one point to the next.
    """

    newton: Newton = field(default_factory=Newton)
    steps: Steps = field(default_factory=Steps)

    coarse: ClassVar[float] = 1.0
    """How much less well points may be foreseen than where what lies between them is searched."""

    def __repr__(self) -> str:
        """What was given."""
        return call_text(self)


class Coarse(Stepping):
    """The same for a curve of which only the end matters."""

    coarse = 8.0
