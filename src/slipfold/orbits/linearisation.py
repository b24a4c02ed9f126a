"""Derivatives of a boundary-value problem at an orbit, and its Jacobian with one more row."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache, cached_property, reduce

import numpy as np
from numpy.typing import NDArray

__all__ = ["Bordered", "Conditions", "Linearisation"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Conditions:
    """Equations besides those of the orbit, e.g. that it is at a bifurcation.

    Parameters
    ----------
    values
        How far each is from being met, shape (d,).
    gradients
        Their derivatives with respect to the unknown, shape (d, m n + k).
    carried
        Perturbations along which second derivatives of the segments are known, shape (r, m, n).
    bent
        Those second derivatives, ``D^2 phi_j [v_j, .]``, shape (r, m, n, n).
    """

    values: Array = field(default_factory=lambda: np.empty(0))
    gradients: Array | None = None
    carried: Array | None = None
    bent: Array | None = None


NO_CONDITIONS = Conditions()


@dataclass(frozen=True, eq=False)
class Linearisation:
    """Mismatch of an orbit and its derivatives, in scaled variables.

    Parameters
    ----------
    residual
        Shape (m, n), in scaled states.
    blocks
        Transition matrices of the segments, shape (m, n, n).
    along
        Derivatives of the segments' ends with respect to the k scaled parameters, shape (m, n, k).
    conditions
        Further equations.
    """

    residual: Array
    blocks: Array
    along: Array
    conditions: Conditions = NO_CONDITIONS

    @cached_property
    def product(self) -> Array:
        """Product of the transition matrices, shape (n, n), in scaled states."""
        return reduce(lambda product, block: block @ product, self.blocks)

    @property
    def monodromy(self) -> Array:
        """The matrix whose eigenvalues are watched, in scaled states."""
        return self.product

    @property
    def defect(self) -> Array:
        """What Newton's method brings to zero, shape (m n + d,)."""
        return defect_of(self.residual, self.conditions.values)

    def bordered(self, row: Array) -> Bordered:
        """Return the Jacobian with one more row.

        Block pattern for three segments (A transition matrix, b along, I identity, g gradients of
        the conditions)::

            [ A -I  .  b ]
            [ .  A -I  b ]
            [-I  .  A  b ]
            [ ---- g --- ]
            [ --- row -- ]

        Parameters
        ----------
        row
            Shape (m n + k,). There are k - 1 conditions.
        """
        m, n, k = self.along.shape
        size = m * n
        matrix = np.zeros((size + k, size + k))
        matrix.ravel()[_block_places(m, n, k)] = self.blocks.ravel()
        matrix[np.arange(size), (np.arange(size) + n) % size] -= 1.0
        matrix[:size, size:] = self.along.reshape(size, k)
        if self.conditions.gradients is not None:
            matrix[size:-1] = self.conditions.gradients
        matrix[-1] = row
        return Bordered(matrix)


def defect_of(residual: Array, values: Array) -> Array:
    """Join mismatch and conditions to the vector that Newton's method brings to zero.

    Parameters
    ----------
    residual
        Shape (m, n), in scaled states.
    values
        Of the conditions, shape (d,).
    """
    flat = residual.ravel() / np.sqrt(len(residual))
    return np.concatenate([flat, values]) if len(values) else flat


@cache
def _block_places(m: int, n: int, k: int) -> NDArray[np.int64]:
    """Flat places of the diagonal blocks in a bordered matrix."""
    size = m * n + k
    inside = np.arange(n)[:, None] * size + np.arange(n)[None, :]
    return (np.arange(m)[:, None, None] * n * (size + 1) + inside).ravel()


@dataclass(frozen=True, eq=False)
class Bordered:
    """Jacobian of an orbit with one more row, square.

    Parameters
    ----------
    matrix
        Shape (m n + k, m n + k).
    """

    matrix: Array

    @cached_property
    def inverse(self) -> Array:
        """Inverse, NaN if the matrix is singular.

        It is small and serves several right-hand sides; what rounding adds Newton's method
        removes.
        """
        try:
            return np.asarray(np.linalg.inv(self.matrix), dtype=float)
        except np.linalg.LinAlgError:
            return np.full_like(self.matrix, np.nan)

    @cached_property
    def _determinant(self) -> tuple[float, float]:
        sign, logarithm = np.linalg.slogdet(self.matrix)
        return float(sign), float(logarithm)

    @property
    def sign(self) -> int:
        """Sign of the determinant."""
        return int(self._determinant[0])

    @property
    def volume(self) -> float:
        """Logarithm of the determinant's size were the last row the tangent.

        A row r and the tangent t give determinants in the ratio r t, and the last column of the
        inverse is t/(r t).
        """
        return self._determinant[1] + float(np.log(np.linalg.norm(self.inverse[:, -1])))

    def tangent(self) -> Array:
        """Return the unit vector of the kernel that the last row leaves, along that row."""
        tangent = self.inverse[:, -1]
        return tangent / np.linalg.norm(tangent)
