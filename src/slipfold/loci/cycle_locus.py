"""Loci of cycles of an autonomous model."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.normal_form import mean_coefficient
from slipfold.branches.return_map import ReturnMap
from slipfold.loci.locus_problem import LocusProblem
from slipfold.orbits.critical_cycle import CriticalCycle
from slipfold.orbits.cycle_problem import all_multipliers
from slipfold.orbits.linearisation import Linearisation
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["CycleLocus"]

Array = NDArray[np.float64]
Multipliers = NDArray[np.complex128]


class CycleLocus(LocusProblem, CriticalCycle):
    """A locus of LP, PD or NS of cycles in two parameters.

    Coefficients along it are those of the return map, as for the special points of branches, for a
    critical vector whose root mean square round the cycle is one. At points of codimension two no
    coefficients are computed.
    """

    @property
    def ends_at_parent(self) -> bool:
        """Whether its orbits may become others whose halves do not differ: equilibria too."""
        return True

    def reported_multipliers(self, point: OrbitPoint) -> Multipliers:
        """Return the multipliers with that of the flow's own direction, shape (n,)."""
        return all_multipliers(point.multipliers)

    def codimension_two(self, point: OrbitPoint, kind: str) -> dict[str, float]:
        """Return no coefficients: none are computed."""
        return {}

    def _coefficient(self, z: Array, linearisation: Linearisation) -> float:
        map_ = ReturnMap(self, z, self.scales)
        ratios = self.scales / self.model_at(z).unit_scales()
        matrix = map_.rescaled(linearisation.product)
        try:
            return mean_coefficient(map_, matrix, linearisation.product, self.kind, ratios)
        except np.linalg.LinAlgError:
            return np.nan

    def own_length(self, point: OrbitPoint) -> float:
        """Return one: coefficients are for vectors of a mean length already."""
        return 1.0
