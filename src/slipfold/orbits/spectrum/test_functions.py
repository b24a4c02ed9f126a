"""Functions of the multipliers that change sign at a bifurcation."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["evaluate_each", "evaluate_tests"]

Array = NDArray[np.float64]

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
    (row,) = evaluate_each(multipliers[None], names)
    return dict(zip(names, row.tolist(), strict=True))


def evaluate_each(
    multipliers: NDArray[np.complex128], names: tuple[str, ...] = ("PD", "fold", "NS")
) -> Array:
    """Evaluate the test functions of several orbits.

    Shapes: multipliers (t, n); returns (t, names).
    """
    groups = [PRODUCTS[name](multipliers) for name in names]
    products = np.concatenate(groups, axis=1)
    factors = 1 - products
    sizes = np.abs(factors)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        ratios = sizes / np.abs(1 - SHRUNK * products)
        turns = factors / sizes
    tests, begin = np.empty((len(multipliers), len(names))), 0
    for column, group in zip(tests.T, groups, strict=True):
        part = np.s_[:, begin : (begin := begin + group.shape[1])]
        column[:] = _compared(sizes[part], ratios[part], turns[part])
    return tests


def _compared(sizes: Array, ratios: Array, turns: NDArray[np.complex128]) -> Array:
    """Real products of 1 - p beside those of 1 - SHRUNK p, as sines of the angles between them."""
    sines = np.sin(np.arctan(ratios.prod(axis=1)))
    signed = np.copysign(sines, turns.prod(axis=1).real)
    return np.where(sizes.all(axis=1), signed, 0.0)


@cache
def _pairs(n: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    return np.triu_indices(n, k=1)


def _of_two(multipliers: NDArray[np.complex128]) -> NDArray[np.complex128]:
    first, second = _pairs(multipliers.shape[1])
    return multipliers[:, first] * multipliers[:, second]


PRODUCTS: dict[str, Callable[[NDArray[np.complex128]], NDArray[np.complex128]]] = {
    "PD": lambda multipliers: -multipliers,
    "fold": lambda multipliers: multipliers,
    "NS": _of_two,
    "HB": _of_two,
}
"""What is one at each bifurcation, of each orbit in its row."""
