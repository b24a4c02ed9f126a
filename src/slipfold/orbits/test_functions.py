"""Functions of the monodromy matrix that change sign at a bifurcation."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["evaluate_tests"]

Array = NDArray[np.float64]

LARGEST = 690.0
"""Largest logarithm of a double."""


def evaluate_tests(monodromy: Array, multipliers: NDArray[np.complex128]) -> dict[str, float]:
    r"""Evaluate the test functions of period doubling, folds and tori.

    ``PD`` is det(M + I), ``fold`` is det(I - M), zero at folds and branch points alike, ``NS`` is
    the determinant of I - M (.) M with the bialternate product, the product of all
    :math:`1 - \mu_i \mu_j`: zero at a Neimark-Sacker point and at a neutral saddle, which is none
    (Kuznetsov, Elements of Applied Bifurcation Theory, section 10.2).

    Each is divided by what it grows like where multipliers are large, a smooth function of the
    matrix: it then stays of order one on the way to a singularity and can be interpolated.

    Parameters
    ----------
    monodromy
        Monodromy matrix in scaled states, shape (n, n).
    multipliers
        Its eigenvalues, shape (n,).

    Returns
    -------
    dict
        Values by name.
    """
    n = len(multipliers)
    size = float(np.sqrt(1 + np.linalg.svdvals(monodromy) ** 2).prod())  # root of det(I + M M')
    first, second = _pairs(n)
    products = 1 - multipliers[first] * multipliers[second]
    return {
        "PD": float((1 + multipliers).prod().real / size),
        "fold": float((1 - multipliers).prod().real / size),
        "NS": _scaled_product(products, size, n - 1),
    }


def _scaled_product(factors: NDArray[np.complex128], size: float, power: int) -> float:
    """Real product over a power of the size; with many states either alone would overflow."""
    moduli = np.abs(factors)
    if not moduli.all():
        return 0.0
    sign = float(np.sign((factors / moduli).prod().real))
    exponent = float(np.log(moduli).sum()) - power * float(np.log(size))
    return sign * float(np.exp(np.clip(exponent, -LARGEST, LARGEST)))


@cache
def _pairs(n: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    return np.triu_indices(n, k=1)
