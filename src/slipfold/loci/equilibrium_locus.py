"""Loci of equilibria of an autonomous model: folds and Hopf points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.equilibrium_form import first_lyapunov_coefficient
from slipfold.branches.field_map import FieldMap
from slipfold.loci.equilibrium_forms import equilibrium_coefficients
from slipfold.loci.locus_problem import LocusProblem
from slipfold.orbits.critical_equilibrium import CriticalEquilibrium, eigenvalues_of
from slipfold.orbits.linearisation import Linearisation
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["EquilibriumLocus"]

Array = NDArray[np.float64]
Multipliers = NDArray[np.complex128]

NAMES = {"CPC": "CP", "R1": "BT", "CH": "GH", "LPNS": "ZH", "NSNS": "HH"}
"""What the points of codimension two of maps are called for equilibria."""

OF_MAPS = ("LPPD", "PDNS", "R2", "R3", "R4")
"""Test functions that mean nothing here: no frequency is special to an equilibrium."""


class EquilibriumLocus(LocusProblem, CriticalEquilibrium):
    """A locus of LP or of Hopf points (NS, the Cayley transform's) in two parameters."""

    orbits = "equilibrium"

    neutral = 1e-12
    """As for orbits; nothing is integrated here, and beside fast decay all angles are small."""

    @property
    def type(self) -> str:
        """What the bifurcation is called in results."""
        return "HB" if self.kind == "NS" else self.kind

    def named(self, found: str) -> str:
        """Return what a special point is called in results."""
        return NAMES.get(found, found)

    def reported_multipliers(self, point: OrbitPoint) -> Multipliers:
        """Return the multipliers of the flow over the model's ``duration``, shape (n,)."""
        values = eigenvalues_of(FieldMap(self, point.z).jacobian)
        return np.exp(values * self.constants(point.z).period)

    def tests(
        self, z: Array, linearisation: Linearisation, multipliers: Multipliers, tangent: Array
    ) -> dict[str, float]:
        """Return the functions that change sign at points of codimension two.

        Shapes: multipliers (n,).
        """
        tests = super().tests(z, linearisation, multipliers, tangent)
        return {name: value for name, value in tests.items() if name not in OF_MAPS}

    def codimension_two(self, point: OrbitPoint, kind: str) -> dict[str, float]:
        """Return the coefficients that decide what happens near a point of codimension two."""
        field = FieldMap(self, point.z, self.model_at(point.z).unit_scales())
        return equilibrium_coefficients(field, self.named(kind))

    def _coefficient(self, z: Array, linearisation: Linearisation) -> float:
        try:
            return first_lyapunov_coefficient(FieldMap(self, z))
        except np.linalg.LinAlgError:
            return np.nan
