"""Accelerations by forces: the inverse of a mass matrix, which may depend on parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.quantities import Expression, Symbols
from slipfold.models.structures.component import total, weighted_sum
from slipfold.models.structures.matrices import MATRICES, is_diagonal, lowest_modes


class Inertia:
    r"""A mass matrix :math:`M + \sum_k g_k M_k` with coefficients that depend on parameters.

    Coordinates in which M is the identity and each :math:`M_k` diagonal make its inverse a division
    by :math:`1 + \sum_k g_k d_k`. Raises `InputError` if there are none.

    Shapes: mass (r, r), likewise each of the parts, which have the names of their coefficients.
    """

    def __init__(self, mass: Array, parts: tuple[tuple[str, Array], ...]) -> None:
        self.mass, self.parts = mass, parts
        if not parts:
            return
        # A sum with other weights for each has no equal values where one of them has none.
        mixed = sum(matrix * np.sqrt(number) for number, (_, matrix) in enumerate(parts, 2))
        _, shapes = lowest_modes(np.asarray(mixed), mass)
        self.shapes = shapes / np.sqrt(np.sum(shapes * (mass @ shapes), axis=0))
        self.shares = np.array([self._share(matrix) for _, matrix in parts])  # d, shape (k, r)

    def _share(self, matrix: Array) -> Array:
        """Return the diagonal of a part in these coordinates."""
        whole = self.shapes.T @ matrix @ self.shapes
        share = np.diag(whole).copy()
        largest = np.abs(whole).max(initial=0.0)
        if np.abs(whole - np.diag(share)).max(initial=0.0) > MATRICES.asymmetry * largest:
            raise InputError(
                "the matrices of M are not diagonal in the same coordinates, so its inverse is no "
                "short formula; give all that depends on parameters one formula, or a diagonal M"
            )
        share[np.abs(share) < len(share) * MATRICES.rounding * largest] = 0.0
        return share

    def over(self, matrix: Array) -> Array:
        """Return accelerations by forces, without entries that are rounding errors.

        With parts these are the forces on its coordinates, see `accelerations`.

        Shapes: matrix (r, m).
        """
        if self.parts:
            result = self.shapes.T @ matrix
        elif matrix is self.mass:
            return np.eye(len(matrix))
        elif is_diagonal(self.mass):
            return matrix / np.diag(self.mass)[:, None]
        else:
            result = np.asarray(np.linalg.solve(self.mass, matrix), dtype=float)
        largest = np.abs(result).max(axis=1, keepdims=True, initial=0.0)
        result[np.abs(result) < MATRICES.rounding * largest] = 0.0
        return result

    def coefficients(self, factors: Mapping[str, Any]) -> dict[str, Expression]:
        """Return the mobility of each coordinate that a part moves, by the factors of the parts."""
        if not self.parts:
            return {}
        added = {
            place: total(weighted_sum(share, [factors[key] for key, _ in self.parts]))
            for place, share in enumerate(self.shares.T)
            if share.any()
        }
        return {_key(place): 1.0 / (1.0 + value) for place, value in added.items()}

    def accelerations(self, terms: list[list[Expression]], c: Symbols) -> list[Expression]:
        """Return the accelerations by the terms of what `over` returns."""
        sums = [total(parts) for parts in terms]
        if not self.parts:
            return sums
        sums = [one * c[_key(at)] if _key(at) in c else one for at, one in enumerate(sums)]
        return [total(weighted_sum(row, sums)) for row in self.shapes]

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse values of the factors at which a mass is not positive."""
        if not self.parts:
            return
        factors = np.array([values[key] for key, _ in self.parts])
        if (1.0 + factors @ self.shares).min() <= MATRICES.singular:
            raise InputError(
                "M is not positive definite at these values of its parameters; raise the mass"
            )


def _key(place: int) -> str:
    return f"mobility {place + 1}"
