"""One point of a curve of orbits while it is being followed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.orbits.floquet import floquet_multipliers
from slipfold.orbits.newton import Correction
from slipfold.orbits.shooting import Shooting
from slipfold.orbits.test_functions import evaluate_tests

__all__ = ["Point", "corrected_point", "make_point"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Point:
    """An accepted orbit with what continuation needs to know of it.

    Parameters
    ----------
    z
        The unknown of the boundary-value problem.
    tangent
        Unit tangent of the branch, in the direction of travel.
    arclength
        Position on the branch.
    monodromy
        Monodromy matrix in scaled states, shape (n, n).
    multipliers
        Floquet multipliers, shape (n,).
    tests
        Functions that change sign at special points, by name. On a branch: ``PD``, ``NS``, ``LP``
        (the tangent's component along the parameter) and ``fold`` (zero at LP and BP alike).
    orientation
        Sign of the determinant of the Jacobian bordered by the tangent; it changes at a branch
        point and not at a fold. Zero where it is not known.
    residual
        Largest mismatch, in scaled states.
    growth
        Upper bound of the logarithms of the multipliers' moduli; infinite where none is known.
    volume
        Logarithm of that determinant's size; minus infinity where it is not known.
    """

    z: Array
    tangent: Array
    arclength: float
    monodromy: Array
    multipliers: NDArray[np.complex128]
    tests: dict[str, float]
    orientation: int
    residual: float
    growth: float = np.inf
    volume: float = -np.inf

    @property
    def unstable(self) -> int:
        """Number of multipliers outside the unit circle."""
        return int(np.count_nonzero(np.abs(self.multipliers) > 1))


def make_point(
    z: Array, tangent: Array, arclength: float, monodromy: Array, residual: float
) -> Point:
    """Return a point of a branch whose derivatives follow from those of another branch.

    Parameters
    ----------
    z
        The unknown of the boundary-value problem.
    tangent
        Unit tangent of the branch.
    arclength
        Position on the branch.
    monodromy
        Monodromy matrix in scaled states, shape (n, n).
    residual
        Largest mismatch, in scaled states.
    """
    multipliers = floquet_multipliers(monodromy)
    tests = {**evaluate_tests(multipliers), "LP": float(tangent[-1])}
    return Point(z, tangent, arclength, monodromy, multipliers, tests, 0, residual)


def corrected_point(curve: Shooting, correction: Correction, arclength: float) -> Point:
    """Turn a converged correction into a point.

    The tangent points along the row of the correction's constraint. The bordered determinant
    has the same sign for that row as for the tangent, so one matrix gives both.

    Parameters
    ----------
    curve
        The equations.
    correction
        A converged correction.
    arclength
        Position on the curve.
    """
    linearisation, bordered = correction.linearisation, correction.bordered
    assert linearisation is not None  # it converged
    assert bordered is not None
    tangent = bordered.tangent()
    monodromy = linearisation.monodromy
    multipliers = floquet_multipliers(monodromy)
    return Point(
        correction.z,
        tangent,
        arclength,
        monodromy,
        multipliers,
        curve.tests(correction.z, linearisation, multipliers, tangent),
        bordered.sign,
        correction.residual,
        curve.growth(linearisation) if np.abs(multipliers[0]) < 1 else np.inf,
        volume=bordered.volume,
    )
