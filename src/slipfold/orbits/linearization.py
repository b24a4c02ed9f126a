"""Derivatives of a boundary-value problem at an orbit, and its Jacobian with one more row."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from math import isfinite, log, sqrt
from typing import Any

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.continuation.newton import LeastSquares, SquareMatrix, WholeMatrix


class ELIMINATION:
    """How the linear equations of an orbit are solved."""

    # Weight of the rows that are full while pivots are chosen. One that became a pivot early would
    # fill all that follows: of a thousand intervals an eighth of the matrix, which takes sixteen
    # times as long
    light: float = 2.0**-10
    # Growth of perturbations from the first node to any other with which going from node to node
    # loses three digits at most
    growth: float = 1e3
    # Unknowns up to which one inversion of the whole matrix is quicker than sparse factors
    large: int = 64


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
            # Columns are in order.
            return splu(self._entries(ELIMINATION.light), permc_spec="NATURAL")
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
        weighed[-len(self.lines) :] *= ELIMINATION.light
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
        return float(sign), logarithm - len(self.lines) * log(ELIMINATION.light)


class Condensed(Sparse):
    """The same where perturbations grow little: all nodes but the first are eliminated.

    What is left is a full matrix of the first node and the free parameters. The columns of the
    first node are moved past those of the others, an even number of places or rows of minus one:
    the determinant is that of the whole matrix.

    Shapes: reached (m, n, n + k), what perturbations of the first node and parameters make of each.
    """

    def __init__(self, blocks: Array, along: Array, lines: Array, reached: Array) -> None:
        super().__init__(blocks, along, lines)
        self._reached = reached
        m, n, size = *along.shape[:2], reached.shape[2]
        closed = blocks[-1] @ reached[-1]
        closed[:, n:] += along[-1]
        closed[:, :n] -= np.eye(n)
        rows = lines[:, : m * n] @ reached.reshape(m * n, size)
        rows[:, n:] += lines[:, m * n :]
        self._small = WholeMatrix(np.concatenate([closed, rows]))

    @staticmethod
    def reach(blocks: Array, along: Array) -> Array | None:
        """Return what perturbations become at the nodes, None where some grow too much."""
        m, n, k = along.shape
        reached = np.zeros((m, n, n + k))
        reached[0, :, :n] = np.eye(n)
        for j in range(m - 1):
            reached[j + 1] = blocks[j] @ reached[j]
            reached[j + 1, :, n:] += along[j]
        largest = np.abs(reached[:, :, :n]).max()
        return reached if largest < ELIMINATION.growth else None

    def solve(self, right: Array) -> Array:
        """Return the solution for a right-hand side, NaN if the matrix is singular."""
        m, n, _ = self.along.shape
        rows, state = right[: m * n].reshape(m, n), np.zeros(n)
        own = np.zeros((m, n))
        for j in range(m - 1):
            own[j + 1] = state = self.blocks[j] @ state - rows[j]
        closed = rows[-1] - self.blocks[-1] @ state
        met = right[m * n :] - self.lines[:, : m * n] @ own.ravel()
        small = self._small.solve(np.concatenate([closed, met]))
        return np.concatenate([(self._reached @ small + own).ravel(), small[n:]])

    @cached_property
    def _kernel(self) -> Array:
        n, small = self.along.shape[1], self._small._kernel
        return np.concatenate([(self._reached @ small).ravel(), small[n:]])

    @property
    def _determinant(self) -> tuple[float, float]:
        return self._small._determinant


@cache
def _pattern(m: int, n: int, k: int) -> tuple[Indices, Indices, Indices]:
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


def _parity(permutation: Indices) -> int:
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


MANY = 12
"""Nodes beyond which they may be those of a mesh, through which an orbit may grow without bound."""


@dataclass(frozen=True, eq=False)
class Conditions:
    """Equations besides those of the orbit, e.g. that it is at a bifurcation."""

    # How far each is from being met, shape (d,)
    values: Array = field(default_factory=lambda: np.empty(0))
    # Their derivatives with respect to the unknown, shape (d, m n + k)
    gradients: Array | None = None
    # Perturbations along which second derivatives of the segments are known, shape (r, m, n)
    propagated: Array | None = None
    # Those second derivatives, ``D^2 phi_j [v_j, .]``, shape (r, m, n, n)
    bent: Array | None = None


NO_CONDITIONS = Conditions()


@dataclass(frozen=True, eq=False)
class Linearization:
    """Mismatch of an orbit and its derivatives, in scaled variables."""

    residual: Array  # shape (m, n), in scaled states
    blocks: Array  # transition matrices of the segments, shape (m, n, n)
    # Derivatives of the segments' ends with respect to the k scaled parameters, shape (m, n, k)
    along: Array
    conditions: Conditions = NO_CONDITIONS  # further equations
    # Gives the matrix whose eigenvalues are watched; the product of the blocks if None
    watched: Callable[[Linearization], Array] | None = None
    # The blocks without what decays within a segment, shape (m, n, n); None where they are as good
    settled: Array | None = None
    piece: Hashable = None  # smooth piece of the curve that they are derivatives on

    @staticmethod
    def blend(parts: Sequence[Linearization], weights: Array) -> Linearization:
        """Return what is the weighted sum of several in its Jacobian, and the first in all else."""

        def total(arrays: Sequence[Array]) -> Array:
            flat = weights @ np.array([array.ravel() for array in arrays])
            return flat.reshape(arrays[0].shape)

        first = parts[0]
        conditions = first.conditions
        if conditions.gradients is not None:
            gradients = [part.conditions.gradients for part in parts]
            conditions = Conditions(
                conditions.values, total([each for each in gradients if each is not None])
            )
        return replace(
            first,
            blocks=total([part.blocks for part in parts]),
            along=total([part.along for part in parts]),
            conditions=conditions,
        )

    @property
    def factors(self) -> Array:
        """What perturbations are multiplied by from node to node, shape (m, n, n)."""
        return self.blocks if self.settled is None else self.settled

    @staticmethod
    def blended_monodromies(parts: Sequence[Linearization], weights: Array) -> Array:
        """Return the watched matrices of several blends, shape (t, n, n).

        Shapes: weights (t, parts).
        """
        if parts[0].watched is None:
            return product_of(np.tensordot(weights, [part.few for part in parts], axes=1))
        return np.array([Linearization.blend(parts, row).monodromy for row in weights])

    @cached_property
    def few(self) -> Array:
        """Products of neighboring factors, so that there are no more than twelve, shape (q, n, n).

        They turn by little as well, and of few it is quicker to form weighted sums.
        """
        return next(part for part in _products(self.factors) if len(part) <= MANY)

    @cached_property
    def product(self) -> Array:
        """Product of the transition matrices, shape (n, n), in scaled states."""
        return product_of(self.factors)

    @cached_property
    def monodromy(self) -> Array:
        """The matrix whose eigenvalues are watched, in scaled states."""
        return self.product if self.watched is None else self.watched(self)

    @property
    def defect(self) -> Array:
        """What Newton's method brings to zero, shape (m n + d,)."""
        return defect_of(self.residual, self.conditions.values)

    @property
    def is_finite(self) -> bool:
        """Whether the flow and all its derivatives exist."""
        parts = [self.residual, self.blocks, self.along, self.conditions.values]
        if self.conditions.gradients is not None:
            parts.append(self.conditions.gradients)
        # A sum of squares is finite where all its terms are, and is cheaper than to ask each.
        return isfinite(sum(float(np.vdot(part, part)) for part in parts))

    @cached_property
    def jacobian(self) -> Array:
        """All derivatives, shape (m n + d, m n + k)."""
        m, n, k = self.along.shape
        size, width = m * n, m * n + k
        gradients = self.conditions.gradients
        matrix = np.zeros((size + (0 if gradients is None else len(gradients)), width))
        square, flat = matrix[:size, :size].reshape(m, n, m, n), matrix.ravel()
        np.einsum("jajb->jab", square)[:] = self.blocks
        flat[n : (size - n) * width : width + 1] -= 1.0
        flat[(size - n) * width : size * width : width + 1] -= 1.0  # the last ends at the first
        matrix[:size, size:] = self.along.reshape(size, k)
        if gradients is not None:
            matrix[size:] = gradients
        return matrix

    def bordered(self, row: Array) -> SquareMatrix:
        """Return the Jacobian with one more row.

        Block pattern for three segments (A transition matrix, b along, I identity, g gradients of
        the conditions)::

            [ A -I  .  b ]
            [ .  A -I  b ]
            [-I  .  A  b ]
            [ ---- g --- ]
            [ --- row -- ]

        Shapes: row (m n + k,).
        """
        if len(self.conditions.values) >= self.along.shape[2]:
            return LeastSquares(np.concatenate([self.jacobian, row[None]]))
        if len(row) <= ELIMINATION.large or len(self.blocks) == 1:  # no entry is zero
            return WholeMatrix(np.concatenate([self.jacobian, row[None]]))
        gradients = self.conditions.gradients
        lines = row[None] if gradients is None else np.vstack([gradients, row])
        few = 1 < len(self.blocks) <= MANY
        reached = Condensed.reach(self.blocks, self.along) if few else None
        if reached is None:
            return Sparse(self.blocks, self.along, lines)
        return Condensed(self.blocks, self.along, lines, reached)


def product_of(factors: Array) -> Array:
    """Return the products of matrices, the first on the right: (..., m, n, n) to (..., n, n)."""
    with np.errstate(over="ignore", invalid="ignore"):  # perturbations may outgrow all numbers
        *_, whole = _products(factors)
    return whole[..., 0, :, :]


def _products(factors: Array) -> Iterator[Array]:
    """Yield matrices, the products of two neighbors, of four, and so on to that of all."""
    yield factors
    while (count := factors.shape[-3]) > 1:  # pairs in one batch: three operations for eight
        if count % 2:
            first = factors[..., 1:2, :, :] @ factors[..., :1, :, :]
            factors = np.concatenate([first, factors[..., 2:, :, :]], axis=-3)
        else:
            factors = factors[..., 1::2, :, :] @ factors[..., ::2, :, :]
        yield factors


def defect_of(residual: Array, values: Array) -> Array:
    """Join mismatch and conditions to the vector that Newton's method brings to zero.

    Shapes: residual (m, n); values (d,).
    """
    flat = residual.ravel() / sqrt(len(residual))
    return np.concatenate([flat, values]) if len(values) else flat
