"""How well steps fit, and how long the next ones may be: the same rules however many curves walk.

Numbers are those of one curve, or arrays with one of each of many that are followed together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from slipfold.arrays import Array

Number = Any
"""A float, or an array of shape (k,)."""

ERROR = 3e-3
"""Distance between predicted and corrected point that the steps aim at, in scaled variables."""

DRIFT = 0.15
"""Error of the extrapolated test functions that the steps aim at, relative to their size.

Between points they are then known ten times better still, and the search for bifurcations between
points rests on it. So do lines that are drawn through the points: with 0.3 there are a sixth fewer
points, and lines of drafts lie up to 8e-4 of their range off those that are followed."""

LONGER = 2.5
"""A step is at most this many times as long as the one before."""

POWER = 0.22
"""The prediction's error grows with the step to the power of 1/0.22 or so."""

REJECT = 4.0
"""A step whose measures exceed their aims by this factor is taken again, shorter."""

REACH = 2 * REJECT * ERROR
"""Corrections that are longer than this lead elsewhere."""

LEAST = 0.2
"""A step is at least this fraction of the one before."""

MISFIT, POOR, LOST = 0.7, 0.6, 0.35
"""What is left at most of a step that did not fit, of one whose correction did not converge, and of
one from which there was none."""

HARDER = 0.8
"""What a step that was shortened is followed by at most: the curve is getting harder."""

GUESSES = 12
"""Bisections for where a prediction reaches a bound: it is corrected anyway."""


@dataclass(frozen=True, eq=False)
class Measures:
    """How well steps fitted: error and drift relative to their aims, turn to its cap."""

    error: Number
    turn: Number
    drift: Number

    @staticmethod
    def of(
        distance: Number, angle: Number, drifted: Number, turn: float, coarse: float = 1.0
    ) -> Measures:
        """Measure distances from what was predicted, angles of tangents, and drifts."""
        return Measures(_greatest(distance, 1e-12) / (ERROR * coarse), angle / turn, drifted)

    @property
    def fits(self) -> Any:
        """Whether a step is accepted."""
        return (self.turn <= 1) & (self.error <= REJECT) & (self.drift <= REJECT)

    @property
    def follows_tests(self) -> bool:
        """Whether it is the test functions that make the next step of one curve no longer."""
        error, turn, drifted = self._lengths
        return bool(drifted < min(error, turn, LONGER))

    @property
    def _lengths(self) -> tuple[Number, Number, Number]:
        """By how much the next step may be longer for each of them.

        The turn grows with the first power of the step, the drift with the second to third.
        """
        return (
            self.error**-POWER,
            0.9 / _greatest(self.turn, 1e-3),
            _greatest(self.drift, 1e-6) ** -0.4,
        )

    @property
    def factor(self) -> Number:
        """By how much the next step may be longer."""
        return _least(_greatest(0.9 * _least(*self._lengths), LEAST), LONGER)


def drift(errors: Array, values: Array, actual: Array, noise: float, coarse: float = 1.0) -> Number:
    """Return the largest relative error of expected test functions, relative to its aim.

    Shapes: errors, actual (..., f); values at the points before (..., c, f); returns (...).
    """
    sizes = np.maximum(np.maximum(np.abs(values).max(axis=-2), np.abs(actual)), noise)
    # A function may not be defined everywhere.
    return np.nan_to_num(errors / sizes).max(axis=-1, initial=0.0) / (DRIFT * coarse)


def lengthened(step: Number, measures: Measures, growth: Number, largest: Number) -> Number:
    """Return the step to try after one that was accepted."""
    return _least(step * _least(measures.factor, growth), largest)


def shortened(step: Number, measures: Measures) -> Number:
    """Return the step to try instead of one that did not fit."""
    return step * _least(measures.factor, MISFIT)


def shortened_where_lost(step: Number, moved: Number) -> Number:
    """Return the step to try instead of one after which corrections did not converge.

    They moved by so much at last; by infinity where there was none.
    """
    poor = (moved > ERROR) & (moved < np.inf)
    factor = (_greatest(ERROR, moved) / ERROR) ** -POWER
    return step * _choose(poor, _least(_greatest(factor, LEAST), POOR), LOST)


def place_of_bound(
    component: Callable[[Number], Number], near: Number, far: Number, bound: Number, rising: Any
) -> Number:
    """Bisect for where a component of a prediction reaches a bound, from below or from above."""
    for _ in range(GUESSES):
        middle = 0.5 * (near + far)
        passed = (component(middle) > bound) == rising
        near, far = _choose(passed, near, middle), _choose(passed, middle, far)
    return far


# -- numbers or arrays of them: those of NumPy take ten times as long for a number -----------------


def _least(first: Number, *others: Number) -> Number:
    if isinstance(first, float):
        return min(first, *others)
    for other in others:
        first = np.minimum(first, other)
    return first


def _greatest(first: Number, other: Number) -> Number:
    if isinstance(first, float) and isinstance(other, float):
        return max(first, other)
    return np.maximum(first, other)


def _choose(condition: Any, first: Number, other: Number) -> Number:
    if isinstance(condition, bool | np.bool_):
        return first if condition else other
    return np.where(condition, first, other)
