"""One point of a curve while it is being followed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Point:
    """An accepted solution with what continuation needs to know of it."""

    z: NDArray[np.float64]  # the unknown
    tangent: NDArray[np.float64]  # unit tangent of the curve, in the direction of travel
    arclength: float  # position on the curve
    tests: dict[str, float]  # functions that change sign at special points, by name
    # Sign of the determinant of the Jacobian bordered by the tangent; it changes at a branch point
    # and not at a fold. Zero where it is not known.
    orientation: int
    residual: float  # how far the solution fails to meet the equations
    # Logarithm of that determinant's size; minus infinity where it is not known
    volume: float = -np.inf
    # Derivatives of the equations there; None where they are not known any more
    linearisation: Any = None
    # On which smooth piece of a curve it lies; the same for all where the curve is smooth
    piece: Any = None
    # Says what the unknown means, where that changes along a curve; None where it does not
    curve: Any = None

    @cached_property
    def values(self) -> NDArray[np.float64]:
        """The test functions in their order."""
        return np.array(list(self.tests.values()))

    @property
    def growth(self) -> float:
        """Upper bound of what is zero where something may happen; infinite where none is known.

        Where it is below zero nothing does.
        """
        return np.inf


P = TypeVar("P", bound=Point)
"""Kind of the points of a curve."""
