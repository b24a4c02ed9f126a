"""Settings of continuation: tolerances of Newton's method, and lengths of steps."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

from slipfold.errors import InputError
from slipfold.read_only import Documented
from slipfold.text import call_text


class _Given(Documented):
    """Settings that are shown as the call that makes them."""

    def __repr__(self) -> str:
        """What was given."""
        return call_text(self)


@dataclass(frozen=True, repr=False)
class Newton(_Given):
    """Convergence criteria of Newton's method."""

    tolerance: Annotated[float, "Maximum residual of an accepted orbit, in scaled states."] = 1e-10
    iterations: Annotated[int, "Corrections before a step counts as failed."] = 8

    def __post_init__(self) -> None:
        """Refuse tolerances that mean nothing in double precision."""
        if not 1e-13 <= self.tolerance <= 1e-3:
            raise InputError(
                f"Newton tolerance = {self.tolerance:g} is outside 1e-13 to 1e-3; give e.g. 1e-10"
            )
        if self.iterations < 2:
            raise InputError(f"iterations = {self.iterations} cannot converge; give at least 2")


@dataclass(frozen=True, repr=False)
class Steps(_Given):
    """Lengths of steps along a branch.

    Lengths are arclengths in scaled variables: states in scales in which they contribute equally,
    as modes of equal energy do, the parameter in units of the span.
    """

    largest: Annotated[
        float,
        "Maximum step. If an unknown is longer than 10, as at a resonance, the maximum is "
        "multiplied by a tenth of its length.",
    ] = 1.0
    smallest: Annotated[float, "A branch that needs a smaller step stops and says so."] = 1e-9
    turn: Annotated[
        float,
        "Maximum angle between neighboring tangents, in rad; twice as large where the second "
        "differs from its prediction by less.",
    ] = 0.35
    points: Annotated[
        int,
        "Number of points after which a branch stops and says so. Of all tested branches the "
        "canards of a neuron with a ratio of times of 1000 need the most, 2,500.",
    ] = 3000

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
class Stepping(_Given):
    """Settings that any curve needs."""

    newton: Annotated[Newton, "Convergence criteria."] = field(default_factory=Newton)
    steps: Annotated[Steps, "Lengths of steps."] = field(default_factory=Steps)

    coarse: ClassVar[float] = 1.0
    """Factor on the allowed errors of predictions, if nothing is located between points."""


class Coarse(Stepping):
    """The same for a curve of which only the last point matters."""

    coarse = 8.0
