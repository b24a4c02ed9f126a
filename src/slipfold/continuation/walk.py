"""Pseudo-arclength continuation: one point after the other, with adapted steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.curve import Curve, P
from slipfold.continuation.interpolation import (
    POINTS,
    angle_between,
    arc_between,
    derivatives,
    hermite,
    lagrange,
)
from slipfold.continuation.newton import TOO_SHARP, Correction, correct, length_of
from slipfold.continuation.search import contraction_drift
from slipfold.continuation.settings import Stepping
from slipfold.continuation.step_length import (
    HARDER,
    LONGER,
    REACH,
    Measures,
    arclength_of_bound,
    drift,
    lengthened,
    shortened,
    shortened_after_failure,
)
from slipfold.errors import BREAKDOWNS, breakdown

Bound = tuple[int, float, float]
"""A component of the unknown, with the smallest and the largest value it may take."""

LINES = 0.25
"""Weight of the error of polynomials through the test functions where a prediction from derivatives
is better. Lines drawn through the points are such polynomials, and need this many points."""

STRAIGHT = 0.01
"""Error of the prediction, relative to its aim, below which that weight falls in proportion: the
lines are straight, however fast multipliers rotate."""

EDGE = 1e-9
"""Distance from a bound that counts as none. Rounding may bring a guess beyond a bound on which the
curve begins and along which it runs, as a pitchfork does: then its point decides."""

LARGE = 10.0
"""Length of an unknown above which steps may be longer in proportion: at a resonance orbits are
many times as large as the state scales."""


@dataclass(frozen=True)
class Failure:
    """Why no further point was found."""

    kind: str  # ``"failed"`` or ``"points"``
    reason: str  # a sentence


def walk(
    curve: Curve[P],
    start: Sequence[P],
    first_step: float,
    bounds: Sequence[Bound],
    settings: Stepping,
    cap: Callable[[P], float] | None = None,
    taken: int = 0,
) -> Iterator[P | Failure]:
    """Follow a curve on which steps were taken until a parameter leaves its bounds."""
    recent = list(start)[-POINTS:]
    step = min(first_step, settings.steps.largest)
    for _ in range(taken, settings.steps.points):
        if cap is not None:
            step = min(step, cap(recent[-1]))
        point, step = _Step(curve, recent, bounds, settings).take(step)
        if isinstance(point, Failure):
            yield point
            return
        yield point
        if reaches(point, bounds):
            return
        recent = [*recent, point][-POINTS:]
    yield Failure("points", f"{settings.steps.points} points were not enough; allow more points")


def first_point(curve: Curve[P], start: P, step: float, settings: Stepping) -> P | Failure:
    """Return the point a step beyond another, whatever the bounds."""
    return _Step(curve, [start], (), settings).take(min(step, settings.steps.largest))[0]


def reaches(point: P, bounds: Sequence[Bound]) -> bool:
    """Whether a point lies on a bound."""
    return any(point.z[index] in (low, high) for index, low, high in bounds)


class _Step(Generic[P]):
    """A step from the last of a few points."""

    def __init__(
        self, curve: Curve[P], recent: list[P], bounds: Sequence[Bound], settings: Stepping
    ) -> None:
        self._curve, self._recent, self._last = curve, recent, recent[-1]
        self._bounds, self._settings = bounds, settings

    def take(self, step: float) -> tuple[P | Failure, float]:
        """Take the step, shortening it until it is accepted; return the next one as well."""
        steps = self._settings.steps
        largest = steps.largest * max(1.0, length_of(self._last.z) / LARGE)
        reason, growth = TOO_SHARP, LONGER
        while step >= steps.smallest:
            try:
                correction, point = self._try(step)
            except BREAKDOWNS as error:
                reason, growth = breakdown(error), HARDER
                step = shortened_after_failure(step, np.inf)
                continue
            if point is not None:
                measures = self._measure(point, correction)
                # No extrapolation holds from one smooth piece to the next; a monitor locates its
                # end.
                leaves = point.piece != self._last.piece
                if measures.fits or leaves or step <= 4 * steps.smallest:
                    return point, lengthened(step, measures, growth, largest)
                step = shortened(step, measures)
                reason = TOO_SHARP
            else:
                reason = correction.failure
                step = shortened_after_failure(step, correction.moved)
            growth = HARDER
        return Failure("failed", f"the step fell below {steps.smallest:g}: {reason}"), step

    def _try(self, step: float) -> tuple[Correction, P | None]:
        """Predict and correct; a point beyond a bound is corrected on the bound."""
        target = self._last.arclength + step
        guess, row = hermite(self._recent, target)
        held = self._first_bound_beyond(guess, target, EDGE)
        if held is None:
            correction = self._correct(self._curve.aligned(guess, self._last.z), row, target)
            if not correction.converged:
                return correction, None
            held = self._first_bound_beyond(correction.z, target)
        # In a corner of the window, holding one bound may lead beyond another.
        for _ in self._bounds:
            if held is None:
                break
            index, bound = held
            arclength = self._arclength_at(index, bound, target)
            guess = self._curve.aligned(hermite(self._recent, arclength)[0], self._last.z)
            guess[index] = bound
            row = np.zeros_like(row)
            row[index] = np.sign(bound - self._last.z[index]) or 1.0
            correction = self._correct(guess, row, arclength)
            if not correction.converged:
                return correction, None
            correction.z[index] = bound  # exactly, whatever rounding did
            held = self._first_bound_beyond(correction.z, target)
        point = self._curve.point(correction, target)
        arclength = self._last.arclength + arc_between(self._last, point)
        return correction, replace(point, arclength=arclength)

    def _correct(self, guess: Array, row: Array, arclength: float) -> Correction:
        newton, reach = self._settings.newton, REACH * self._settings.coarse
        expected = derivatives(self._curve, self._recent, arclength)
        given = newton.tolerance, newton.iterations, reach, expected
        return correct(self._curve, guess, row, *given)

    def _first_bound_beyond(
        self, z: Array, target: float, tolerance: float = 0.0
    ) -> tuple[int, float] | None:
        """Return the component and the bound that the curve passes first before z, if any."""
        passed = [
            (index, low if z[index] < low else high)
            for index, low, high in self._bounds
            if not low - tolerance <= z[index] <= high + tolerance
        ]
        reached = [(self._arclength_at(*item, target), item) for item in passed]
        return min(reached)[1] if reached else None

    def _arclength_at(self, index: int, bound: float, beyond: float) -> float:
        """Return the arclength at which a component of the prediction reaches a bound."""

        def component(arclength: float) -> float:
            return float(hermite(self._recent, arclength)[0][index])

        rising, near = component(beyond) > bound, self._last.arclength
        return float(arclength_of_bound(component, near, beyond, bound, rising))

    def _measure(self, point: P, correction: Correction) -> Measures:
        recent, curve, coarse = self._recent, self._curve, self._settings.coarse
        values = np.array([item.values for item in recent])
        weights = lagrange([item.arclength for item in recent], point.arclength)
        errors = np.abs(point.values - weights @ values)
        angle = angle_between(self._last.tangent, point.tangent)
        given = values, point.values, curve.noise, coarse
        # Nothing is extrapolated from one point.
        drifted = 0.0 if len(recent) == 1 else float(drift(errors, *given))
        turn = self._settings.steps.turn
        measures = Measures.of(correction.distance, angle, drifted, turn, coarse)
        if measures.follows_tests and measures.error < STRAIGHT:
            errors = _without_jumps(errors, values, point.values)
            measures = replace(measures, drift=float(drift(errors, *given)))
        if not measures.follows_tests:
            return measures
        # Better predictions, and whether they matter, take longer to compute.
        extrapolated = curve.extrapolated(recent, weights[None])
        if extrapolated is not None:
            errors = np.fmin(errors, np.abs(point.values - extrapolated[0]))
            lines = LINES * min(1.0, measures.error / STRAIGHT)
            drifted = max(float(drift(errors, *given)), lines * drifted)
        return replace(measures, drift=min(drifted, contraction_drift(recent, point) / coarse))


def _without_jumps(errors: Array, values: Array, actual: Array) -> Array:
    """Return the errors of extrapolated test functions, zero for those that jump.

    Where the curve is nearly straight, but multipliers pass the unit circle within a small part of
    a step, no shorter step predicts that. The jump is located anyway, as all changes of sign are;
    the values before it say nothing about those after it.
    """
    last = values[-1]
    jumped = ((values > 0) != (last > 0)).any(axis=0)
    errors = np.where(jumped, np.abs(actual - last), errors)
    return np.where((last > 0) != (actual > 0), 0.0, errors)
