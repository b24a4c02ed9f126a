"""Normal forms of equilibria, by the vector field itself."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.normal_forms.field_map import FieldMap
from slipfold.normal_forms.normal_form import (
    critical_coefficient,
    critical_length,
    critical_vectors,
    criticality_of,
    declared,
    fold_coefficient,
)
from slipfold.normal_forms.pair_form import pair_cubic
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits

Vector = NDArray[Any]


def equilibrium_form(orbits: Orbits, point: OrbitPoint, kind: str) -> tuple[float, str | None]:
    """Return the coefficient of an equilibrium's bifurcation and its criticality."""
    field = FieldMap(orbits, point.z)
    ratios = orbits.scales / orbits.model_at(point.z).unit_scales()
    if kind == "HB":
        coefficient = first_lyapunov_coefficient(field)
        size = float(np.linalg.norm(_turning(field.jacobian)[0] * ratios))
        return declared(kind, coefficient, size), criticality_of(kind, coefficient)
    # The map x -> x + f(x) has the equilibrium as its fixed point and the field's derivatives.
    matrix = np.eye(len(orbits.scales)) + field.jacobian
    if kind == "LP":
        coefficient = fold_coefficient(field, matrix, field.pull)
    else:
        coefficient = critical_coefficient(field, matrix, kind)
    size = critical_length(matrix, kind, ratios)
    return declared(kind, coefficient, size), criticality_of(kind, coefficient)


def first_lyapunov_coefficient(field: FieldMap) -> float:
    """Return l1 of a Hopf point: below zero stable cycles are born, above it unstable ones."""
    matrix = field.jacobian
    q, p, value = _turning(matrix)
    identity = np.eye(len(q))
    qq, q_q = field.second([(q, q), (q, q.conj())])
    h11 = -np.linalg.solve(matrix, q_q)
    h20 = np.linalg.solve(2j * value.imag * identity - matrix, qq)
    return float(pair_cubic(field, q, p, h11, h20).real / value.imag)


def _turning(matrix: Array) -> tuple[Vector, Vector, complex]:
    """Critical vectors of the pair of eigenvalues that is nearest to the imaginary axis."""
    return critical_vectors(
        matrix, lambda values: np.where(values.imag > 0, np.abs(values.real), np.inf)
    )
