"""Loci of cycles of an autonomous model."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.point import Point
from slipfold.loci.locus_problem import LocusProblem
from slipfold.orbits.critical_cycle import CriticalCycle
from slipfold.orbits.cycle_problem import all_multipliers
from slipfold.orbits.linearisation import Linearisation

__all__ = ["CycleLocus"]

Array = NDArray[np.float64]
Multipliers = NDArray[np.complex128]


class CycleLocus(LocusProblem, CriticalCycle):
    """A locus of LP, PD or NS of cycles in two parameters.

    Normal forms of cycles are not computed: there are no coefficients along the locus, and GPD and
    CH, where one of them is zero, are not found.
    """

    @property
    def ends_at_parent(self) -> bool:
        """Whether its orbits may become others whose halves do not differ: equilibria too."""
        return True

    def reported_multipliers(self, point: Point) -> Multipliers:
        """Return the multipliers with that of the flow's own direction, shape (n,).

        Parameters
        ----------
        point
            A point of the locus.
        """
        return all_multipliers(point.multipliers)

    def codimension_two(self, point: Point, kind: str) -> dict[str, float]:
        """Return no coefficients: none are computed.

        Parameters
        ----------
        point
            The point.
        kind
            Name of the test function that is zero there.
        """
        return {}

    def _coefficient(self, z: Array, linearisation: Linearisation) -> float:
        return np.nan
