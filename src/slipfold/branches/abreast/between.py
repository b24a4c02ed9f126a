"""Many curves between and beyond their points, each with its own: as `interpolation` has them.

Also whether test functions may vanish unseen between two points, as `search` asks of one curve.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.search import TOUCH, UNSURE

__all__ = ["are_doubtful", "arcs", "hermite_each", "lagrange_each"]

Array = NDArray[np.float64]

GRID = 16
"""Places between two points at which test functions are expected."""


def lagrange_each(where: Array, targets: Array) -> Array:
    """Weights of values that give the polynomials through them, shape (k, t, c).

    Shapes: where (k, c); targets (k, t).
    """
    count = where.shape[1]
    weights = np.ones((*targets.shape, count))
    for i in range(count):
        for j in range(count):
            if j != i:
                apart = (where[:, i] - where[:, j])[:, None]
                weights[:, :, i] *= (targets - where[:, j, None]) / apart
    return weights


def hermite_each(where: Array, values: Array, slopes: Array, target: Array) -> tuple[Array, Array]:
    """Evaluate the polynomials through points and slopes, and the unit vectors along them.

    Shapes: where (k, c); values, slopes (k, c, u); target (k,); returns (k, u), (k, u).
    """
    count = where.shape[1]
    found, along = np.zeros((2, len(where), values.shape[2]))
    for i in range(count):
        basis, d_basis, d_node = np.ones((3, len(where))) * [[1.0], [0.0], [0.0]]
        for j in range(count):
            if j != i:
                apart = where[:, i] - where[:, j]
                d_basis = (d_basis * (target - where[:, j]) + basis) / apart
                basis = basis * (target - where[:, j]) / apart
                d_node = d_node + 1.0 / apart
        away, square, d_square = target - where[:, i], basis * basis, 2 * basis * d_basis
        factor = 1 - 2 * away * d_node
        found += (factor * square)[:, None] * values[:, i]
        found += (away * square)[:, None] * slopes[:, i]
        along += (factor * d_square - 2 * d_node * square)[:, None] * values[:, i]
        along += (square + away * d_square)[:, None] * slopes[:, i]
    return found, along / np.sqrt((along * along).sum(axis=1))[:, None]


def arcs(difference: Array, before: Array, after: Array) -> tuple[Array, Array]:
    """Return the arclengths between points and the angles between their unit tangents.

    Shapes: all (k, u); returns (k,), (k,).
    """
    chord = np.sqrt((difference * difference).sum(axis=1))
    turn = np.arccos(np.clip((before * after).sum(axis=1), -1.0, 1.0))
    bent = np.where(turn < 1e-4, 1.0, turn)
    return np.where(turn < 1e-4, chord, chord * 0.5 * bent / np.sin(0.5 * bent)), turn


def are_doubtful(where: Array, values: Array) -> NDArray[np.bool_]:
    """Return whether a function may touch zero, or pass it more than once, between the last two.

    Shapes: where (k, c), two or more points of each curve in order; values (k, c, f); returns (k,).
    """
    count = where.shape[1]
    first, last = where[:, -2], where[:, -1]
    shares = np.linspace(0.0, 1.0, GRID + 2)[1:-1]
    grid = first[:, None] + (last - first)[:, None] * shares
    inside = lagrange_each(where, grid) @ values
    fewer = slice(1, None) if count > 2 else slice(0, 1)
    errors = np.abs(inside - lagrange_each(where[:, fewer], grid) @ values[:, fewer])
    ends, surprises = values[:, -2:], np.empty((len(where), 2, values.shape[2]))
    for place in (0, 1):
        others = [i for i in range(count) if i != count - 2 + place]
        weights = lagrange_each(where[:, others], where[:, count - 2 + place, None])
        surprises[:, place] = np.abs(ends[:, place] - (weights @ values[:, others])[:, 0])
    f_a, f_b = ends[:, 0], ends[:, 1]
    sides = np.where(f_a != 0, np.sign(f_a), -np.sign(f_b))
    inner = sides[:, None] * inside
    least = np.minimum(np.abs(f_a), np.abs(f_b))
    touched = ((inner - np.maximum(errors, TOUCH * least[:, None])) < 0).any(axis=1)
    unsure = (np.abs(ends) < UNSURE * surprises).any(axis=1)
    bracketed = np.concatenate([np.ones_like(inner[:, :1]), inner, -np.ones_like(inner[:, :1])], 1)
    several = (np.diff(np.sign(bracketed), axis=1) != 0).sum(axis=1) > 1
    same = f_a * f_b > 0
    return np.asarray(np.where(same, touched | unsure, several).any(axis=1))
