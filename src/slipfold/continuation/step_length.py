"""Acceptance and length of steps of each of k curves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipfold.arrays import Array, Mask

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


@dataclass(frozen=True, eq=False)
class Measures:
    """Errors of steps: error and drift relative to their aims, turn to its maximum."""

    error: Array
    turn: Array
    drift: Array

    @property
    def fits(self) -> Mask:
        """Whether each step is accepted."""
        fits = (self.turn <= 1) & (self.error <= REJECT) & (self.drift <= REJECT)
        return np.asarray(fits)

    @cached_property
    def factor(self) -> Array:
        """Ratio of the next step to this one.

        The turn grows with the first power of the step, the drift with the second to third. At a
        singular point there is no tangent, and the turn is not a number.
        """
        allowed = np.minimum(ratio_by_geometry(self.error, self.turn), ratio_by_tests(self.drift))
        return np.asarray(np.minimum(np.maximum(0.9 * allowed, MINIMUM), LONGER))


def ratio_by_geometry(error: Array, turn: Array) -> Array:
    """Return the ratio of the next step to this one that prediction and tangent allow."""
    return np.asarray(np.fmin(error**-POWER, 0.9 / np.maximum(turn, 1e-3)))


def ratio_by_tests(drifted: Array) -> Array:
    """Return the ratio that the test functions allow."""
    return np.asarray(np.maximum(drifted, 1e-6) ** -0.4)


def drift(errors: Array, values: Array, actual: Array, noise: float, coarse: float) -> Array:
    """Return the largest relative error of extrapolated test functions, over its aim.

    Shapes: errors, actual (k, f); values at the points before (k, c, f); returns (k,).
    """
    scales = np.maximum(np.maximum(np.abs(values).max(axis=-2), np.abs(actual)), noise)
    # A function may not be defined everywhere.
    largest = np.fmax(errors / scales, 0.0).max(axis=-1, initial=0.0)
    return np.asarray(largest / (DRIFT * coarse))


def shortened_after_failure(moved: Array) -> Array:
    """Return the ratio of the next step to one after which Newton's method failed.

    `moved` is the length of its last correction, infinite where there was none.
    """
    factor = (np.maximum(ERROR, moved) / ERROR) ** -POWER
    diverged = (moved > ERROR) & (moved < np.inf)
    return np.where(diverged, np.minimum(np.maximum(factor, MINIMUM), DIVERGED), FAILED)
