"""How special points move with every parameter: gradients of thresholds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint, sensitive_to
from slipfold.bifurcations.loci.locus_equations import LOCUS, equations_of
from slipfold.bifurcations.loci.start import as_unknown, on_a_mesh
from slipfold.continuation.newton import Correction, SquareMatrix, correct
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.bifurcation_types import FOLLOWED_TYPES
from slipfold.orbits.critical import Critical, crossing_gap
from slipfold.orbits.linearization import Linearization
from slipfold.orbits.orbit_curve import OrbitCurve, Orbits

OTHER, OWN = -2, -1
"""Places of a parameter and of the one followed in an unknown."""


def threshold_gradients(
    point: SpecialPoint, settings: Settings | None = None
) -> dict[str, float] | None:
    r"""Return the derivatives of a special point's value by every other parameter.

    Its orbit and its value p solve the equations of a locus, :math:`G(z, p; q) = 0` at given
    parameters q. One solution with the transposed matrix serves all of them,

    .. math:: \psi^T (G_z, G_p) = (0, 1), \quad dp/dq = -\psi^T G_q .

    None of what has no locus; NaN where no derivative exists or the orbit is not found again.
    """
    if point.type not in FOLLOWED_TYPES:
        return None
    names = sensitive_to(point.model, point.vary)
    if not names:
        return {}
    try:
        return _gradients(point, names, settings or Settings())
    except BREAKDOWNS:
        return dict.fromkeys(names, np.nan)


def _gradients(point: SpecialPoint, names: tuple[str, ...], settings: Settings) -> dict[str, float]:
    planes = {name: plane_of_scales(point, name) for name in names}
    crossing = point.type == "BP"
    if crossing:
        orbits, z = as_unknown(point, point.model, planes[names[0]], settings)
    else:
        orbits, found = solved(point, planes[names[0]], settings)
        z, weights = found.z, _weights(found.bordered, len(found.z))
    gradients = {}
    for name, plane in planes.items():
        beside = orbits.varying(plane)
        z = z.copy()
        z[-2] = point.model.values[name] / plane[name]
        if crossing:  # its equations depend on the plane; in some the branches are parted
            weights = _crossing_weights(beside, z)
        moved = -float(weights @ column_of(equations_of(beside, point, z).linearize(z), OTHER))
        gradients[name] = moved * plane[point.vary] / plane[name] + 0.0
    return gradients


def plane_of_scales(point: SpecialPoint, name: str) -> dict[str, float]:
    """Return a parameter and the one followed, with their scales."""
    return {each: abs(point.model.values[each]) or 1.0 for each in (name, point.vary)}


def solved(
    point: SpecialPoint, plane: Mapping[str, float], settings: Settings
) -> tuple[Orbits, Correction]:
    """Return a special point as it solves its equations; the other parameter is held."""
    orbits, z = as_unknown(point, point.model, plane, settings)
    found = corrected(equations_of(orbits, point, z), z, OTHER, settings)
    if not found.converged and orbits.by.smooth and orbits.kind == "periodic":
        orbits, z = on_a_mesh(orbits, point)
        found = corrected(equations_of(orbits, point, z), z, OTHER, settings)
    if not found.converged or found.distance > LOCUS.moved:
        raise ArithmeticError(found.failure or "the equations lead to another point")
    return orbits, found


def corrected(curve: OrbitCurve, z: Array, place: int, settings: Settings) -> Correction:
    """Solve equations where a parameter is held."""
    newton = settings.newton
    return correct(curve, z, _unit(len(z), place), newton.tolerance, newton.iterations)


def _crossing_weights(orbits: Orbits, z: Array) -> Array:
    """Return the solution for one parameter, NaN where that parts the branches that cross."""
    curve = Critical(orbits, "BP")
    linearization = curve.linearize(z)
    if crossing_gap(orbits, z) > LOCUS.vanishes:
        return np.full(len(linearization.defect), np.nan)
    return _weights(linearization.bordered(_unit(len(z), OTHER)), len(z))


def _weights(bordered: SquareMatrix, size: int) -> Array:
    return bordered.solve_transposed(_unit(size, OWN))[:-1]


def column_of(linearization: Linearization, place: int) -> Array:
    """Return the derivatives of equations by one of the parameters."""
    gradients = linearization.conditions.gradients
    along = linearization.along[:, :, place].ravel()
    return along if gradients is None else np.append(along, gradients[:, place])


def _unit(size: int, place: int) -> Array:
    unit = np.zeros(size)
    unit[place] = 1.0
    return unit
