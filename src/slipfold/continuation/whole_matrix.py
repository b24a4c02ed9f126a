"""A Jacobian with one more row, and what is asked of it."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from functools import cached_property
from math import log

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.newton import length_of


class SquareMatrix(ABC):
    """A square matrix that serves solutions, tangent and determinant."""

    @property
    @abstractmethod
    def matrix(self) -> Array:
        """The whole matrix."""

    @abstractmethod
    def solve(self, right: Array) -> Array:
        """Return the solution for a right-hand side, NaN if the matrix is singular."""

    def solve_transposed(self, right: Array) -> Array:
        """Return the solution with the transposed matrix."""
        return np.asarray(np.linalg.solve(self.matrix.T, right), dtype=float)

    @property
    @abstractmethod
    def _kernel(self) -> Array:
        """Last column of the inverse."""

    @property
    @abstractmethod
    def _determinant(self) -> tuple[float, float]:
        """Sign and logarithm of the determinant."""

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
        return self._determinant[1] + log(length_of(self._kernel))

    def tangent(self) -> Array:
        """Return the unit vector of the kernel that the last row leaves, along that row."""
        kernel = self._kernel
        return np.asarray(kernel / length_of(kernel))


class WholeMatrix(SquareMatrix):
    """A full matrix, inverted once."""

    def __init__(self, matrix: Array) -> None:
        self._matrix = matrix

    @property
    def matrix(self) -> Array:
        """The whole matrix."""
        return self._matrix

    @cached_property
    def _inverse(self) -> Array:
        """Inverse, NaN if there is none."""
        try:
            return np.asarray(np.linalg.inv(self.matrix), dtype=float)
        except np.linalg.LinAlgError:
            return np.full_like(self.matrix, np.nan)

    def solve(self, right: Array) -> Array:
        """Return the solution for a right-hand side, NaN if the matrix is singular."""
        return self._inverse @ right

    @property
    def _kernel(self) -> Array:
        return self._inverse[:, -1]

    @cached_property
    def _determinant(self) -> tuple[float, float]:
        sign, logarithm = np.linalg.slogdet(self.matrix)
        return float(sign), float(logarithm)


class FactoredMatrix(SquareMatrix):
    """A full matrix of hundreds of unknowns, factored once, in a third of an inverse's time."""

    def __init__(self, matrix: Array) -> None:
        self._matrix = matrix

    @property
    def matrix(self) -> Array:
        """The whole matrix."""
        return self._matrix

    @cached_property
    def _factors(self) -> tuple[Array, Array]:
        from scipy.linalg import lu_factor

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a singular matrix solutions are not finite
            found: tuple[Array, Array] = lu_factor(self._matrix, check_finite=False)
        return found

    def solve(self, right: Array) -> Array:
        """Return the solution for a right-hand side, not finite if the matrix is singular."""
        from scipy.linalg import lu_solve

        return np.asarray(lu_solve(self._factors, right, check_finite=False))

    @cached_property
    def _kernel(self) -> Array:
        return self.solve(np.eye(1, len(self._matrix), len(self._matrix) - 1)[0])

    @cached_property
    def _determinant(self) -> tuple[float, float]:
        factors, pivots = self._factors
        diagonal = factors.diagonal()
        swaps = np.count_nonzero(pivots != np.arange(len(pivots)))
        sign = np.sign(diagonal).prod() * (-1) ** swaps
        with np.errstate(divide="ignore"):
            return float(sign), float(np.log(np.abs(diagonal)).sum())


class LeastSquares(WholeMatrix):
    """A full matrix of more equations than unknowns, all of which a solution meets.

    Newton's method with the pseudo-inverse converges to it as with an inverse. There is no
    determinant.
    """

    @cached_property
    def _inverse(self) -> Array:
        """Pseudo-inverse, NaN if there is none."""
        try:
            return np.asarray(np.linalg.pinv(self.matrix), dtype=float)
        except np.linalg.LinAlgError:
            return np.full_like(self.matrix.T, np.nan)

    def solve_transposed(self, right: Array) -> Array:
        """Return the least solution with the transposed matrix."""
        return self._inverse.T @ right

    @cached_property
    def _determinant(self) -> tuple[float, float]:
        return 0.0, 0.0
