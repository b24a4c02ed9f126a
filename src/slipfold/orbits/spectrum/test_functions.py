"""Functions of the multipliers that change sign at a bifurcation."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array

SHRUNK = 0.25
"""A product of factors 1 - p is compared with that of 1 - SHRUNK p. Nearer to one, functions turn
less where multipliers far inside the circle do, but give less warning before one is on it."""


def evaluate_tests(
    multipliers: NDArray[np.complex128], names: tuple[str, ...] = ("PD", "fold", "NS")
) -> dict[str, float]:
    r"""Evaluate the test functions of period doubling, folds and tori.

    ``PD`` has the zeros of det(I + M), ``fold`` those of det(I - M), at folds and branch points
    alike, ``NS`` those of the determinant of I - M (.) M with the bialternate product, the product
    of all :math:`1 - \mu_i \mu_j`: zero at a Neimark-Sacker point and at a neutral saddle, which
    is none (Kuznetsov, Elements of Applied Bifurcation Theory, section 10.2). Of equilibria it is
    called ``HB``.

    Each is :math:`N / \sqrt{N^2 + D^2}`, the determinant N beside the same one D of a matrix whose
    multipliers, or their products, are a quarter as large: smooth functions of the matrix both. It
    stays between -1 and 1, also on the way to a singularity, and turns little where multipliers
    well inside the circle do. With twenty of them N alone varies by orders of magnitude, and so
    could not be told from a function about to vanish.

    Shapes: multipliers (n,).

    >>> evaluate_tests(np.array([-1.0, 0.5]))["PD"]
    0.0
    """
    return dict(zip(names, evaluate_each(multipliers, names).tolist(), strict=True))


def evaluate_each(
    multipliers: NDArray[np.complex128], names: tuple[str, ...] = ("PD", "fold", "NS")
) -> Array:
    """Evaluate the test functions of several orbits.

    Shapes: multipliers (..., n); returns (..., names).
    """
    none = np.zeros((*multipliers.shape[:-1], 1))  # changes nothing, but no group is empty
    parts, begins, size = [], [], 0
    for name in names:
        begins.append(size)
        parts += [none, PRODUCTS[name](multipliers)]
        size += 1 + parts[-1].shape[-1]
    products = np.concatenate(parts, axis=-1)
    factors = 1 - products
    sizes = np.abs(factors)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        ratios = np.multiply.reduceat(sizes / np.abs(1 - SHRUNK * products), begins, axis=-1)
        turns = np.multiply.reduceat(factors / sizes, begins, axis=-1)
    vanish = np.minimum.reduceat(sizes, begins, axis=-1) == 0
    # Real products of 1 - p beside those of 1 - SHRUNK p, as sines of the angles between them.
    return np.where(vanish, 0.0, np.copysign(np.sin(np.arctan(ratios)), turns.real))


@cache
def _pairs(n: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    return np.triu_indices(n, k=1)


def _of_two(multipliers: NDArray[np.complex128]) -> NDArray[np.complex128]:
    first, second = _pairs(multipliers.shape[-1])
    return multipliers[..., first] * multipliers[..., second]


PRODUCTS: dict[str, Callable[[NDArray[np.complex128]], NDArray[np.complex128]]] = {
    "PD": lambda multipliers: -multipliers,
    "fold": lambda multipliers: multipliers,
    "NS": _of_two,
    "HB": _of_two,
}
"""What is one at each bifurcation."""
