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

    @property
    def is_finite(self) -> bool:
        """Whether the flow and all its derivatives exist."""
        parts = (self.residual, self.blocks, self.along, self.conditions.values)
        gradients = self.conditions.gradients
        known = gradients is None or bool(np.isfinite(gradients).all())
        return known and all(bool(np.isfinite(part).all()) for part in parts)

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
        return Bordered(self, row)


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
    """Jacobian of an orbit with one more row, square of size m n + k.

    The unknowns of all nodes but the first are eliminated by way of the transition matrices, so
    that systems of size n + k are solved: small enough that linear algebra does not share them out
    among threads, which costs far more than it gains. What rounding adds, magnified by the
    multipliers, Newton's method removes.

    Parameters
    ----------
    linearisation
        The derivatives.
    row
        The last row, shape (m n + k,).
    """

    linearisation: Linearisation
    row: Array

    @cached_property
    def matrix(self) -> Array:
        """The whole matrix."""
        part = self.linearisation
        m, n, k = part.along.shape
        size = m * n
        matrix = np.zeros((size + k, size + k))
        matrix.ravel()[_block_places(m, n, k)] = part.blocks.ravel()
        matrix[np.arange(size), (np.arange(size) + n) % size] -= 1.0
        matrix[:size, size:] = part.along.reshape(size, k)
        matrix[size:] = self._lines
        return matrix

    @cached_property
    def _lines(self) -> Array:
        """The rows below those of the segments, shape (k, m n + k)."""
        gradients = self.linearisation.conditions.gradients
        return self.row[None] if gradients is None else np.vstack([gradients, self.row])

    @cached_property
    def _carried(self) -> Array:
        """Nodes, then parameters, by the first node and the parameters: shape (m n + k, n + k)."""
        part = self.linearisation
        m, n, k = part.along.shape
        carried = np.zeros((m * n + k, n + k))
        carried[m * n :, n:] = np.eye(k)
        nodes = carried[: m * n].reshape(m, n, n + k)
        nodes[0, :, :n] = np.eye(n)
        for j in range(m - 1):
            np.matmul(part.blocks[j], nodes[j], out=nodes[j + 1])
            nodes[j + 1, :, n:] += part.along[j]
        return carried

    @cached_property
    def _condensed(self) -> Array:
        """What is left for the first node and the parameters, shape (n + k, n + k).

        Its determinant is that of the whole matrix: the pivots are -1, and as many columns change
        places.
        """
        part = self.linearisation
        m, n, _ = part.along.shape
        last = part.blocks[-1] @ self._carried[(m - 1) * n : m * n]
        last[:, n:] += part.along[-1]
        last[:, :n] -= np.eye(n)
        return np.vstack([last, self._lines @ self._carried])

    @cached_property
    def _inverse(self) -> Array:
        """Inverse of what is left, NaN if it is singular."""
        try:
            return np.asarray(np.linalg.inv(self._condensed), dtype=float)
        except np.linalg.LinAlgError:
            return np.full_like(self._condensed, np.nan)

    def solve(self, right: Array) -> Array:
        """Return the solution for a right-hand side, NaN if the matrix is singular.

        Parameters
        ----------
        right
            Shape (m n + k,).
        """
        part = self.linearisation
        m, n, k = part.along.shape
        alone = np.zeros(m * n + k)  # what the right-hand side does with the first node held
        nodes, sides = alone[: m * n].reshape(m, n), right[: m * n].reshape(m, n)
        for j in range(m - 1):
            nodes[j + 1] = part.blocks[j] @ nodes[j] - sides[j]
        last = sides[-1] - part.blocks[-1] @ nodes[-1]
        left = np.concatenate([last, right[m * n :] - self._lines @ alone])
        return alone + self._carried @ (self._inverse @ left)

    @cached_property
    def _kernel(self) -> Array:
        """Last column of the whole inverse."""
        return self._carried @ self._inverse[:, -1]

    @cached_property
    def _determinant(self) -> tuple[float, float]:
        sign, logarithm = np.linalg.slogdet(self._condensed)
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
        return self._determinant[1] + float(np.log(np.linalg.norm(self._kernel)))

    def tangent(self) -> Array:
        """Return the unit vector of the kernel that the last row leaves, along that row."""
        return self._kernel / np.linalg.norm(self._kernel)
