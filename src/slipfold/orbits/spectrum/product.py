"""Floquet multipliers from the transition matrices of all intervals, small ones included."""

from __future__ import annotations

from functools import reduce
from itertools import pairwise

import numpy as np

from slipfold.arrays import Array, Complex

BLOCKS = 16
"""Factors that are kept apart. A product of more loses digits of small multipliers, one of fewer
takes longer: the ratio of two multipliers is spread over as many factors."""

SWEEPS = 60
"""Sweeps at most; what they leave together has moduli within a factor of two."""

GAP = 100.0
"""Moduli this far apart are separated: what is left together loses two digits at most."""

TINY = 1e-300
"""Keeps logarithms finite."""

SEPARATE = 1e-13
"""Invariant subspaces are told apart once the basis turns by no more than this."""

DOUBLE = 1e-5
"""Multipliers nearer than this may be one that is double. Each of two is then known to no more
than the square root of the precision, their mean to all of it."""


def product_eigenvalues(matrices: Array) -> Complex:
    """Return the eigenvalues of a product of matrices, largest modulus first.

    The product itself would bury the small ones under the rounding of the large ones. Simultaneous
    iteration with a QR decomposition after every factor brings the product to block triangular
    form, with a factor of each diagonal block from each matrix (periodic Schur form: Bojanczyk,
    Golub and Van Dooren, SPIE 1770 (1992) 31-42).

    Shapes: matrices (N, n, n); returns (n,).

    >>> rotated = np.linalg.qr(np.array([[1.0, 2.0], [3.0, 1.0]]))[0]
    >>> factor = rotated @ np.diag([1e-4, 1.0]) @ rotated.T
    >>> product_eigenvalues(np.array([factor] * 8)).real * [1, 1e32]
    array([1., 1.])
    """
    # There is none beside the motion of a single angle.
    if not (matrices.size and np.isfinite(matrices).all()):
        return np.full(matrices.shape[1], np.nan + 0j)
    factors = [product(part) for part in np.array_split(matrices, min(BLOCKS, len(matrices)))]
    basis = _dominant_first(product(np.array(factors)))
    groups = [slice(None)]
    for _ in range(SWEEPS):
        start, triangles = basis, []
        for factor in factors:
            basis, triangle = np.linalg.qr(factor @ basis)
            triangles.append(triangle)
        turn = start.T @ basis
        groups = _groups(turn)
        growth = np.sum([np.log(np.abs(np.diag(item)) + TINY) for item in triangles], axis=0)
        if all(np.ptp(growth[group]) < np.log(GAP) for group in groups):
            break
    values = [
        np.linalg.eigvals(
            turn[group, group] @ product(np.array([item[group, group] for item in triangles]))
        )
        for group in groups
    ]
    found = np.concatenate(values).astype(complex)
    return found[np.lexsort((-found.imag, -np.round(np.log(np.abs(found) + TINY), 10)))]


def cycle_multipliers(matrices: Array, rates: Array) -> tuple[complex, Complex]:
    """Return the multiplier of a cycle's own direction and the others.

    The direction of motion is carried around the cycle. In bases that begin with it the transition
    matrices are block triangular; the others are eigenvalues of what is left. So a fold, where
    another multiplier meets this one, does not cost half of the digits.

    Shapes: matrices (N, n, n); rates (N, n); returns others (n - 1,).
    """
    along, across = without_motion(matrices, rates)
    return complex(np.prod(along)), product_eigenvalues(across)


def without_motion(matrices: Array, rates: Array) -> tuple[Array, Array]:
    """Return what each matrix does along a cycle's motion, (N,), and beside it, (N, n - 1, n - 1).

    The motion is carried into itself but for errors, which are eliminated: where all else decays by
    orders of magnitude they would decide. Matrices and rates are those of `cycle_multipliers`.
    """
    bases = motion_bases(rates)
    turned = np.roll(bases, -1, axis=0).transpose(0, 2, 1) @ matrices @ bases
    along, left = turned[:, 0, 0], turned[:, 1:, :1] * turned[:, :1, 1:]
    return along, turned[:, 1:, 1:] - left / along[:, None, None]


def motion_bases(rates: Array) -> Array:
    """Return orthonormal bases that begin with the direction of motion, (N, n, n).

    The other vectors are Householder's reflections of the axes: smooth functions of the rates, as
    what a QR factorisation returns need not be.
    """
    eye = np.eye(rates.shape[1])
    lengths = np.linalg.norm(rates, axis=1)[:, None]
    units = np.where(lengths > 0, rates / np.where(lengths > 0, lengths, 1.0), eye[0])
    signs = np.copysign(1.0, units[:, :1])
    across = units + signs * eye[0]
    bases = eye - across[:, :, None] * (across / (1.0 + np.abs(units[:, :1])))[:, None, :]
    bases[:, :, 0] = units
    return np.asarray(bases)


def product(matrices: Array) -> Array:
    """Return the product of matrices of which the first acts first."""
    return reduce(lambda result, matrix: matrix @ result, matrices)


def multiplier_difference(values: Complex, others: Complex) -> float:
    """Return the largest distance between multipliers and their counterparts."""
    return float(multiplier_differences(values, others).max())


def multiplier_differences(values: Complex, others: Complex) -> Array:
    """Return the distance of each multiplier from its counterpart, shape (n,)."""
    if not np.isfinite(others).all():
        return np.full(len(values), np.nan)
    rest, distances = list(others), []
    for value in values:
        nearest = int(np.argmin(np.abs(np.array(rest) - _mean_near(value, values))))
        distances.append(abs(_mean_near(rest.pop(nearest), others) - _mean_near(value, values)))
    return np.array(distances)


def _dominant_first(product: Array) -> Array:
    """Return an orthonormal basis whose first vectors span the dominant eigenspaces."""
    values, vectors = np.linalg.eig(product)
    order = np.lexsort((values.imag < 0, -np.round(np.abs(values), 12)))
    values, vectors = values[order], vectors[:, order]
    real = np.where(values.imag < 0, vectors.imag, vectors.real)
    # What depends on the others, in a defective matrix, is replaced by something that does not.
    return np.linalg.qr(real + 1e-14 * np.eye(len(values)))[0]


def _groups(turn: Array) -> list[slice]:
    """Return the parts of the basis that span subspaces which are mapped into themselves."""
    n = len(turn)
    inner = [i for i in range(1, n) if np.abs(turn[i:, :i]).max() < SEPARATE]
    return [slice(first, last) for first, last in pairwise([0, *inner, n])]


def _mean_near(value: complex, values: Complex) -> complex:
    return complex(values[np.abs(values - value) < DOUBLE].mean())
