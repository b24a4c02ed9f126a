"""Ratios of coupled states: those in which a linear system has rows and columns of one size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array

ROUNDS = 60
"""Steps towards balance; a chain of a hundred states needs no more to come within a factor."""

ENOUGH = 0.1
"""Logarithm of what rows and columns may differ by: sizes are rounded to powers of two."""

WEAK = 0.1
"""Where a state drives another that does not act back, their ratio is that of a coupling back with
this share of the typical rate."""

NEGLIGIBLE = 1e-100
"""Share of the largest entry below which one couples nothing: what follows from it overflows."""


def balanced(matrix: Array, rate: float, loops: NDArray[np.intp]) -> Array:
    """Return the sizes of states that balance a system's matrix, shape (n,).

    They are known up to a factor for each group of coupled states; the first of each has one.

    Shapes: matrix (n, n); loops (n,).
    """
    matrix = np.where(matrix < NEGLIGIBLE * matrix.max(), 0.0, matrix)
    size, groups = np.ones(len(matrix)), coupled(matrix)
    entries = matrix * ~np.eye(len(matrix), dtype=bool)
    own = np.diag(matrix)
    fastest = largest_in(loops, np.maximum(np.sqrt(entries * entries.T).max(axis=1), own))
    typical = rate or np.maximum(fastest, fastest[:, None])
    weak = WEAK * np.where(np.equal(typical, 0), 1.0, typical)
    # What follows without acting back is no larger than its own decay lets it become.
    lasting = np.maximum(weak, (loops != loops[:, None]) * own[:, None])
    with np.errstate(divide="ignore", over="ignore"):
        back = np.where(entries > 0, lasting**2 / entries, 0.0).T
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


def loops_of(feeds: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return for each state the first one of those it feeds and is fed by, directly or not.

    Shapes: feeds (n, n), of each rate the states that are in it.
    """
    reached = feeds | np.eye(len(feeds), dtype=bool)
    for _ in range(len(feeds).bit_length()):
        reached = reached @ reached
    return np.asarray((reached & reached.T).argmax(axis=1))


def largest_in(loops: NDArray[np.intp], values: Array) -> Array:
    """Return of each state the largest value in its loop. Shapes: values (n,)."""
    result = np.zeros(loops.max() + 1)
    np.fmax.at(result, loops, values)  # what is not a number is not known
    return result[loops]
