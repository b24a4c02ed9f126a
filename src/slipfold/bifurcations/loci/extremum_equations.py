"""The equations of a locus of extrema, such as that of the peaks of resonances."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.loci.locus_equations import LocusEquations
from slipfold.orbits.bifurcation_types import EXTREMUM_TYPES
from slipfold.orbits.linearization import Conditions, Linearization
from slipfold.orbits.measures import Extremal
from slipfold.orbits.orbit_curve import Orbits


class ExtremumEquations(LocusEquations):
    """A locus of extrema of a measure along branches in one of two parameters.

    Its test function ``measure`` is the derivative of the measure along the locus. Where it is zero
    the measure has an extremum or a saddle in both parameters, or the held one turns.
    """

    odd = ("measure", "first", "second")

    def __init__(self, orbits: Orbits, condition: str, extremal: Extremal) -> None:
        super().__init__(orbits, condition)
        self._extremal = extremal
        self.quantity = f"{extremal.measure} {extremal.output}"
        self.held = self.odd[extremal.held]

    @property
    def directions(self) -> int:
        """The two parameters."""
        return 2

    def tests(
        self, z: Array, linearization: Linearization, multipliers: Complex, tangent: Array
    ) -> dict[str, float]:
        """Return the functions that change sign where a parameter or the measure is extremal."""
        rate = self._extremal.gradient(self.orbits, z) @ tangent
        return {**self._standing(tangent), "measure": float(rate)}

    def _values(self, plain: Linearization, z: Array) -> Array:
        return np.array([self._extremal.value(self.orbits, plain, z)])

    def _conditions(self, plain: Linearization, z: Array) -> Conditions:
        return self._extremal.conditions(self.orbits, plain, z)


def equations_of(orbits: Orbits, point: SpecialPoint) -> LocusEquations:
    """Return the equations of the locus of a special point."""
    if point.type not in EXTREMUM_TYPES:
        return LocusEquations(orbits, point.type)
    assert point.measured is not None
    held = -2 if list(orbits.varied)[-1] == point.vary else -1
    return ExtremumEquations(orbits, point.type, Extremal(*point.measured, held))
