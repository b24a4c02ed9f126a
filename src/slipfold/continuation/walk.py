"""Pseudo-arclength continuation: one point after the other, with steps that fit the curve."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.contraction import contraction_drift
from slipfold.continuation.curve import Curve
from slipfold.continuation.interpolation import (
    POINTS,
    angle_between,
    arc_between,
    derivatives,
    hermite,
    lagrange,
)
from slipfold.continuation.newton import Correction, Linearised, correct, length_of
from slipfold.continuation.point import P
from slipfold.continuation.settings import Stepping
from slipfold.errors import BREAKDOWNS, breakdown

__all__ = ["Bound", "Failure", "reaches", "walk"]

Array = NDArray[np.float64]

Bound = tuple[int, float, float]
"""A component of the unknown, with the least and the largest value it may take."""

ERROR = 3e-3
"""Distance between predicted and corrected point that the steps aim at, in scaled variables."""

DRIFT = 0.15
"""Error of the extrapolated test functions that the steps aim at, relative to their size.

Between points they are then known ten times better still, and the search for bifurcations between
points rests on it. So do lines that are drawn through the points: with 0.3 there are a sixth fewer
points, and carried lines lie by up to 8e-4 of their range beside those that are followed."""

LINES = 0.25
"""What counts of the extrapolated test functions' error where these are foreseen better: lines
through the points, which know nothing of them, would bend too much between fewer."""

STRAIGHT = 0.01
"""Error of the prediction, relative to its aim, below which that counts ever less: the lines do not
bend, however fast multipliers turn."""

LONGER = 2.5
"""A step is at most this many times as long as the one before."""

POWER = 0.22
"""The prediction's error grows with the step to the power of 1/0.22 or so."""

GUESSES = 12
"""Bisections for where a prediction reaches a bound: it is corrected anyway."""

SLACK = 1e-9
"""A guess that is less beyond a bound may be so by rounding: where the curve begins on a bound and
runs along it, as a pitchfork's does, its point decides."""

LARGE = 10.0
"""Length of an unknown from which on steps may be longer in proportion: at a resonance orbits are
many times as large as typical sizes."""

REJECT = 4.0
"""A step whose measures exceed their aims by this factor is taken again, shorter."""


@dataclass(frozen=True)
class Failure:
    """Why no further point was found."""

    kind: str  # ``"failed"`` or ``"points"``
    reason: str  # a sentence


@dataclass(frozen=True)
class _Measures:
    """How well a step fitted: error and drift relative to their aims, turn to its cap."""

    error: float
    turn: float
    drift: float

    @property
    def fits(self) -> bool:
        return self.turn <= 1 and max(self.error, self.drift) <= REJECT

    @property
    def follows_tests(self) -> bool:
        """Whether it is the test functions that make the next step no longer."""
        return self._lengths[2] < min(*self._lengths[:2], LONGER)

    @property
    def _lengths(self) -> tuple[float, float, float]:
        """By how much the next step may be longer for each of them.

        The turn grows with the first power of the step, the drift with the second to third.
        """
        return self.error**-POWER, 0.9 / max(self.turn, 1e-3), max(self.drift, 1e-6) ** -0.4

    def factor(self) -> float:
        """By how much the next step may be longer."""
        return min(max(0.9 * min(self._lengths), 0.2), LONGER)


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
            reason, step, growth = breakdown(error), 0.35 * step, 0.8
            continue
        if point is not None:
            measures = _measure(curve, recent, point, correction, settings)
            # From one smooth piece to the next nothing fits; what ends a piece locates it.
            leaves = point.piece != recent[-1].piece
            if measures.fits or leaves or step <= 4 * smallest:
                return point, min(step * min(measures.factor(), growth), largest)
            step *= min(measures.factor(), 0.7)
            reason = "the curve turns too sharply"
        else:
            reason = correction.failure
            poor = ERROR < correction.moved < np.inf
            step *= np.clip((correction.moved / ERROR) ** -POWER, 0.2, 0.6) if poor else 0.35
        growth = 0.8  # the curve is getting harder: the next step had better be shorter too
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
    held = _first_bound_beyond(recent, guess, bounds, target, SLACK)
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
        place = _arclength_at(recent, index, bound, target)
        guess = hermite(recent, place)[0]
        guess = curve.aligned(guess, last.z)
        guess[index] = bound
        row = np.zeros_like(row)
        row[index] = np.sign(bound - last.z[index]) or 1.0
        expected = derivatives(curve, recent, place)
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
    slack: float = 0.0,
) -> tuple[int, float] | None:
    """Return the component and the bound that the curve passes first on its way to z, if any."""
    passed = [
        (index, low if z[index] < low else high)
        for index, low, high in bounds
        if not low - slack <= z[index] <= high + slack
    ]
    return min(
        passed, key=lambda item: _arclength_at(recent, item[0], item[1], target), default=None
    )


def _correct(
    curve: Curve[P], guess: Array, row: Array, settings: Stepping, expected: Linearised | None
) -> Correction:
    tolerance, iterations = settings.newton.tolerance, settings.newton.iterations
    reach = 2 * REJECT * ERROR * settings.coarse
    return correct(curve, guess, row, tolerance, iterations, reach, expected)


def _arclength_at(recent: list[P], index: int, bound: float, beyond: float) -> float:
    """Bisect for where a component of the prediction reaches a bound."""
    near, far = recent[-1].arclength, beyond
    rising = hermite(recent, far)[0][index] > bound
    for _ in range(GUESSES):
        middle = 0.5 * (near + far)
        if (hermite(recent, middle)[0][index] > bound) == rising:
            far = middle
        else:
            near = middle
    return far


def _measure(
    curve: Curve[P], recent: list[P], point: P, correction: Correction, settings: Stepping
) -> _Measures:
    values = np.array([item.values for item in recent])
    weights = lagrange([item.arclength for item in recent], point.arclength)
    errors, size = np.abs(point.values - weights @ values), np.abs(values).max(axis=0)
    size = np.maximum(np.maximum(size, np.abs(point.values)), curve.noise)
    measures = _Measures(
        max(correction.distance, 1e-12) / (ERROR * settings.coarse),
        angle_between(recent[-1].tangent, point.tangent) / settings.steps.turn,
        0.0 if len(recent) == 1 else _drift(errors / size, settings),  # of one nothing is expected
    )
    if not measures.follows_tests:
        return measures
    # How they are foreseen better, and whether they matter, takes longer to see.
    drift, foreseen = measures.drift, curve.foreseen(recent, weights[None])
    if foreseen is not None:
        errors = np.fmin(errors, np.abs(point.values - foreseen[0]))
        lines = LINES * min(1.0, measures.error / STRAIGHT)
        drift = max(_drift(errors / size, settings), lines * drift)
    return replace(measures, drift=min(drift, contraction_drift(recent, point) / settings.coarse))


def _drift(errors: Array, settings: Stepping) -> float:
    """Return the largest relative error of the expected test functions, relative to its aim."""
    # A function may not be defined everywhere.
    return float(np.nan_to_num(errors).max(initial=0.0)) / (DRIFT * settings.coarse)
