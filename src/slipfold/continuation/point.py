"""One point of a curve while it is being followed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

__all__ = ["P", "Point"]


@dataclass(frozen=True, eq=False)
class Point:
    """An accepted solution with what continuation needs to know of it.

    Parameters
    ----------
    z
        The unknown.
    tangent
        Unit tangent of the curve, in the direction of travel.
    arclength
        Position on the curve.
    tests
        Functions that change sign at special points, by name.
    orientation
        Sign of the determinant of the Jacobian bordered by the tangent; it changes at a branch
        point and not at a fold. Zero where it is not known.
    residual
        How far the solution fails to meet the equations.
    growth
        Upper bound of what is zero where something may happen: where it is below zero nothing
        does. Infinite where none is known.
    volume
        Logarithm of that determinant's size; minus infinity where it is not known.
    linearisation
        Derivatives of the equations there; None where they are not known any more.
    curve
        Says what the unknown means, where that changes along a curve; None where it does not.
    """

    z: NDArray[np.float64]
    tangent: NDArray[np.float64]
    arclength: float
    tests: dict[str, float]
    orientation: int
    residual: float
    growth: float = np.inf
    volume: float = -np.inf
    linearisation: Any = None
    curve: Any = None


P = TypeVar("P", bound=Point)
"""Kind of the points of a curve."""
