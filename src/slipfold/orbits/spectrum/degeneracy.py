"""How far a monodromy matrix is from a bifurcation, and how that changes with the matrix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.orbits.spectrum.floquet import floquet_multipliers

PAIRED = ("NS", "HB")
"""Bifurcations at which a pair is critical: of orbits, and of equilibria."""

CRITICAL = ("LP", "BP", "PD", *PAIRED)
"""Bifurcations; of whatever else there are loci of, no multiplier is critical."""

MET = 0.5
"""Two real multipliers further apart than this are not a pair that was complex a step before."""


@dataclass(frozen=True, eq=False)
class Degeneracy:
    r"""A number that is zero at a bifurcation, with its derivative."""

    value: float  # smooth function g of the matrix
    # Vectors with :math:`dg = \sum_i p_i^T \, dM \, q_i` where g is zero, each of shape (r, n)
    left: Array
    right: Array

    def carried(self, blocks: Array) -> tuple[Array, Array]:
        """Carry the r vectors to the start of each factor of the matrix and back to each end.

        With :math:`M = A_{m-1} ... A_0` a term :math:`p^T dM q` is the sum over the factors of
        :math:`p_j^T dA_j q_j`.

        Shapes: blocks (m, n, n); returns forward q_j, backward p_j (r, m, n).
        """
        forward, backward = [self.right], [self.left]
        for block in blocks[:-1]:
            forward.append(forward[-1] @ block.T)
        for block in blocks[:0:-1]:
            backward.append(backward[-1] @ block)
        return np.stack(forward, axis=1), np.stack(backward[::-1], axis=1)


UNKNOWN = Degeneracy(np.nan, np.empty((0, 0)), np.empty((0, 0)))
"""Of a matrix that could not be computed, or has no pair."""


def degeneracy(kind: str, monodromy: Array, pair: tuple[int, int] | None = None) -> Degeneracy:
    r"""Measure how far a matrix is from having a critical multiplier.

    LP and PD: the smallest singular value of :math:`M \mp I`, with the sign of the determinant,
    which makes it smooth. It is the number g of the bordered system

    .. math:: \begin{pmatrix} M \mp I & p \\ q^T & 0 \end{pmatrix}
              \begin{pmatrix} v \\ -g \end{pmatrix} = \begin{pmatrix} 0 \\ 1 \end{pmatrix}

    with the best borders there are, the singular vectors p and q (Kuznetsov, Elements of Applied
    Bifurcation Theory, section 10.3: minimally augmented systems). NS: the product of the critical
    pair less one, from the matrix restricted to the plane of the pair, so that it stays smooth
    where the pair meets on the real axis (R1, R2). HB: the same of an equilibrium. All are divided
    by the size of the matrix. The pair is the critical one if its places are not given.

    Shapes: monodromy (n, n).
    """
    of_a_pair = kind in PAIRED
    found = _pair_degeneracy(monodromy, pair) if of_a_pair else _real_degeneracy(kind, monodromy)
    if found is UNKNOWN:
        return found
    # The matrix is known to a share of its largest entry, and so is the number.
    size = float(np.sqrt(1 + np.linalg.norm(monodromy) ** 2))
    return Degeneracy(found.value / size, found.left / size, found.right)


def critical_pair(multipliers: NDArray[np.complex128]) -> tuple[int, int] | None:
    """Return the places of the two multipliers whose product is nearest to one.

    Complex pairs count, and real ones that lie together as two that just met do.

    Shapes: multipliers (n,).
    """
    first, second = np.triu_indices(len(multipliers), k=1)
    a, b = multipliers[first], multipliers[second]
    real = (a.imag == 0) & (b.imag == 0)
    possible = np.where(real, np.abs(a - b) < MET, a == b.conj())
    if not possible.any():
        return None
    distance = np.where(possible, np.abs(1 - a * b), np.inf)
    nearest = int(distance.argmin())
    return int(first[nearest]), int(second[nearest])


def critical_places(kind: str, multipliers: NDArray[np.complex128]) -> NDArray[np.int64]:
    """Return the places of the multipliers that make an orbit critical.

    Shapes: multipliers (n,).
    """
    if kind in PAIRED:
        return np.array(critical_pair(multipliers) or (), dtype=np.int64)
    if kind not in CRITICAL:
        return np.empty(0, dtype=np.int64)
    target = -1.0 if kind == "PD" else 1.0
    return np.array([np.abs(multipliers - target).argmin()], dtype=np.int64)


def _real_degeneracy(kind: str, monodromy: Array) -> Degeneracy:
    shift = -1.0 if kind == "LP" else 1.0
    matrix = monodromy + shift * np.eye(len(monodromy))
    left, values, right = np.linalg.svd(matrix)
    sign = np.sign(np.linalg.det(left) * np.linalg.det(right))
    return Degeneracy(float(sign * values[-1]), sign * left[:, -1:].T, right[-1:])


def _pair_degeneracy(monodromy: Array, pair: tuple[int, int] | None) -> Degeneracy:
    n = len(monodromy)
    multipliers = floquet_multipliers(monodromy)
    pair = pair or critical_pair(multipliers)
    if pair is None:
        return UNKNOWN
    total = (multipliers[pair[0]] + multipliers[pair[1]]).real
    product = (multipliers[pair[0]] * multipliers[pair[1]]).real
    # The quadratic polynomial of the pair is singular on its plane, also where the two coincide.
    polynomial = monodromy @ monodromy - total * monodromy + product * np.eye(n)
    u, _, v = np.linalg.svd(polynomial)
    left, right = u[:, -2:].T, v[-2:]
    gram = np.linalg.inv(left @ right.T)
    restricted = gram @ left @ monodromy @ right.T
    return Degeneracy(product - 1.0, product * np.linalg.inv(restricted) @ gram @ left, right)
