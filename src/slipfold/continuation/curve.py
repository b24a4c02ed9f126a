"""The equations whose solutions are followed, and their points."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.continuation.newton import (
    Correction,
    Linearized,
    NewtonEquations,
    WholeMatrix,
    correct,
)
from slipfold.errors import BREAKDOWNS


@dataclass(frozen=True, eq=False)
class Point:
    """An accepted solution with the data that continuation needs."""

    z: NDArray[np.float64]  # the unknown
    tangent: NDArray[np.float64]  # unit tangent of the curve, in the direction of travel
    arclength: float  # position on the curve
    tests: dict[str, float]  # functions that change sign at special points, by name
    # Sign of the determinant of the Jacobian bordered by the tangent; it changes at a branch point
    # and not at a fold. Zero where it is not known.
    orientation: int
    residual: float  # residual of the equations
    # Logarithm of that determinant's size; minus infinity where it is not known
    volume: float = -np.inf
    # Derivatives of the equations there; None if they are not stored
    linearization: Any = None
    # Label of the smooth piece of the curve on which it lies; the same for all of a smooth curve
    piece: Any = None
    # Equations that give the unknown its meaning, where that changes along a curve; else None
    curve: Any = None

    @cached_property
    def values(self) -> NDArray[np.float64]:
        """The test functions in their order."""
        return np.array(list(self.tests.values()))

    def resembles(self, other: Point) -> bool:
        """Whether the unknown of another point means the same, so that both are interpolated."""
        return self.curve is other.curve

    @property
    def growth(self) -> float:
        """Upper bound of a function that is zero at bifurcations; infinite where none is known.

        Where it is below zero there is none.
        """
        return np.inf


P = TypeVar("P", bound=Point)
"""Kind of the points of a curve."""


class Curve(NewtonEquations, Generic[P]):
    """A curve of solutions: equations, one less than unknowns, and test functions."""

    odd: tuple[str, ...] = ()
    """Test functions that change their sign with the direction of travel."""

    @property
    def directions(self) -> int:
        """Number of parameters, the last components of an unknown: tests find their extrema."""
        return len(self.odd)

    crossing: tuple[str, ...] = ()
    """The test function that is zero where curves cross, and the one that changes its sign where
    the first does so for another reason, as at a fold; none where they are not known."""

    noise = 1e-9
    """Test functions below this are rounding errors: on a family of centers one of them is zero."""

    @abstractmethod
    def point(self, correction: Correction, arclength: float) -> P:
        """Return a converged correction as a point, with its test functions."""

    def nearest(
        self,
        guess: Array,
        row: Array,
        arclength: float = 0.0,
        within: float = np.inf,
        **given: Any,
    ) -> P | None:
        """Return the point nearest a guess in a hyperplane, None if none is found.

        Nor is one that is farther than `within`. What `correct` takes besides may be given.
        """
        try:
            found = correct(self, guess, row, **given)
            near = found.converged and found.distance <= within
            return self.point(found, arclength) if near else None
        except BREAKDOWNS:
            return None

    def blended(self, known: Sequence[Any], weights: Array) -> Linearized | None:
        """Return a weighted sum of derivatives at several points, None if they are not stored."""
        return None

    def extrapolated(self, points: Sequence[P], weights: Array) -> Array | None:
        """Return the test functions of weighted sums of the derivatives at points.

        None where interpolating their values is as good.

        Shapes: weights (t, points); returns (t, tests), NaN in what no derivatives give.
        """
        return None

    def ahead(self, points: Sequence[P]) -> float:
        """Return the arclength from the last point to where solutions end, infinite if unknown."""
        return np.inf

    def aligned(self, guess: Array, known: Array) -> Array:
        """Return the guess nearest to a known solution of those that symmetry makes equivalent."""
        return guess

    def renewed(self, points: Sequence[P]) -> tuple[Any, list[P]] | None:
        """Return a better description of the curve from here on, with its last points.

        None if its own description is good enough, as most are.
        """
        return None

    def place(self, z: Array) -> tuple[float, ...]:
        """Return the values of the parameters at a solution."""
        return (float(z[-1]),)

    def turned(self, point: P) -> P:
        """Return a point as one of the curve followed in the other direction."""
        return replace(
            point,
            tangent=-point.tangent,
            arclength=-point.arclength,
            tests={
                name: -value if name in self.odd else value for name, value in point.tests.items()
            },
            orientation=-point.orientation,
        )


class AlgebraicCurve(Curve[Point]):
    """Equations given with their whole Jacobian."""

    @abstractmethod
    def jacobian(self, z: Array) -> Array:
        """Return the derivatives of the defect, shape (n - 1, n)."""

    def tests(self, z: Array, tangent: Array) -> dict[str, float]:
        """Return the functions that change sign at special points, by name."""
        return {}

    def linearize(self, z: Array) -> Linearized:
        """Return the defect with its derivatives."""
        return _Dense(self.defect(z), self.jacobian(z))

    def point(self, correction: Correction, arclength: float) -> Point:
        """Return a converged correction as a point, with its test functions."""
        z, bordered = correction.z, correction.bordered
        tangent = bordered.tangent()
        tests = self.tests(z, tangent)
        return Point(
            z, tangent, arclength, tests, bordered.sign, correction.residual, volume=bordered.volume
        )

    def begin(self, guess: Array, row: Array) -> Point:
        """Return the point nearest a guess in a hyperplane; its normal points along the curve."""
        correction = correct(self, np.asarray(guess, dtype=float), np.asarray(row, dtype=float))
        if not correction.converged:
            raise ArithmeticError(correction.failure)
        return self.point(correction, 0.0)


@dataclass(frozen=True, eq=False)
class _Dense:
    """Defect and Jacobian."""

    defect: Array
    jacobian: Array

    @property
    def is_finite(self) -> bool:
        return bool(np.isfinite(self.defect).all() and np.isfinite(self.jacobian).all())

    def bordered(self, row: Array) -> WholeMatrix:
        return WholeMatrix(np.vstack([self.jacobian, row]))
