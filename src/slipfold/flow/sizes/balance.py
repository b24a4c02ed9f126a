"""Ratios of coupled states: those in which a linear system has rows and columns of one size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["balanced", "coupled"]

Array = NDArray[np.float64]

ROUNDS = 60
"""Steps towards balance; a chain of a hundred states needs no more to come within a factor."""

ENOUGH = 0.1
"""Logarithm of what rows and columns may differ by: sizes are rounded to powers of two."""

WEAK = 0.1
"""Where a state drives another that does not act back, their ratio is that of a coupling back with
this share of the typical rate."""


def balanced(matrix: Array, rate: float) -> Array:
    """Return the sizes of states that balance a system's matrix, shape (n,).

    They are known up to a factor for each group of coupled states; the first of each has one.

    Shapes: matrix (n, n).
    """
    size, groups = np.ones(len(matrix)), coupled(matrix)
    entries = matrix * ~np.eye(len(matrix), dtype=bool)
    both = np.sqrt((entries * entries.T).max(initial=0.0))
    typical = rate or max(float(both), float(np.abs(np.diag(matrix)).max(initial=0.0))) or 1.0
    with np.errstate(divide="ignore", over="ignore"):
        back = np.where(entries > 0, (WEAK * typical) ** 2 / entries, 0.0).T
    entries = np.maximum(entries, back)
    for _ in range(ROUNDS):
        scaled = entries * size / size[:, None]
        rows, columns = scaled.sum(axis=1), scaled.sum(axis=0)
        acts = (rows > 0) & (columns > 0)
        unequal = rows[acts] / columns[acts]
        size[acts] *= unequal**0.25
        if np.abs(np.log(unequal)).max(initial=0.0) < ENOUGH:
            break
    return size / size[groups]


def coupled(matrix: Array) -> NDArray[np.intp]:
    """Return for each state the first one of those it is coupled with, directly or not.

    Shapes: matrix (n, n).
    """
    near = (matrix != 0) | (matrix.T != 0) | np.eye(len(matrix), dtype=bool)
    first = np.arange(len(matrix))
    while True:
        nearest = np.where(near, first, len(matrix)).min(axis=1)
        if np.array_equal(nearest, first):
            return first
        first = nearest
