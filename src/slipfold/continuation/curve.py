"""What the engine asks of the equations whose solutions it follows."""

from __future__ import annotations

from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.newton import Correction, Equations
from slipfold.continuation.point import P, Point

__all__ = ["Curve", "P"]

Array = NDArray[np.float64]

P_co = TypeVar("P_co", bound=Point, covariant=True)


class Curve(Equations, Protocol[P_co]):
    """A curve of solutions: equations, one less than unknowns, and what is noted at each point.

    The equations are those of `slipfold.continuation.newton.Equations`.
    """

    def aligned(self, guess: Array, known: Array) -> Array:
        """Return a guess as near to a known solution as its freedom allows, if it has any."""

    def point(self, correction: Correction, arclength: float) -> P_co:
        """Return a converged correction as a point, with its test functions."""
