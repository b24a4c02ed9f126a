"""Acceptance and length of steps of each of k curves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipfold.arrays import Array, Mask


class STEP:
    """Rules for the acceptance and the length of steps."""

    # Distance between predicted and corrected point that the steps aim at, in scaled variables
    error: float = 3e-3
    # Error of the extrapolated test functions that the steps aim at, relative to their size.
    # Interpolation between the points is then ten times better still. The search for bifurcations
    # needs that, and so do lines drawn through the points: with 0.3 there are a sixth fewer points,
    # and lines of moved branches have errors of up to 8e-4 of their range
    drift: float = 0.15
    # A step is at most this many times as long as the one before
    longer: float = 2.5
    # Ratio of the largest turn that is predicted to the largest one that is not: a smooth bend
    # would take an eighth more points without it
    turns: float = 2.0
    # Fraction of what errors and turns allow that a step takes: without it 2 to 6 % fewer are tried
    # and more of them rejected, and lines through the points are 1.3 times less exact
    margin: float = 0.9
    # The prediction's error grows with the step to the power of 1/0.22 or so
    power: float = 0.22
    # A step whose errors exceed their aims by this factor is taken again, shorter
    reject: float = 4.0
    # Corrections that are longer than this lead elsewhere
    reach: float = 2 * reject * error
    # Fraction of the function that is zero at branch points, relative to the tangent's component
    # along the parameter, below which one step may have reached a branch point
    falls: float = 0.5
    # Angle in radians between predicted and corrected tangent below which a step is taken to stay
    # on its curve: a straight one passes zeros of that function at no cost
    angle: float = 3e-3
    # A step is at least this fraction of the one before; a smaller one is seldom needed, and takes
    # several steps to grow again
    minimum: float = 0.3
    # Maximum ratio of the next step to one that was rejected, to one whose correction did not
    # converge, and to one without a correction
    rejected: float = 0.7
    diverged: float = 0.6
    failed: float = 0.35
    # Maximum ratio of the next step to one that was shortened: the curve is getting harder
    harder: float = 0.8
    # By this factor that maximum rises with each step that is accepted: where a curve becomes
    # singular, as at a limit, every growth by 2.5 was followed by a failure
    easier: float = 2.0
    # Fraction of the estimated distance to where the model ends that a step takes, once a step
    # failed there: with 0.6 to 0.8 a response took 45 to 47 points and trials, with 0.9 there were
    # failures, and without it 50
    toward_end: float = 0.7
    # Weight of the error of polynomials through the test functions where a prediction from
    # derivatives is better. Lines drawn through the points are such polynomials, and need this many
    # points
    lines: float = 0.25
    # Error of the prediction, relative to its aim, below which that weight falls in proportion: the
    # lines are straight, however fast multipliers rotate
    straight: float = 0.01
    # Distance from a bound that counts as none. Rounding may bring a guess beyond a bound on which
    # the curve begins and along which it runs, as a pitchfork does: then its point decides
    edge: float = 1e-9
    # Length of an unknown above which steps may be longer in proportion: at a resonance orbits are
    # many times as large as the state scales
    large: float = 10.0
    # Bisections for the arclength at which a prediction reaches a bound: it is corrected anyway
    bisections: int = 12
    # First step from a regular point, in scaled variables
    first: float = 0.02
    # First step from a point of another curve, and distance before it of the last regular point of
    # a closing curve: curves are singular there
    emanating: float = 3e-3
    # Points before the current one that are interpolated
    memory: int = 6
    # Ratio of the next step to one between whose ends the curve was not found
    retreat: float = 0.3
    # Change of a parameter between two points, in spans, whose sign rounding may decide: with
    # multipliers of 1e7 orbits are known to about 1e-8
    flat: float = 1e-7


@dataclass(frozen=True, eq=False)
class Measures:
    """Errors of steps: error and drift relative to their aims, turns to their maximum."""

    error: Array
    turn: Array
    drift: Array

    @property
    def fits(self) -> Mask:
        """Whether each step is accepted."""
        fits = (self.turn <= 1) & (self.error <= STEP.reject) & (self.drift <= STEP.reject)
        return np.asarray(fits)

    @cached_property
    def factor(self) -> Array:
        """Ratio of the next step to this one.

        The turn grows with the first power of the step, the drift with the second to third. At a
        singular point there is no tangent, and the turn is not a number.
        """
        allowed = np.minimum(ratio_by_geometry(self.error, self.turn), ratio_by_tests(self.drift))
        return np.asarray(np.minimum(np.maximum(STEP.margin * allowed, STEP.minimum), STEP.longer))


def ratio_by_geometry(error: Array, turn: Array) -> Array:
    """Return the ratio of the next step to this one that prediction and tangent allow."""
    return np.asarray(np.fmin(error**-STEP.power, STEP.margin / np.maximum(turn, 1e-3)))


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
    return np.asarray(largest / (STEP.drift * coarse))


def shortened_after_failure(moved: Array) -> Array:
    """Return the ratio of the next step to one after which Newton's method failed.

    `moved` is the length of its last correction, infinite where there was none.
    """
    factor = (np.maximum(STEP.error, moved) / STEP.error) ** -STEP.power
    diverged = (moved > STEP.error) & (moved < np.inf)
    return np.where(
        diverged, np.minimum(np.maximum(factor, STEP.minimum), STEP.diverged), STEP.failed
    )
