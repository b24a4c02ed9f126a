"""Undamped modes of a structure, from full or sparse matrices."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError

SHIFT = 1e-6
"""Shift of the search for sparse modes, over a typical squared frequency: free motions are found
too."""


def lowest_modes(stiffness: Any, mass: Any, count: int | None = None) -> tuple[Array, Array]:
    """Return the lowest undamped modes.

    Shapes: stiffness, mass (n, n); returns squares (count,), shapes (n, count).
    """
    size = mass.shape[0]
    if isinstance(mass, np.ndarray):
        squares, shapes = _full_modes(stiffness, mass)
    elif count is None or count >= size - 1:
        squares, shapes = _full_modes(stiffness.toarray(), mass.toarray())
    else:
        squares, shapes = _sparse_modes(stiffness, mass, count)
    squares, shapes = squares[:count], shapes[:, :count]
    # One sign and size for every mode, so that the same matrices give the same equations.
    largest = np.abs(shapes).argmax(axis=0)
    return squares, shapes / shapes[largest, np.arange(shapes.shape[1])]


def solver(matrix: Any, what: str) -> Callable[[Array], Array]:
    """Return a function that solves linear equations with a matrix. Shapes: matrix (n, n)."""
    if isinstance(matrix, np.ndarray):
        if matrix.size and np.linalg.cond(matrix) > 1e14:
            raise InputError(what)
        return lambda right: np.asarray(np.linalg.solve(matrix, right), dtype=float)
    from scipy.sparse.linalg import splu

    try:
        factors = splu(matrix.tocsc())
    except RuntimeError:
        raise InputError(what) from None
    return lambda right: np.asarray(factors.solve(right))


def _full_modes(stiffness: Array, mass: Array) -> tuple[Array, Array]:
    # To standard form by the Cholesky factor of the mass: M = G G^T.
    factor = np.linalg.cholesky((mass + mass.T) / 2)
    half = np.linalg.solve(factor, (stiffness + stiffness.T) / 2)
    standard = np.linalg.solve(factor, half.T)
    squares, vectors = np.linalg.eigh((standard + standard.T) / 2)
    return squares, np.linalg.solve(factor.T, vectors)


def _sparse_modes(stiffness: Any, mass: Any, count: int) -> tuple[Array, Array]:
    from scipy.sparse.linalg import eigsh

    typical = abs(stiffness.diagonal()).sum() / mass.diagonal().sum()
    start = np.ones(mass.shape[0])
    squares, shapes = eigsh(
        stiffness.tocsc(), count, mass.tocsc(), sigma=-SHIFT * typical, which="LM", v0=start
    )
    order = np.argsort(squares)
    return squares[order], shapes[:, order]
