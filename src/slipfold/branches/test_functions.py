"""Functions of the monodromy matrix that change sign at a bifurcation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["TEST_FUNCTIONS", "doubling", "folding", "torus"]

Values = NDArray[np.complex128]
Array = NDArray[np.float64]


def doubling(multipliers: Values) -> Array:
    """Return det(M + I): zero at a period doubling.

    Parameters
    ----------
    multipliers
        Shape (..., n).
    """
    return (1 + multipliers).prod(axis=-1).real


def folding(multipliers: Values) -> Array:
    """Return det(M - I) up to sign: zero at a fold or a branch point.

    Parameters
    ----------
    multipliers
        Shape (..., n).
    """
    return (1 - multipliers).prod(axis=-1).real


def torus(multipliers: Values) -> Array:
    """Return the determinant of the bialternate product 2 M . M less I, up to sign.

    Zero where the product of two multipliers is one: at a Neimark-Sacker point, and at a neutral
    saddle, which is none (Kuznetsov, Elements of Applied Bifurcation Theory, section 10.2).

    Parameters
    ----------
    multipliers
        Shape (..., n).
    """
    first, second = np.triu_indices(multipliers.shape[-1], k=1)
    return (1 - multipliers[..., first] * multipliers[..., second]).prod(axis=-1).real


TEST_FUNCTIONS = {"PD": doubling, "fold": folding, "NS": torus}
