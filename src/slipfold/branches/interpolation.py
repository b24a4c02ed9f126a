"""Branches between and beyond their points: polynomials through values and tangents."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.point import Point

__all__ = ["arc_between", "hermite", "polynomial", "well_spaced"]

Array = NDArray[np.float64]

POINTS = 3
"""Points a branch is extrapolated from: more gain little and overshoot when steps change."""


SPACING = 0.2
"""Least spacing of interpolated points, as a share of their distance from where it is used."""


def arc_between(a: Point, b: Point) -> float:
    """Return the arclength between two points of a branch, exact for a circle.

    Parameters
    ----------
    a, b
        The points; their tangents point the same way along the branch.
    """
    chord = float(np.linalg.norm(b.z - a.z))
    turn = float(np.arccos(np.clip(a.tangent @ b.tangent, -1.0, 1.0)))
    return chord if turn < 1e-4 else chord * 0.5 * turn / np.sin(0.5 * turn)


def well_spaced(known: Sequence[Point], low: float, high: float, count: int) -> list[Point]:
    """Choose points near an interval for interpolation, none too close to another.

    Parameters
    ----------
    known
        Points of the branch.
    low, high
        The interval in arclength; a single place if they are equal.
    count
        Number of points wanted.
    """

    def distance(point: Point) -> float:
        return max(abs(point.arclength - low), abs(point.arclength - high))

    chosen: list[Point] = []
    for point in sorted(known, key=distance):
        # Interpolation magnifies rounding by the ratio of distance to spacing, to some power.
        gap = SPACING * distance(point)
        if all(abs(point.arclength - other.arclength) > gap for other in chosen):
            chosen.append(point)
        if len(chosen) == count:
            break
    return chosen


def hermite(points: Sequence[Point], arclength: float) -> tuple[Array, Array]:
    """Evaluate the polynomial through points and tangents, and its derivative.

    Parameters
    ----------
    points
        Up to three points of different arclength.
    arclength
        Where to evaluate, inside or outside.

    Returns
    -------
    z, tangent : ndarray
        Value and unit derivative.
    """
    where = np.array([point.arclength for point in points])
    scale = max(np.ptp(where), abs(arclength - where[-1]), 1e-300)
    x = (where - arclength) / scale
    powers = np.arange(2 * len(points))
    values = x[:, None] ** powers
    slopes = np.zeros_like(values)
    slopes[:, 1:] = powers[1:] * values[:, :-1]
    # The polynomial's constant and linear coefficient are value and derivative at the target.
    matrix = np.concatenate([values, slopes])
    wanted = np.zeros((len(powers), 2))
    wanted[0, 0], wanted[1, 1] = 1.0, 1.0
    weights = np.linalg.solve(matrix.T, wanted)
    data = np.array([point.z for point in points] + [scale * point.tangent for point in points])
    z, slope = weights.T @ data
    return z, slope / np.linalg.norm(slope)


def polynomial(where: Array, values: Array, targets: Array) -> Array:
    """Evaluate Lagrange's polynomial.

    Parameters
    ----------
    where
        Distinct places, shape (k,).
    values
        Values there, shape (k,) or (k, m).
    targets
        Where to evaluate, shape (t,).

    Returns
    -------
    ndarray, shape (t,) or (t, m)
        Values of the polynomial.
    """
    difference = where[:, None] - where[None, :]
    np.fill_diagonal(difference, 1.0)
    ratios = (targets[:, None, None] - where[None, None, :]) / difference
    ratios[:, np.arange(len(where)), np.arange(len(where))] = 1.0
    return ratios.prod(axis=2) @ values
