"""Normal forms of the stroboscopic map: whether a bifurcation is soft or hard.

Formulas of Kuznetsov, Elements of Applied Bifurcation Theory, 3rd edition, section 5.4.2, and
Kuznetsov and Meijer, SIAM J. Sci. Comput. 26 (2005) 1932-1954, with the map's derivatives
``B(u, v)`` and ``C(u, v, w)`` of the flow, exact.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.normal_forms.jet_map import JetMap
from slipfold.normal_forms.return_chain import ReturnChain
from slipfold.normal_forms.return_map import ReturnMap
from slipfold.orbits.linearisation import Linearisation
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits

Vector = NDArray[Any]

QUADRATIC = ("LP", "transcritical")
"""Kinds whose coefficient is of second order; the others are of third."""


def _from_one(values: Vector) -> Array:
    return np.abs(values - 1)


def _from_minus_one(values: Vector) -> Array:
    return np.abs(values + 1)


def _from_circle(values: Vector) -> Array:
    return np.where(values.imag > 0, np.abs(np.abs(values) - 1), np.inf)


LOST = 1e-3
"""Distance of the map's own critical multiplier from where it was located, beyond which growth on
the way round has taken the digits of the map, and of all that follows from it."""

_DISTANCES: dict[str, Callable[[Vector], Array]] = {
    "LP": _from_one,
    "BP": _from_one,
    "transcritical": _from_one,
    "pitchfork": _from_one,
    "PD": _from_minus_one,
    "NS": _from_circle,
}
"""Functions of the multipliers that are smallest for the critical one."""


class MapDerivatives(Protocol):
    """Second and third derivatives B and C of a map, in scaled states."""

    def rescaled(self, monodromy: Array) -> Array:
        """Return the map's matrix in its scales."""

    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions, each of shape (r, n)."""

    def second(self, pairs: list[tuple[Vector, Vector]]) -> list[Vector]:
        """Return B(u, v) for complex vectors."""


def normal_form(orbits: Orbits, point: OrbitPoint, kind: str) -> tuple[float, str | None]:
    """Return the coefficient of a bifurcation's normal form and its criticality.

    An error of linear algebra says that the map is not known well enough.
    """
    linearisation = point.linearisation or orbits.linearise(point.z)
    map_: JetMap | ReturnMap = (
        ReturnMap(orbits, point.z, orbits.scales)
        if orbits.free_phase
        else JetMap(orbits, point.z, orbits.constants(point.z))
    )
    matrix = map_.rescaled(linearisation.product)
    # Scales that were found, or are those where the branch began, must not be seen in it.
    ratios = orbits.scales / orbits.model_at(point.z).unit_scales()
    if not _DISTANCES[kind](np.linalg.eigvals(matrix).astype(complex)).min() < LOST:
        if not orbits.free_phase or kind not in ("PD", "NS"):
            raise np.linalg.LinAlgError(f"the map has lost the multiplier of its {kind}")
        multipliers = orbits.multipliers(point)
        critical = complex(multipliers[np.argmin(_DISTANCES[kind](multipliers))])
        chain = ReturnChain(orbits, point.z, orbits.scales)
        coefficient, size = chain.form(kind, critical, ratios)
        return declared(kind, coefficient, size), criticality_of(kind, coefficient)
    if kind == "LP":
        coefficient = fold_coefficient(map_, matrix, map_.carried(_parameter_pull(linearisation)))
    else:
        coefficient = critical_coefficient(map_, matrix, kind)
    if isinstance(map_, ReturnMap):
        size = _mean_length(map_, matrix, linearisation.product, kind, ratios)
    else:
        size = critical_length(matrix, kind, ratios)
    return declared(kind, coefficient, size), criticality_of(kind, coefficient)


def critical_length(matrix: Array, kind: str, ratios: Array) -> float:
    """Return the length of the unit critical vector in other scales.

    Shapes: matrix (n, n); ratios (n,).
    """
    return float(np.linalg.norm(critical_vectors(matrix, _DISTANCES[kind])[0] * ratios))


def declared(kind: str, coefficient: float, size: float) -> float:
    """Return a coefficient for a critical vector so many times as long."""
    return coefficient / (size if kind in QUADRATIC else size**2)


def mean_coefficient(
    map_: ReturnMap, matrix: Array, product: Array, kind: str, ratios: Array
) -> float:
    """Return the coefficient of a cycle's PD or NS, wherever the cycle is begun.

    Shapes: matrix (n - 1, n - 1); product (n, n); ratios (n,).
    """
    size = _mean_length(map_, matrix, product, kind, ratios)
    return declared(kind, critical_coefficient(map_, matrix, kind), size)


def _mean_length(map_: ReturnMap, matrix: Array, product: Array, kind: str, ratios: Array) -> float:
    q, _, value = critical_vectors(matrix, _DISTANCES[kind])
    return map_.length(q, value, product, ratios)


def critical_coefficient(map_: MapDerivatives, monodromy: Array, kind: str) -> float:
    """Return the coefficient that tells soft from hard. Shapes: monodromy (n, n)."""
    return _FORMS[kind](map_, monodromy)


SYMMETRIC = 1e-7
"""Quadratic coefficients below this, in scaled states, are rounding: of a pitchfork."""

DEGENERATE = 1e-12
"""Coefficients below this, in scaled states, are rounding: neither soft nor hard."""


def criticality_of(kind: str, coefficient: float) -> str | None:
    """Return ``"supercritical"`` or ``"subcritical"``; None where it is not defined."""
    if kind in QUADRATIC or not abs(coefficient) > DEGENERATE:  # or it is not a number
        return None
    soft = coefficient > 0 if kind == "PD" else coefficient < 0
    return "supercritical" if soft else "subcritical"


def _parameter_pull(linearisation: Linearisation) -> Array:
    """Derivative of the map with respect to the parameter, in the orbits' scaled states."""
    pull = np.zeros(linearisation.along.shape[1])
    for block, along in zip(linearisation.blocks, linearisation.along[:, :, -1], strict=True):
        pull = block @ pull + along
    return pull


def fold_coefficient(map_: MapDerivatives, matrix: Array, pull: Array) -> float:
    """Return the quadratic coefficient of a fold. Shapes: matrix (n, n); pull (n,)."""
    q, p, _ = critical_vectors(matrix, _DISTANCES["LP"])
    second, _ = map_.powers(q.real[None])
    return float(0.5 * (p.real @ second[0]) * np.sign(p.real @ pull))


def _transcritical(map_: MapDerivatives, matrix: Array) -> float:
    q, p, _ = critical_vectors(matrix, _DISTANCES["BP"])
    second, _ = map_.powers(q.real[None])
    return float(0.5 * (p.real @ second[0]))


def _pitchfork(map_: MapDerivatives, matrix: Array) -> float:
    """Cubic coefficient on the centre manifold, where the quadratic one is zero by symmetry."""
    q, p, _ = critical_vectors(matrix, _DISTANCES["BP"])
    second, third = map_.powers(q.real[None])
    n = len(q)
    bordered = np.block([[np.eye(n) - matrix, p.real[:, None]], [p.real[None], np.zeros((1, 1))]])
    bent = np.linalg.solve(bordered, np.append(second[0], 0.0))[:n]
    (mixed,) = map_.second([(q, bent.astype(complex))])
    return float(p.real @ (third[0] + 3 * mixed.real) / 6)


def _crossing(map_: MapDerivatives, matrix: Array) -> float:
    """Cubic coefficient of a branch point if it is a pitchfork, NaN of a transcritical one."""
    return np.nan if abs(_transcritical(map_, matrix)) > SYMMETRIC else _pitchfork(map_, matrix)


def _doubling(map_: MapDerivatives, matrix: Array) -> float:
    q, p, _ = critical_vectors(matrix, _DISTANCES["PD"])
    second, third = map_.powers(q.real[None])
    bent = np.linalg.solve(np.eye(len(q)) - matrix, second[0])
    (mixed,) = map_.second([(q, bent.astype(complex))])
    return float(p.real @ (third[0] + 3 * mixed.real) / 6)


def _torus(map_: MapDerivatives, matrix: Array) -> float:
    q, p, value = critical_vectors(matrix, _DISTANCES["NS"])
    a, b = q.real, q.imag
    second, third = map_.powers(np.array([a, b, a + b, a - b]))
    aa, bb = second[0], second[1]
    ab = (second[2] - second[3]) / 4
    aaa, bbb = third[0], third[1]
    aab = (third[2] - third[3]) / 6 - bbb / 3
    abb = (third[2] + third[3]) / 6 - aaa / 3
    cubic = aaa + abb + 1j * (aab + bbb)  # C(q, q, conj q)
    identity = np.eye(len(a))
    still = np.linalg.solve(identity - matrix, aa + bb).astype(complex)
    double = np.linalg.solve(value**2 * identity - matrix, aa - bb + 2j * ab).astype(complex)
    # 2 B(q, still) + B(conj q, double), of half as many products of real vectors.
    mixed = map_.second(
        [(a.astype(complex), 2 * still + double), (b.astype(complex), 1j * (2 * still - double))]
    )
    inner = np.vdot(p, cubic + sum(mixed))
    return float(0.5 * (value.conjugate() / abs(value) * inner).real)


_FORMS: dict[str, Callable[[MapDerivatives, Array], float]] = {
    "PD": _doubling,
    "NS": _torus,
    "BP": _crossing,
    "transcritical": _transcritical,
    "pitchfork": _pitchfork,
}


def critical_vectors(
    matrix: Array, distance: Callable[[Vector], Array]
) -> tuple[Vector, Vector, complex]:
    """Return the eigenvectors of the eigenvalue that lies nearest to where it should.

    Shapes: matrix (n, n); distance (n,); returns q, p (n,).
    """
    values, vectors = np.linalg.eig(matrix)
    index = int(np.argmin(distance(values)))
    value, q = complex(values[index]), vectors[:, index].astype(complex)
    # A real eigenvector is returned real; a complex one with orthogonal real and imaginary parts.
    q = q * np.exp(-0.5j * np.angle(np.sum(q * q)))
    q /= np.linalg.norm(q)
    others, left = np.linalg.eig(matrix.T)
    p = left[:, np.argmin(np.abs(others - value))].astype(complex).conj()
    return q, p / np.vdot(q, p), value
