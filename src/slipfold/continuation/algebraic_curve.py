"""Curves of the solutions of any smooth equations with a full Jacobian."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.curve import Curve
from slipfold.continuation.newton import Correction, correct
from slipfold.continuation.point import Point
from slipfold.continuation.whole_matrix import WholeMatrix


class AlgebraicCurve(Curve[Point]):
    """Equations given with their whole Jacobian."""

    @abstractmethod
    def jacobian(self, z: Array) -> Array:
        """Return the derivatives of the defect, shape (n - 1, n)."""

    def tests(self, z: Array, tangent: Array) -> dict[str, float]:
        """Return the functions that change sign at special points, by name."""
        return {}

    def linearise(self, z: Array) -> _Dense:
        """Return the defect with its derivatives."""
        return _Dense(self.defect(z), self.jacobian(z))

    def point(self, correction: Correction, arclength: float) -> Point:
        """Return a converged correction as a point, with its test functions."""
        z, bordered = correction.z, correction.bordered
        tangent = bordered.tangent()
        tests = self.tests(z, tangent)
        return Point(
            z,
            tangent,
            arclength,
            tests,
            bordered.sign,
            correction.residual,
            volume=bordered.volume,
        )

    def begin(self, guess: Array, row: Array) -> Point:
        """Return the point nearest a guess in a hyperplane; the curve goes on along its normal."""
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
