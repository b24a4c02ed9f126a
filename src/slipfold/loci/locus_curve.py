"""A locus as a smooth line in its plane, between the few points it was followed at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.loci.locus import Locus

PIECES = 12
"""Straight pieces between neighbouring points."""


@dataclass(frozen=True, eq=False)
class LocusCurve:
    """Values of both parameters as smooth functions of the arclength."""

    knots: Array  # arclength of the points of the locus, shape (n,)
    values: Callable[[Array], Array]  # callable on arclengths of shape (k,), gives shape (k, 2)

    def between(self, index: int) -> Array:
        """Return the line from one point of the locus to the next, shape (k, 2)."""
        s = np.linspace(self.knots[index], self.knots[index + 1], PIECES + 1)
        return np.asarray(self.values(s))


def locus_curve(locus: Locus) -> LocusCurve:
    """Interpolate a locus.

    In the arclength of all unknowns the parameters are smooth even at a cusp of the locus.
    """
    from scipy.interpolate import CubicSpline, interp1d

    if len(locus) < 3:
        values = interp1d(locus.arclength, locus.values, axis=0)
    else:
        values = CubicSpline(locus.arclength, locus.values)
    return LocusCurve(locus.arclength, values)
