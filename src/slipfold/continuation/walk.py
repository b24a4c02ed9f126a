"""Pseudo-arclength continuation: one point after the other, with adapted steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

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
from slipfold.continuation.newton import Correction, Linearized, correct, length_of
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
        point, step = _next_point(curve, recent, step, bounds, settings)
        if isinstance(point, Failure):
            yield point
            return
        yield point
        if reaches(point, bounds):
            return
        recent = [*recent, point][-POINTS:]
    yield Failure("points", f"{settings.steps.points} points were not enough; allow more points")


def reaches(point: P, bounds: Sequence[Bound]) -> bool:
    """Whether a point lies on a bound."""
    return any(point.z[index] in (low, high) for index, low, high in bounds)


def _next_point(
    curve: Curve[P],
    recent: list[P],
    step: float,
    bounds: Sequence[Bound],
    settings: Stepping,
) -> tuple[P | Failure, float]:
    """Take one step, shortening it until it fits; return the step to try next as well."""
    smallest, size = settings.steps.smallest, length_of(recent[-1].z)
    largest = settings.steps.largest * max(1.0, size / LARGE)
    reason, growth = "the curve turns too sharply", LONGER
    while step >= smallest:
        try:
            correction, point = _try(curve, recent, step, bounds, settings)
        except BREAKDOWNS as error:
            reason, step, growth = breakdown(error), shortened_after_failure(step, np.inf), HARDER
            continue
        if point is not None:
            measures = _measure(curve, recent, point, correction, settings)
            # No extrapolation holds from one smooth piece to the next; a monitor locates its end.
            leaves = point.piece != recent[-1].piece
            if measures.fits or leaves or step <= 4 * smallest:
                return point, lengthened(step, measures, growth, largest)
            step = shortened(step, measures)
            reason = "the curve turns too sharply"
        else:
            reason = correction.failure
            step = shortened_after_failure(step, correction.moved)
        growth = HARDER
    return Failure(
        "failed",
        f"the step fell below {smallest:g}: {reason}; look at the model's limits near this value",
    ), step


def _try(
    curve: Curve[P],
    recent: list[P],
    step: float,
    bounds: Sequence[Bound],
    settings: Stepping,
) -> tuple[Correction, P | None]:
    """Predict and correct; what lies beyond a bound is corrected on it."""
    last = recent[-1]
    target = last.arclength + step
    guess, row = hermite(recent, target)
    held = _first_bound_beyond(recent, guess, bounds, target, EDGE)
    if held is None:
        guess = curve.aligned(guess, last.z)
        expected = derivatives(curve, recent, target)
        correction = _correct(curve, guess, row, settings, expected)
        if not correction.converged:
            return correction, None
        held = _first_bound_beyond(recent, correction.z, bounds, target)
    # In a corner of the window, holding one bound may lead beyond another.
    for _ in bounds:
        if held is None:
            break
        index, bound = held
        arclength = _arclength_at(recent, index, bound, target)
        guess = hermite(recent, arclength)[0]
        guess = curve.aligned(guess, last.z)
        guess[index] = bound
        row = np.zeros_like(row)
        row[index] = np.sign(bound - last.z[index]) or 1.0
        expected = derivatives(curve, recent, arclength)
        correction = _correct(curve, guess, row, settings, expected)
        if not correction.converged:
            return correction, None
        correction.z[index] = bound  # exactly, whatever rounding did
        held = _first_bound_beyond(recent, correction.z, bounds, target)
    point = curve.point(correction, target)
    return correction, replace(point, arclength=last.arclength + arc_between(last, point))


def _first_bound_beyond(
    recent: list[P],
    z: Array,
    bounds: Sequence[Bound],
    target: float,
    tolerance: float = 0.0,
) -> tuple[int, float] | None:
    """Return the component and the bound that the curve passes first before z, if any."""
    passed = [
        (index, low if z[index] < low else high)
        for index, low, high in bounds
        if not low - tolerance <= z[index] <= high + tolerance
    ]
    return min(
        passed, key=lambda item: _arclength_at(recent, item[0], item[1], target), default=None
    )


def _correct(
    curve: Curve[P], guess: Array, row: Array, settings: Stepping, expected: Linearized | None
) -> Correction:
    tolerance, iterations = settings.newton.tolerance, settings.newton.iterations
    reach = REACH * settings.coarse
    return correct(curve, guess, row, tolerance, iterations, reach, expected)


def _arclength_at(recent: list[P], index: int, bound: float, beyond: float) -> float:
    """Return the arclength at which a component of the prediction reaches a bound."""

    def component(arclength: float) -> float:
        return float(hermite(recent, arclength)[0][index])

    rising = component(beyond) > bound
    return float(arclength_of_bound(component, recent[-1].arclength, beyond, bound, rising))


def _measure(
    curve: Curve[P], recent: list[P], point: P, correction: Correction, settings: Stepping
) -> Measures:
    values = np.array([item.values for item in recent])
    weights = lagrange([item.arclength for item in recent], point.arclength)
    errors, coarse = np.abs(point.values - weights @ values), settings.coarse
    angle = angle_between(recent[-1].tangent, point.tangent)
    given = values, point.values, curve.noise, coarse
    drifted = (
        0.0 if len(recent) == 1 else float(drift(errors, *given))
    )  # nothing is extrapolated from one
    measures = Measures.of(correction.distance, angle, drifted, settings.steps.turn, coarse)
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
