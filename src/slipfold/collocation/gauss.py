"""Gauss-Legendre points on an interval and the polynomials through them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

__all__ = ["GaussPoints", "gauss_points"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GaussPoints:
    r"""The m Gauss points of the interval from 0 to 1.

    A polynomial of degree m - 1 through values at these points has, by the exactness of Gauss
    quadrature, the Legendre coefficients :math:`(2 j + 1) \sum_k b_k P_j(c_k) F_k`.

    >>> gauss = gauss_points(2)
    >>> gauss.points.round(6)
    array([0.211325, 0.788675])
    >>> gauss.integrals(np.ones(1)).round(6)     # to the end of the interval: the weights
    array([[0.5, 0.5]])
    """

    points: Array  # ascending, shape (m,)
    weights: Array  # of the quadrature, shape (m,)
    values: Array  # Legendre polynomials ``P_j(c_k)`` of the interval, shape (m, m)

    def integrals(self, ends: Array) -> Array:
        """Return the weights that integrate the polynomial from 0 to each end.

        Shapes: ends (q,); returns (q, m).
        """
        m = len(self.points)
        basis = legendre.legvander(2 * np.asarray(ends) - 1, m)
        grown = np.empty((len(basis), m))
        grown[:, 0] = ends
        grown[:, 1:] = (basis[:, 2:] - basis[:, :-2]) / 2
        return np.asarray(grown @ (self.values * self.weights))

    @cached_property
    def inner(self) -> Array:
        """Weights that integrate from 0 to each of the points, shape (m, m)."""
        return self.integrals(self.points)

    @property
    def highest(self) -> Array:
        """Weights that give derivative m - 1 of the polynomial, which is constant, shape (m,)."""
        m = len(self.points)
        factor = (2 * m - 1) * math.factorial(2 * m - 2) / math.factorial(m - 1)
        return factor * self.weights * self.values[-1]


@cache
def gauss_points(count: int) -> GaussPoints:
    """Return the Gauss points of the interval from 0 to 1."""
    points, weights = legendre.leggauss(count)
    values: Array = legendre.legvander(points, count - 1).T.astype(np.float64)
    return GaussPoints((points + 1) / 2, weights / 2, values)
