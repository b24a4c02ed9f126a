"""Settings of continuation: tolerances of Newton's method, and lengths of steps."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from slipfold.errors import InputError
from slipfold.text import call_text


@dataclass(frozen=True, repr=False)
class Newton:
    """Convergence criteria of Newton's method.

    Parameters
    ----------
    tolerance
        Maximum residual of an accepted orbit, in scaled states.
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
    """Lengths of steps along a branch.

    Lengths are arclengths in scaled variables: states in scales in which they contribute equally,
    as modes of equal energy do, the parameter in units of the span.

    Parameters
    ----------
    largest
        Maximum step. If an unknown is longer than 10, as at a resonance, the maximum is multiplied
        by a tenth of its length.
    smallest
        A branch that needs a smaller step stops and says so.
    turn
        Maximum angle between neighboring tangents, in rad; twice as large where the second differs
        from its prediction by less.
    points
        Number of points after which a branch stops and says so. Of all tested branches the canards
        of a neuron with a ratio of times of 1000 need the most, 2,500.
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
    """Settings that any curve needs.

    Parameters
    ----------
    newton
        Convergence criteria.
    steps
        Lengths of steps.
    """

    newton: Newton = field(default_factory=Newton)
    steps: Steps = field(default_factory=Steps)

    coarse: ClassVar[float] = 1.0
    """Factor on the allowed errors of predictions, if nothing is located between points."""

    def __repr__(self) -> str:
        """What was given."""
        return call_text(self)


class Coarse(Stepping):
    """The same for a curve of which only the last point matters."""

    coarse = 8.0
