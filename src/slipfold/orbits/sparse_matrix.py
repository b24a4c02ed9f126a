"""The Jacobian of an orbit with many nodes and one more row, factored without growth."""

from __future__ import annotations

from functools import cache, cached_property
from math import log
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.continuation.whole_matrix import SquareMatrix

Places = NDArray[np.intp]

LIGHT = 2.0**-10
"""Weight of the rows that are full while pivots are chosen. One that became a pivot early would
fill all that follows: of a thousand intervals an eighth of the matrix, which takes sixteen times
as long."""


class Sparse(SquareMatrix):
    """A Jacobian as its blocks, with pivots where they are largest.

    Where an orbit first grows and then decays by many orders of magnitude, as along canards, going
    from node to node would lose all digits.

    Shapes: blocks (m, n, n); along (m, n, k); lines (k, m n + k), the last row at the end.
    """

    def __init__(self, blocks: Array, along: Array, lines: Array) -> None:
        self.blocks = blocks
        self.along = along
        self.lines = lines

    @property
    def matrix(self) -> Array:
        """The whole matrix."""
        return np.asarray(self._entries(1.0).toarray())

    def _entries(self, weight: float) -> Any:
        """The entries, by columns, with a weight of the rows that are full."""
        from scipy.sparse import csc_array

        m, n, k = self.along.shape
        order, rows, begins = _pattern(m, n, k)
        ones, lines = np.full(m * n, -1.0), self.lines.ravel() * weight
        data = np.concatenate([self.blocks.ravel(), ones, self.along.ravel(), lines])
        size = m * n + k
        return csc_array((data[order], rows, begins), shape=(size, size))

    @cached_property
    def _factors(self) -> Any:
        """Sparse factors with light rows, None of a matrix that is exactly singular."""
        from scipy.sparse.linalg import splu

        try:
            return splu(self._entries(LIGHT))
        except RuntimeError:
            return None

    def solve(self, right: Array) -> Array:
        """Return the solution for a right-hand side, NaN if the matrix is singular."""
        if self._factors is None:
            return np.full_like(right, np.nan)
        return np.asarray(self._factors.solve(self._weighed(right)))

    def solve_transposed(self, right: Array) -> Array:
        """Return the solution with the transposed matrix, NaN if it is singular."""
        if self._factors is None:
            return np.full_like(right, np.nan)
        return self._weighed(self._factors.solve(right, "T"))

    def _weighed(self, vector: Array) -> Array:
        """Return a vector with the weight of the rows that are full."""
        weighed = vector.copy()
        weighed[-len(self.lines) :] *= LIGHT
        return weighed

    @cached_property
    def _kernel(self) -> Array:
        unit = np.zeros(self.lines.shape[1])
        unit[-1] = 1.0
        return self.solve(unit)

    @cached_property
    def _determinant(self) -> tuple[float, float]:
        factors = self._factors
        if factors is None:
            return 0.0, -np.inf
        pivots = factors.U.diagonal()
        sign = np.prod(np.sign(pivots)) * _parity(factors.perm_r) * _parity(factors.perm_c)
        with np.errstate(divide="ignore"):
            logarithm = float(np.log(np.abs(pivots)).sum())
        return float(sign), logarithm - len(self.lines) * log(LIGHT)


@cache
def _pattern(m: int, n: int, k: int) -> tuple[Places, Places, Places]:
    """Order of the entries by column, their rows, and where columns begin."""
    size, width = m * n, m * n + k
    inner = np.arange(n)
    own = (np.arange(m) * n)[:, None, None]
    shape = (m, n, n)
    block_rows = np.broadcast_to(own + inner[:, None], shape).ravel()
    block_columns = np.broadcast_to(own + inner[None, :], shape).ravel()
    node = np.arange(size)
    along_rows, along_columns = np.divmod(np.arange(size * k), k)
    line_rows, line_columns = np.divmod(np.arange(k * width), width)
    rows = np.concatenate([block_rows, node, along_rows, size + line_rows])
    columns = np.concatenate([block_columns, (node + n) % size, size + along_columns, line_columns])
    order = np.lexsort((rows, columns))
    begins = np.searchsorted(columns[order], np.arange(width + 1))
    return order, rows[order].astype(np.int32), begins.astype(np.int32)


def _parity(permutation: Places) -> int:
    """Return 1 for an even permutation, -1 for an odd one."""
    seen, sign = np.zeros(len(permutation), dtype=bool), 1
    following = permutation.tolist()
    for first in range(len(following)):
        length, at = 0, first
        while not seen[at]:
            seen[at], at, length = True, following[at], length + 1
        if length and length % 2 == 0:
            sign = -sign
    return sign
