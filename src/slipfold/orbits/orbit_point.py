"""One point of a curve of orbits while it is being followed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.continuation.point import Point


@dataclass(frozen=True, eq=False, kw_only=True)
class OrbitPoint(Point):
    """An accepted orbit with what continuation needs to know of it.

    The tests of a branch are ``PD``, ``NS``, ``LP`` (the tangent's component along the parameter)
    and ``fold`` (zero at LP and BP alike), its growth is that of the largest multiplier at most.
    """

    monodromy: Array  # monodromy matrix in scaled states, shape (n, n)
    multipliers: NDArray[np.complex128]  # Floquet multipliers, shape (n,)

    @cached_property
    def growth(self) -> float:
        """Upper bound of the logarithms of the multipliers' moduli, if all are inside the circle.

        Computed where it is asked for: that takes as long as the multipliers.
        """
        if self.linearisation is None or not (np.abs(self.multipliers) < 1).all():
            return np.inf
        return float(self.curve.growth(self.linearisation))

    @property
    def unstable(self) -> int:
        """Number of multipliers outside the unit circle."""
        return int(np.count_nonzero(np.abs(self.multipliers) > 1))
