"""Functions of the multipliers that change sign at a bifurcation."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["evaluate_tests"]

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
    groups = [PRODUCTS[name](multipliers) for name in names]
    products = np.concatenate(groups)
    factors = 1 - products
    sizes = np.abs(factors)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        ratios = sizes / np.abs(1 - SHRUNK * products)
        turns = factors / sizes
    tests, begin = {}, 0
    for name, group in zip(names, groups, strict=True):
        part = slice(begin, begin := begin + len(group))
        tests[name] = _compared(sizes[part], ratios[part], turns[part])
    return tests


def _compared(sizes: Array, ratios: Array, turns: NDArray[np.complex128]) -> float:
    """Real product of 1 - p beside that of 1 - SHRUNK p, as a sine of the angle between them."""
    if not sizes.all():
        return 0.0
    ratio = float(ratios.prod())
    return math.copysign(math.sin(math.atan(ratio)), float(turns.prod().real))


@cache
def _pairs(n: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    return np.triu_indices(n, k=1)


def _of_two(multipliers: NDArray[np.complex128]) -> NDArray[np.complex128]:
    first, second = _pairs(len(multipliers))
    return multipliers[first] * multipliers[second]


PRODUCTS: dict[str, Callable[[NDArray[np.complex128]], NDArray[np.complex128]]] = {
    "PD": lambda multipliers: -multipliers,
    "fold": lambda multipliers: multipliers,
    "NS": _of_two,
    "HB": _of_two,
}
"""What is one at each bifurcation."""
