"""The normal forms that orbits have: which maps and formulas serve which kind of orbits."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.orbits.critical import Critical
from slipfold.orbits.kinds import Cycles, Equilibria
from slipfold.orbits.linearization import Linearization
from slipfold.orbits.normal_forms.codimension_two import (
    codimension_two_coefficients,
    equilibrium_coefficients,
)
from slipfold.orbits.normal_forms.maps import FieldMap, JetMap, ReturnMap, SegmentMap
from slipfold.orbits.normal_forms.normal_form import (
    Coefficient,
    critical_coefficient,
    equilibrium_form,
    first_lyapunov_coefficient,
    mean_length,
    normal_form,
    quintic_coefficient,
    stroboscopic_length,
)
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits


class Forms:
    """Those of forced orbits: of the stroboscopic map."""

    neutral = 1e-8
    """Least sin(angle)^2 at which the coefficient of a torus still has digits."""

    def special(self, orbits: Orbits, point: OrbitPoint, kind: str) -> Coefficient:
        """Find the coefficient of a bifurcation of a branch, and its criticality."""
        return normal_form(orbits, point, kind)

    def coefficient(self, curve: Critical, z: Array, linearization: Linearization) -> float:
        """Return the coefficient along a locus, for a unit critical vector in scaled states.

        An error of linear algebra says that there is none.
        """
        map_ = SegmentMap(curve.orbits, z, linearization)
        known = curve.critical_multiplier(linearization)
        return critical_coefficient(map_, linearization.monodromy, curve.condition, known)

    def length(self, curve: Critical, point: OrbitPoint) -> float:
        """Return the mean length of the unit critical vector in the scales of the orbit's model."""
        places = point.critical(curve.condition)
        values, vectors = np.linalg.eig(point.monodromy)
        vector = vectors[:, np.abs(values - point.multipliers[places[0]]).argmin()]
        ratios = _ratios(curve.orbits, point.z)
        return stroboscopic_length(curve.orbits, point, vector, ratios)

    def codimension_two(self, curve: Critical, point: OrbitPoint, kind: str) -> dict[str, float]:
        """Return the coefficients that decide what happens near a point of codimension two."""
        orbits = curve.orbits
        own = orbits.model_at(point.z).unit_scales()
        if kind == "GPD":
            jets = JetMap(orbits, point.z, own)
            return {"e": quintic_coefficient(jets, jets.rescaled(point.monodromy))}
        map_ = SegmentMap(orbits, point.z, curve.linearize(point.z), own)
        return codimension_two_coefficients(map_, map_.rescaled(point.monodromy), kind)


class CycleForms(Forms):
    """Those of cycles: of the return map.

    At points of codimension two no coefficients are computed.
    """

    def coefficient(self, curve: Critical, z: Array, linearization: Linearization) -> float:
        """Return the coefficient along a locus, for a critical vector of unit length in a section.

        Its sign and smoothness are enough where points are located.
        """
        if isinstance(curve.orbits, Cycles) and curve.orbits.stands(z):
            raise np.linalg.LinAlgError("a cycle of no amplitude has no return map")
        map_ = ReturnMap(curve.orbits, z, curve.orbits.scales)
        known, matrix = curve.critical_multiplier(linearization), linearization.product
        return critical_coefficient(map_, map_.rescaled(matrix), curve.condition, known)

    def length(self, curve: Critical, point: OrbitPoint) -> float:
        """Return the mean length of that vector, which does not depend on where a cycle begins."""
        orbits = curve.orbits
        map_ = ReturnMap(orbits, point.z, orbits.scales)
        product = (point.linearization or orbits.linearize(point.z)).product
        ratios = _ratios(orbits, point.z)
        return mean_length(map_, map_.rescaled(product), product, curve.condition, ratios)

    def codimension_two(self, curve: Critical, point: OrbitPoint, kind: str) -> dict[str, float]:
        """Return no coefficients."""
        return {}


class EquilibriumForms(Forms):
    """Those of equilibria: of the vector field."""

    neutral = 1e-12
    """As for orbits; nothing is integrated here, and beside fast decay all angles are small."""

    def special(self, orbits: Orbits, point: OrbitPoint, kind: str) -> Coefficient:
        """Find the coefficient of a bifurcation of a branch, and its criticality."""
        return equilibrium_form(orbits, point, kind)

    def coefficient(self, curve: Critical, z: Array, linearization: Linearization) -> float:
        """Return the coefficient along a locus."""
        field = FieldMap(curve.orbits, z)
        if curve.condition == "BP":
            matrix = np.eye(len(curve.orbits.scales)) + field.jacobian
            return critical_coefficient(field, matrix, "BP")
        known, orbits = curve.critical_multiplier(linearization), curve.orbits
        if known is None:
            return first_lyapunov_coefficient(field)
        assert isinstance(orbits, Equilibria)
        return first_lyapunov_coefficient(field, orbits.frequency(z, known))

    def codimension_two(self, curve: Critical, point: OrbitPoint, kind: str) -> dict[str, float]:
        """Return the coefficients that decide what happens near a point of codimension two."""
        own = curve.orbits.model_at(point.z).unit_scales()
        return equilibrium_coefficients(FieldMap(curve.orbits, point.z, own), kind)


def forms_of(orbits: Orbits) -> Forms:
    """Return the normal forms that orbits have."""
    if orbits.kind == "equilibrium":
        return EquilibriumForms()
    return CycleForms() if orbits.free_phase else Forms()


def _ratios(orbits: Orbits, z: Array) -> Array:
    """Scales of the unknown over those of the orbit's own model, shape (n,)."""
    return orbits.scales / orbits.model_at(z).unit_scales()
