"""Whether responses are stable all the way from the first value of a parameter to another one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.continuation.unseen import TOUCH

SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Where on the way the response is looked at; the last is its end."""

MARGIN = 100.0
"""Errors of multipliers over those of the orbit, with a reserve."""

BETWEEN = np.linspace(0.0, 1.0, 41)


@dataclass(frozen=True, eq=False)
class Segments:
    """Responses from the first value of a parameter to where their stable part ends."""

    ends: Array  # values of the parameter there, shape (m,)
    paths: Array  # states at phase zero at `SHARES` of the way, shape (m, len(SHARES), n)

    def of(self, some: NDArray[np.bool_] | NDArray[np.int64]) -> Segments:
        """Return some of them."""
        return Segments(self.ends[some], self.paths[some])


def find_doubts(
    multipliers: NDArray[np.complex128], moved: Array, doubling: bool
) -> NDArray[np.str_]:
    r"""Return why each response might be unstable before its end; empty where it is stable.

    All multipliers must be inside the unit circle, but for the one at -1 where a response ends at
    its period doubling. Between the orbits that are known the test functions

    .. math:: \prod (1 + \mu_i), \quad \prod (1 - \mu_i), \quad \prod_{i<j} (1 - \mu_i \mu_j)

    are interpolated: two zeros on the way show as a dip. The first, zero at a period
    doubling, is divided by the distance from the end there.

    Shapes: multipliers (m, len(SHARES), n); moved (m, len(SHARES)).
    """
    doubts = np.full(len(multipliers), "", dtype="<U40")
    with np.errstate(invalid="ignore"):
        doubts[_has_dip(multipliers, doubling)] = "a test function dips on the way"
        modulus = np.abs(multipliers)
        if doubling:
            critical = np.abs(multipliers[:, -1] + 1).argmin(axis=1)
            modulus[np.arange(len(modulus)), -1, critical] = 0.0
        outside = ~(modulus.max(axis=2) < 1 - MARGIN * moved).all(axis=1)
        doubts[outside] = "a multiplier is outside the unit circle"
    doubts[~np.isfinite(moved).all(axis=1)] = "an orbit on the way was not found"
    return doubts


def shortened(paths: Array, shares: Array) -> Array:
    """Return the states on the first part of each path, by interpolation.

    Shapes: paths (m, len(SHARES), n); shares (m,).
    """
    at = shares[:, None] * np.array(SHARES)
    weights = _weights(len(SHARES), at.ravel()).reshape(len(SHARES), *at.shape)
    return np.einsum("imj,min->mjn", weights, paths)


def _has_dip(multipliers: NDArray[np.complex128], doubling: bool) -> NDArray[np.bool_]:
    first, second = np.triu_indices(multipliers.shape[2], k=1)
    products = 1 - multipliers[:, :, first] * multipliers[:, :, second]
    flip = (1 + multipliers).prod(axis=2).real
    curves = [(1 - multipliers).prod(axis=2).real, products.prod(axis=2).real]
    curves += [flip[:, :-1] / (1 - np.array(SHARES[:-1]))] if doubling else [flip]
    dips = [
        (curve @ _between(curve.shape[1])).min(axis=1) < TOUCH * curve[:, [0, -1]].min(axis=1)
        for curve in curves
    ]
    return np.any(dips, axis=0)


@cache
def _between(count: int) -> Array:
    """Weights that carry values at the first shares to `BETWEEN`."""
    return _weights(count, BETWEEN)


def _weights(count: int, at: Array) -> Array:
    """Weights of the polynomial through the first shares (Lagrange), shape (count, len(at))."""
    nodes = np.array(SHARES[:count])
    weights = np.ones((count, len(at)))
    for i, node in enumerate(nodes):
        for other in np.delete(nodes, i):
            weights[i] *= (at - other) / (node - other)
    return weights
