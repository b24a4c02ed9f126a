"""Acceptance and length of steps: the same rules for one curve and for many.

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

Interpolation between the points is then ten times better still. The search for bifurcations needs
that, and so do lines drawn through the points: with 0.3 there are a sixth fewer points, and lines
of drafts have errors of up to 8e-4 of their range."""

LONGER = 2.5
"""A step is at most this many times as long as the one before."""

POWER = 0.22
"""The prediction's error grows with the step to the power of 1/0.22 or so."""

REJECT = 4.0
"""A step whose errors exceed their aims by this factor is taken again, shorter."""

REACH = 2 * REJECT * ERROR
"""Corrections that are longer than this lead elsewhere."""

MINIMUM = 0.2
"""A step is at least this fraction of the one before."""

REJECTED, DIVERGED, FAILED = 0.7, 0.6, 0.35
"""Maximum ratio of the next step to one that was rejected, to one whose correction did not
converge, and to one without a correction."""

HARDER = 0.8
"""Maximum ratio of the next step to one that was shortened: the curve is getting harder."""

GUESSES = 12
"""Bisections for the arclength at which a prediction reaches a bound: it is corrected anyway."""


@dataclass(frozen=True, eq=False)
class Measures:
    """Errors of steps: error and drift relative to their aims, turn to its maximum."""

    error: Number
    turn: Number
    drift: Number

    @staticmethod
    def of(
        distance: Number, angle: Number, drifted: Number, turn: float, coarse: float = 1.0
    ) -> Measures:
        """Measure distances from predictions, angles of tangents, and drifts."""
        return Measures(_maximum(distance, 1e-12) / (ERROR * coarse), angle / turn, drifted)

    @property
    def fits(self) -> Any:
        """Whether a step is accepted."""
        return (self.turn <= 1) & (self.error <= REJECT) & (self.drift <= REJECT)

    @property
    def follows_tests(self) -> bool:
        """Whether the test functions limit the next step of one curve."""
        error, turn, drifted = self._lengths
        return bool(drifted < min(error, turn, LONGER))

    @property
    def _lengths(self) -> tuple[Number, Number, Number]:
        """Ratio of the next step to this one that each of them allows.

        The turn grows with the first power of the step, the drift with the second to third.
        """
        return (
            self.error**-POWER,
            0.9 / _maximum(self.turn, 1e-3),
            _maximum(self.drift, 1e-6) ** -0.4,
        )

    @property
    def factor(self) -> Number:
        """Ratio of the next step to this one."""
        return _minimum(_maximum(0.9 * _minimum(*self._lengths), MINIMUM), LONGER)


def drift(errors: Array, values: Array, actual: Array, noise: float, coarse: float = 1.0) -> Number:
    """Return the largest relative error of extrapolated test functions, over its aim.

    Shapes: errors, actual (..., f); values at the points before (..., c, f); returns (...).
    """
    scales = np.maximum(np.maximum(np.abs(values).max(axis=-2), np.abs(actual)), noise)
    # A function may not be defined everywhere.
    return np.nan_to_num(errors / scales).max(axis=-1, initial=0.0) / (DRIFT * coarse)


def lengthened(step: Number, measures: Measures, growth: Number, largest: Number) -> Number:
    """Return the step to try after one that was accepted."""
    return _minimum(step * _minimum(measures.factor, growth), largest)


def shortened(step: Number, measures: Measures) -> Number:
    """Return the step to try instead of one that was rejected."""
    return step * _minimum(measures.factor, REJECTED)


def shortened_after_failure(step: Number, moved: Number) -> Number:
    """Return the step to try instead of one after which Newton's method failed.

    `moved` is the length of its last correction, infinite where there was none.
    """
    diverged = (moved > ERROR) & (moved < np.inf)
    factor = (_maximum(ERROR, moved) / ERROR) ** -POWER
    return step * _choose(diverged, _minimum(_maximum(factor, MINIMUM), DIVERGED), FAILED)


def arclength_of_bound(
    component: Callable[[Number], Number], near: Number, far: Number, bound: Number, rising: Any
) -> Number:
    """Bisect for the arclength at which a component of a prediction reaches a bound.

    `rising` says whether it reaches the bound from below.
    """
    for _ in range(GUESSES):
        middle = 0.5 * (near + far)
        passed = (component(middle) > bound) == rising
        near, far = _choose(passed, near, middle), _choose(passed, middle, far)
    return far


# -- numbers or arrays of them: those of NumPy take ten times as long for a number -----------------


def _minimum(first: Number, *others: Number) -> Number:
    if isinstance(first, float):
        return min(first, *others)
    for other in others:
        first = np.minimum(first, other)
    return first


def _maximum(first: Number, other: Number) -> Number:
    if isinstance(first, float) and isinstance(other, float):
        return max(first, other)
    return np.maximum(first, other)


def _choose(condition: Any, first: Number, other: Number) -> Number:
    if isinstance(condition, bool | np.bool_):
        return first if condition else other
    return np.where(condition, first, other)
