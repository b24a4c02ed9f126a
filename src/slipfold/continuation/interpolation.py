"""Interpolation and extrapolation of curves: polynomials through values and tangents.

An arclength is a number for one curve, or an array with one number for each of many curves.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import acos, sin
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.curve import Curve, P, Point
from slipfold.continuation.newton import Linearized, length_of

POINTS = 3
"""Number of points from which a curve is extrapolated. More points gain little in accuracy and
overshoot where step lengths change."""


SPACING = 0.2
"""Minimum spacing of interpolated points, as a fraction of their distance from the target."""


def arc_between(a: Point, b: Point) -> float:
    """Return the arclength between two points of a curve, exact for a circle."""
    chord, turn = length_of(b.z - a.z), acos(min(max(float(a.tangent @ b.tangent), -1.0), 1.0))
    return chord if turn < 1e-4 else chord * 0.5 * turn / sin(0.5 * turn)


def arcs(difference: Array, before: Array, after: Array) -> tuple[Array, Array]:
    """Return arclengths and angles between two points of each of many curves.

    Shapes: differences and unit tangents (k, u); returns (k,), (k,).
    """
    turn = angles_between(before, after)
    half = 0.5 * turn
    bent = np.divide(half, np.sin(half), out=np.ones_like(half), where=~(turn < 1e-4))
    return lengths_of(difference) * bent, turn


def angles_between(first: Array, second: Array) -> Array:
    """Return the angle between the unit vectors of each row."""
    cosine = np.add.reduce(first * second, axis=1)
    return np.arccos(np.minimum(np.maximum(cosine, -1.0), 1.0))


def lengths_of(vectors: Array) -> Array:
    """Return the Euclidean length of each row."""
    return np.sqrt(np.add.reduce(vectors * vectors, axis=1))


def well_spaced(history: Sequence[P], low: float, high: float, count: int) -> list[P]:
    """Choose points near an interval for interpolation, with a minimum spacing."""
    where = [point.arclength for point in history]
    away = [max(abs(s - low), abs(s - high)) for s in where]
    chosen: list[int] = []
    for i in sorted(range(len(away)), key=away.__getitem__):
        # Interpolation magnifies rounding by a power of the ratio of distance to spacing.
        gap = SPACING * away[i]
        if all(abs(where[i] - where[j]) > gap for j in chosen):
            chosen.append(i)
        if len(chosen) == count:
            break
    return [history[i] for i in chosen]


def hermite(points: Sequence[Point], arclength: float) -> tuple[Array, Array]:
    """Evaluate the polynomial through points and tangents, and its unit tangent."""
    parts = zip(*((point.arclength, point.z, point.tangent) for point in points), strict=True)
    where, values, slopes = (np.array([part]) for part in parts)
    (value,), (slope,) = hermite_each(where, values, slopes, np.array([arclength]))
    return value, slope


def hermite_each(where: Array, values: Array, slopes: Array, target: Array) -> tuple[Array, Array]:
    """Evaluate such polynomials of k curves: where (k, c), slopes (k, c, u) to (k, u), (k, u)."""
    weights = np.array(_hermite_weights(*_by_point(where, target)))
    # Memory order determines the order of summation, which must not depend on the number of curves.
    ordered = np.ascontiguousarray(weights.reshape(2, -1, len(target)).transpose(0, 2, 1))
    results, along = (ordered[:, :, None] @ np.concatenate([values, slopes], axis=1))[:, :, 0]
    return results, along / lengths_of(along)[:, None]


def lagrange_each(where: Array, values: Array, target: Array) -> tuple[Array, Array]:
    """Evaluate polynomials through values (k, c, f), and return the values' weights (k, c)."""
    weights = lagrange(*_by_point(where, target)).reshape(-1, len(target)).T.copy()
    return (weights[:, None] @ values)[:, 0], weights


def _by_point(where: Array, target: Array) -> tuple[list[Any], Any]:
    """Return arclengths by point. One curve has plain floats: they take a sixth of the time."""
    return (where[0].tolist(), float(target[0])) if len(target) == 1 else (list(where.T), target)


def _hermite_weights(where: Sequence[Any], target: Any) -> tuple[list[Any], list[Any]]:
    """Return the weights of values and slopes in the polynomial's value and slope at the target.

    With Lagrange's polynomials l_i, the weight of a value is (1 - 2 (x - x_i) l_i'(x_i)) l_i(x)^2
    and that of a slope (x - x_i) l_i(x)^2.
    """
    of_values, of_slopes, d_values, d_slopes = [], [], [], []
    zero = 0.0 * target
    for i, x_i in enumerate(where):
        others = [x for j, x in enumerate(where) if j != i]
        basis, d_basis, d_node = 1.0 + zero, zero, zero
        for x_j in others:
            d_basis = (d_basis * (target - x_j) + basis) / (x_i - x_j)
            basis = basis * ((target - x_j) / (x_i - x_j))
            d_node = d_node + 1.0 / (x_i - x_j)
        away, square, d_square = target - x_i, basis * basis, 2 * basis * d_basis
        factor = 1 - 2 * away * d_node
        of_values.append(factor * square)
        of_slopes.append(away * square)
        d_values.append(-2 * d_node * square + factor * d_square)
        d_slopes.append(square + away * d_square)
    return of_values + of_slopes, d_values + d_slopes


def derivatives(curve: Curve[P], points: Sequence[P], arclength: float) -> Linearized | None:
    """Interpolate or extrapolate derivatives; return None if no point stores any."""
    stored = [point for point in points if point.linearization is not None]
    if not stored:
        return None
    weights = lagrange([point.arclength for point in stored], arclength)
    return curve.blended([point.linearization for point in stored], weights)


def lagrange(where: Sequence[Any], target: Any) -> Array:
    """Return the weights of values in their polynomial at a target, (c,) or of k curves (c, k).

    Plain floats are faster than arrays for a few points; of many curves arclengths are arrays (k,).
    """
    weights = []
    for i, x_i in enumerate(where):
        weight = 1.0 + 0.0 * target
        for j, x_j in enumerate(where):
            if j != i:
                weight *= (target - x_j) / (x_i - x_j)
        weights.append(weight)
    return np.array(weights)


def polynomial_weights(where: Array, targets: Array) -> Array:
    """Return the weights of values in their interpolation polynomial at many targets.

    Shapes: where (c,), targets (t,), returns (t, c); of many curves (k, c), (k, t), (k, t, c).
    """
    itself = np.eye(where.shape[-1], dtype=bool)
    apart = np.where(itself, 1.0, where[..., :, None] - where[..., None, :])
    away = targets[..., None] - where[..., None, :]
    others = np.where(itself, 1.0, away[..., None, :])
    return np.asarray(others.prod(axis=-1) / apart.prod(axis=-1)[..., None, :])
