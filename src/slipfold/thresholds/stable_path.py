"""Whether responses are stable from the first value of a parameter to another one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Indices, Mask
from slipfold.continuation.interpolation import polynomial_weights
from slipfold.continuation.unseen import TOUCH

FRACTIONS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Fractions of the way at which the response is known; the last is its end."""

MARGIN = 100.0
"""Errors of multipliers over those of the orbit, with a reserve."""


@dataclass(frozen=True, eq=False)
class Paths:
    """Responses from the first value of a parameter to where their stable part ends."""

    ends: Array  # values of the parameter there, shape (m,)
    states: Array  # states at phase zero at `FRACTIONS` of the way, shape (m, len(FRACTIONS), n)
    doubles: Mask  # whether it ends at a period doubling, or at the end of the span; shape (m,)

    def rows(self, some: Indices) -> Paths:
        """Return a subset of them."""
        return Paths(self.ends[some], self.states[some], self.doubles[some])


def find_doubts(
    multipliers: NDArray[np.complex128], moved: Array, doubles: Mask
) -> NDArray[np.str_]:
    r"""Return why each response might be unstable before its end; empty where it is stable.

    All multipliers must be inside the unit circle, except for the one at -1 where a response ends
    at its period doubling. Between the known orbits the test functions

    .. math:: \prod (1 + \mu_i), \quad \prod (1 - \mu_i), \quad \prod_{i<j} (1 - \mu_i \mu_j)

    are interpolated: two zeros on the way show as a dip. The first, zero at a period doubling, is
    divided by the distance from the end there.

    Shapes: multipliers (m, len(FRACTIONS), n); moved (m, len(FRACTIONS)); doubles (m,).
    """
    doubts = np.full(len(multipliers), "", dtype="<U40")
    first, second = np.triu_indices(multipliers.shape[2], k=1)
    with np.errstate(invalid="ignore"):
        products = 1 - multipliers[:, :, first] * multipliers[:, :, second]
        flip = (1 + multipliers).prod(axis=2).real
        dips = _dips((1 - multipliers).prod(axis=2).real) | _dips(products.prod(axis=2).real)
        before_end = flip[:, :-1] / (1 - np.array(FRACTIONS[:-1]))
        doubts[dips | np.where(doubles, _dips(before_end), _dips(flip))] = (
            "a test function dips on the way"
        )
        modulus = np.abs(multipliers)
        critical = np.abs(multipliers[doubles, -1] + 1).argmin(axis=1)
        modulus[np.flatnonzero(doubles), -1, critical] = 0.0
        outside = ~(modulus.max(axis=2) < 1 - MARGIN * moved).all(axis=1)
        doubts[outside] = "a multiplier is outside the unit circle"
    doubts[~np.isfinite(moved).all(axis=1)] = "an orbit on the way was not found"
    return doubts


def _dips(values: Array) -> Mask:
    """Return where the polynomial through values at the first fractions dips, (m, k) to (m,)."""
    known, grid = np.array(FRACTIONS[: values.shape[1]]), np.linspace(0.0, 1.0, 41)
    curve = values @ polynomial_weights(known, grid).T
    return np.asarray(curve.min(axis=1) < TOUCH * values[:, [0, -1]].min(axis=1))
