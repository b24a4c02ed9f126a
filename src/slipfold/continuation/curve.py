"""What the engine asks of the equations whose solutions it follows."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Generic

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.newton import Correction, Linearised
from slipfold.continuation.point import P


class Curve(ABC, Generic[P]):
    """A curve of solutions: equations, one less than unknowns, and what is noted at each point."""

    odd: tuple[str, ...] = ()
    """Test functions that change their sign with the direction of travel."""

    noise = 1e-9
    """Test functions below this are rounding: on a family of centres one of them is zero."""

    @abstractmethod
    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero."""

    @abstractmethod
    def linearise(self, z: Array) -> Linearised:
        """Return the defect with its derivatives."""

    @abstractmethod
    def point(self, correction: Correction, arclength: float) -> P:
        """Return a converged correction as a point, with its test functions."""

    def blended(self, known: Sequence[Any], weights: Array) -> Linearised | None:
        """Return a weighted sum of derivatives at several points, None if they are not kept."""
        return None

    def foreseen(self, points: Sequence[P], weights: Array) -> Array | None:
        """Return the test functions that weighted sums of the derivatives at points have.

        None where their values at the points tell as much.

        Shapes: weights (t, points); returns (t, tests), NaN in what no derivatives give.
        """
        return None

    def residual(self, defect: Array) -> float:
        """Return by how much an unknown fails, as tolerances are meant."""
        return float(np.abs(defect).max())

    def aligned(self, guess: Array, known: Array) -> Array:
        """Return a guess as near to a known solution as its freedom allows, if it has any."""
        return guess

    def renewed(self, points: Sequence[P]) -> tuple[Any, list[P]] | None:
        """Return the last points of the curve as those of one that is better described from there.

        None where its own description serves, as most do everywhere.
        """
        return None

    def place(self, z: Array) -> tuple[float, ...]:
        """Return the values that tell where on the curve a solution is."""
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
