"""Whether functions of points may vanish unseen between two of them, on one curve or on many."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipfold.arrays import Array, Mask
from slipfold.continuation.curve import Point
from slipfold.continuation.interpolation import lagrange, polynomial_weights
from slipfold.continuation.step_length import Number

PLACES = 16
"""Places between two points at which functions are expected."""

UNSURE = 0.25
"""Share of the difference between a test function and what its neighbors let expect, below which
it may have changed its sign twice: a parabola with that error in its slope falls by so much."""

TOUCH = 0.15
"""A test function that falls between two points to this share of its values there is looked at."""


def places_between(first: float | Array, last: float | Array) -> Array:
    """Return places between two points, shape (t,); or of each of many curves, shape (k, t)."""
    spacing = np.asarray((last - first) / (PLACES + 1))[..., None]
    return np.arange(1, PLACES + 1) * spacing + np.asarray(first)[..., None]


def expectation_weights(
    where: Array, grid: Array, ends: tuple[Number, Number], own: tuple[int, int]
) -> Array:
    """Weights of points in what they let expect at other places, those of a place in a row.

    First on a grid between two ends, then there without the last one, which is the farthest away,
    then at these ends without those of the points, by number, that lie there; -1 where none does.

    Shapes: where (c,), grid (t,), returns (2 t + 2, c); or of each of many curves (k, ...).
    """
    size, count = grid.shape[-1], where.shape[-1]
    weights = np.zeros((*grid.shape[:-1], 2 * size + 2, count))
    weights[..., :size, :] = inside = polynomial_weights(where, grid)
    farthest = where[..., -1:]
    factors = (where[..., :-1] - farthest)[..., None, :] / (grid - farthest)[..., None]
    weights[..., size:-2, :-1] = inside[..., :-1] * factors
    places: Sequence = where.tolist() if where.ndim == 1 else list(where.T)
    for row, end, itself in zip((-2, -1), ends, own, strict=True):
        others = [i for i in range(count) if i != itself]
        weights[..., row, others] = lagrange([places[i] for i in others], end).T
    return weights


@dataclass(frozen=True, eq=False)
class Expected:
    """Test functions as they are expected between two points; of many curves with a first axis."""

    inside: Array  # the functions on a grid between them, shape (t, f)
    errors: Array  # by how much these change if the point farthest away is left out, shape (t, f)
    ends: Array  # the functions at the points, shape (2, f)
    surprises: Array  # by how much these differ from what the others let expect, shape (2, f)

    @staticmethod
    def of(values: Array, ends: Array, foreseen: Array | None = None) -> Expected:
        """Expect the functions from their values, or as they are foreseen where that is better.

        Shapes: values, foreseen as the rows of `expectation_weights`, (2 t + 2, f).
        """
        size = (values.shape[-2] - 2) // 2
        grid, fewer = slice(None, size), slice(size, -2)
        if foreseen is not None:
            one, other = (
                np.abs(each[..., grid, :] - each[..., fewer, :]) for each in (values, foreseen)
            )
            better = other.max(axis=-2) < one.max(axis=-2)
            values = np.where(better[..., None, :], foreseen, values)
        inside = values[..., grid, :]
        errors = np.abs(inside - values[..., fewer, :])
        return Expected(inside, errors, ends, np.abs(ends - values[..., -2:, :]))

    @property
    def doubtful(self) -> Mask:
        """Whether each may touch zero, or pass it more often than its ends tell, shape (f,).

        Between the points it may be as far from its interpolation as that is from the one through a
        point less. At a point where it is far from what its neighbors let expect and near zero,
        its slope is not known, and it may have come from the other side.
        """
        first, last = self.ends[..., 0, :], self.ends[..., 1, :]
        touched = self._above_zero.min(axis=-2) < 0
        unsure = (np.abs(self.ends) < UNSURE * self.surprises).any(axis=-2)
        several = np.count_nonzero(self._changes, axis=-2) > 1
        # A function that is not defined everywhere, or is zero everywhere.
        known = np.isfinite(self.inside).all(axis=-2) & ((first != 0) | (last != 0))
        return np.asarray(known & np.where(first * last > 0, touched | unsure, several))

    def doubtful_place(self, grid: Array) -> float | None:
        """Return where the first of them on one curve is in doubt, None if none is."""
        for place in np.flatnonzero(self.doubtful).tolist():
            if self.ends[0, place] * self.ends[1, place] <= 0:
                changes = np.flatnonzero(self._changes[:, place])
                return float(grid[min(changes[1], len(grid) - 1)])
            above = self._above_zero[:, place]
            lowest = int(above.argmin())
            return float(grid[lowest] if above[lowest] < 0 else 0.5 * (grid[0] + grid[-1]))
        return None

    @cached_property
    def _inner(self) -> Array:
        """The functions on the grid, positive where they have the sign of the first end."""
        first, last = self.ends[..., 0, :], self.ends[..., 1, :]
        sides = np.where(first != 0, np.sign(first), -np.sign(last))
        return np.asarray(sides[..., None, :] * self.inside)

    @cached_property
    def _above_zero(self) -> Array:
        """How far above zero these are for sure, shape (t, f)."""
        least = np.abs(self.ends).min(axis=-2)[..., None, :]
        return self._inner - np.maximum(self.errors, TOUCH * least)

    @cached_property
    def _changes(self) -> Mask:
        """Where these change their sign, if they do so from one end to the other; (t + 1, f)."""
        inner = self._inner
        signs = np.ones((*inner.shape[:-2], inner.shape[-2] + 2, inner.shape[-1]))
        np.sign(inner, out=signs[..., 1:-1, :])
        signs[..., -1, :] = -1.0
        return np.asarray(signs[..., 1:, :] != signs[..., :-1, :])


SHARE = 0.5
"""Share of its distance from zero by which the bound of the multipliers may change in one step."""


def contracts_between(a: Point, b: Point) -> bool:
    """Whether perturbations shrink on all orbits between two points, so that nothing happens.

    They do at both, and the bound of the multipliers changes by less from one to the other than
    by what it lies below zero.
    """
    least = max(a.growth, b.growth)
    if not -np.inf < min(a.growth, b.growth) <= least < 0:
        return False
    same = all((a.tests[name] > 0) == (b.tests[name] > 0) for name in a.tests)
    return same and a.orientation == b.orientation and abs(a.growth - b.growth) <= SHARE * -least


def contraction_drift(recent: Sequence[Point], point: Point) -> float:
    """Return how badly the bound of the multipliers was foreseen, relative to what is allowed.

    Multipliers turn with the forcing frequency, and test functions with them, also where nothing
    can happen; what could is limited by the bound, which does not turn. Infinite where the bound
    does not exclude bifurcations.
    """
    if not contracts_between(recent[-1], point):
        return np.inf
    if not all(np.isfinite(item.growth) for item in recent):
        return 0.0
    weights = lagrange([item.arclength for item in recent], point.arclength)
    expected = float(weights @ [item.growth for item in recent])
    allowed = SHARE * min(-recent[-1].growth, -point.growth)
    change = max(abs(point.growth - expected), abs(point.growth - recent[-1].growth))
    return float(change / allowed)
