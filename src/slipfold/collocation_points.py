"""Gauss-Legendre and Radau points on an interval and the polynomials through them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.polynomial import Polynomial, legendre

from slipfold.arrays import Array


@dataclass(frozen=True, eq=False)
class CollocationPoints:
    r"""Points of the interval from 0 to 1 at which polynomials meet equations.

    A polynomial of degree m - 1 through values at these points has the Legendre coefficients
    :math:`\sum_k t_{jk} F_k`.

    >>> gauss = gauss_points(2)
    >>> gauss.points.round(6)
    array([0.211325, 0.788675])
    >>> gauss.integrals(np.ones(1)).round(6)     # to the end of the interval: the weights
    array([[0.5, 0.5]])
    """

    points: Array  # ascending, shape (m,)
    weights: Array  # of the quadrature, shape (m,)
    transform: Array  # from values at the points to Legendre coefficients, shape (m, m)

    def integrals(self, ends: Array) -> Array:
        """Return the weights that integrate the polynomial from 0 to each end.

        Shapes: ends (q,); returns (q, m).
        """
        m = len(self.points)
        basis = legendre.legvander(2 * np.asarray(ends) - 1, m)
        grown = np.empty((len(basis), m))
        grown[:, 0] = ends
        grown[:, 1:] = (basis[:, 2:] - basis[:, :-2]) / (2 * (2 * np.arange(1, m) + 1))
        return np.asarray(grown @ self.transform)

    @cached_property
    def powers(self) -> Array:
        """The same integrals as coefficients of powers of the end, shape (m + 1, m)."""
        place = Polynomial([-1.0, 2.0])
        grown = [Polynomial(legendre.leg2poly(item))(place).integ() for item in self.transform.T]
        result = np.zeros((len(self.points) + 1, len(self.points)))
        for column, item in enumerate(grown):
            result[: len(item.coef), column] = item.coef
        return result

    @cached_property
    def inner(self) -> Array:
        """Weights that integrate from 0 to each of the points, shape (m, m)."""
        return self.integrals(self.points)

    @cached_property
    def outer(self) -> Array:
        """The inverse of `inner`: slopes from what was gained at the points, shape (m, m)."""
        return np.asarray(np.linalg.inv(self.inner))

    @property
    def damps(self) -> bool:
        """Whether the last point is the end: what decays, however fast, then does so here too."""
        return bool(self.points[-1] == 1.0)

    @property
    def highest(self) -> Array:
        """Weights that give derivative m - 1 of the polynomial, which is constant, shape (m,)."""
        m = len(self.points)
        factor = math.factorial(2 * m - 2) / math.factorial(m - 1)
        return factor * self.transform[-1]

    @cached_property
    def error(self) -> float:
        """Error inside an interval of length one, over the derivative m + 1 of what is sought."""
        places = np.linspace(0, 1, 201)
        m = len(self.points)
        # x' = t^m / m!, whose derivative m is one, against the polynomial through its values.
        exact = places ** (m + 1) / math.factorial(m + 1)
        found = self.integrals(places) @ (self.points**m / math.factorial(m))
        return float(np.abs(found - exact).max())


@cache
def gauss_points(count: int) -> CollocationPoints:
    """Return the Gauss points, at which the quadrature is exact to degree 2 m - 1."""
    points, weights = legendre.leggauss(count)
    values = legendre.legvander(points, count - 1).T.astype(np.float64)
    # Quadrature of the products with Legendre polynomials is exact.
    transform = values * weights * (np.arange(count)[:, None] + 0.5)
    return CollocationPoints((points + 1) / 2, weights / 2, transform)


@cache
def radau_points(count: int) -> CollocationPoints:
    """Return the right Radau points, exact to degree 2 m - 2; the last of them is the end.

    >>> radau_points(2).points.round(6)
    array([0.333333, 1.      ])
    """
    series = np.append(np.zeros(count - 1), [-1.0, 1.0])  # P_m - P_{m-1}
    slope = legendre.legder(series)
    points = np.sort(legendre.legroots(series))
    for _ in range(2):  # to the last digit
        points -= legendre.legval(points, series) / legendre.legval(points, slope)
    points[-1] = 1.0
    transform = np.linalg.inv(legendre.legvander(points, count - 1).astype(np.float64))
    weights = transform[0].copy()  # the integral is the mean, the first coefficient
    return CollocationPoints((points + 1) / 2, weights, transform)
