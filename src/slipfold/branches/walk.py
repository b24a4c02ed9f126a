"""Pseudo-arclength continuation: one point after the other, with steps that fit the curve."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.interpolation import POINTS, arc_between, hermite, polynomial
from slipfold.branches.point import Point, corrected_point
from slipfold.branches.settings import Settings
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.newton import Correction, correct

__all__ = ["Failure", "walk"]

Array = NDArray[np.float64]

ERROR = 3e-3
"""Distance between predicted and corrected orbit that the steps aim at, in scaled variables."""

DRIFT = 0.15
"""Error of the extrapolated test functions that the steps aim at, relative to their size.

Between points they are then known ten times better still, and the search for bifurcations between
points rests on it."""

POWER = 0.22
"""The prediction's error grows with the step to the power of 1/0.22 or so."""

REJECT = 4.0
"""A step whose measures exceed their aims by this factor is taken again, shorter."""


@dataclass(frozen=True)
class Failure:
    """Why no further point was found.

    Parameters
    ----------
    kind
        ``"failed"`` or ``"points"``.
    reason
        A sentence.
    """

    kind: str
    reason: str


@dataclass(frozen=True)
class _Measures:
    """How well a step fitted: error and drift relative to their aims, turn to its cap."""

    error: float
    turn: float
    drift: float

    @property
    def fits(self) -> bool:
        return self.turn <= 1 and max(self.error, self.drift) <= REJECT

    def factor(self) -> float:
        """By how much the next step may be longer.

        The turn grows with the first power of the step, the drift with the second to third.
        """
        wanted = min(self.error**-POWER, 0.7 / max(self.turn, 1e-3), max(self.drift, 1e-6) ** -0.4)
        return float(np.clip(0.9 * wanted, 0.2, 2.5))


def walk(
    problem: PeriodicProblem,
    start: Sequence[Point],
    first_step: float,
    span: tuple[float, float],
    settings: Settings,
    cap: Callable[[Point], float] | None = None,
) -> Iterator[Point | Failure]:
    """Follow a branch from a point until the parameter leaves an interval.

    Parameters
    ----------
    problem
        The boundary-value problem.
    start
        The first point, or the last few of a branch that is taken up again; the tangent of the
        last gives the direction.
    first_step
        First step in arclength.
    span
        The branch ends where the parameter leaves this interval, on either side.
    settings
        Steps and Newton's method.
    cap
        Longest step that may be taken from a point, besides the settings' own.

    Yields
    ------
    Point
        The next point; the last one lies exactly on the end of the interval.
    Failure
        In its place, once, if there is no next point.
    """
    recent = list(start)[-POINTS:]
    step = min(first_step, settings.steps.largest)
    bounds = sorted(value / problem.width for value in span)
    for _ in range(settings.steps.points):
        if cap is not None:
            step = min(step, cap(recent[-1]))
        point, step = _next_point(problem, recent, step, bounds, settings)
        if isinstance(point, Failure):
            yield point
            return
        yield point
        if point.z[-1] in bounds:
            return
        recent = [*recent, point][-POINTS:]
    yield Failure("points", f"{settings.steps.points} points were not enough; allow more points")


def _next_point(
    problem: PeriodicProblem,
    recent: list[Point],
    step: float,
    bounds: list[float],
    settings: Settings,
) -> tuple[Point | Failure, float]:
    """Take one step, shortening it until it fits; return the step to try next as well."""
    smallest, largest = settings.steps.smallest, settings.steps.largest
    reason, growth = "the branch turns too sharply", 2.5
    while step >= smallest:
        correction, point = _try(problem, recent, step, bounds, settings)
        if point is not None:
            measures = _measure(recent, point, correction, settings)
            if measures.fits or step <= 4 * smallest:
                return point, min(step * min(measures.factor(), growth), largest)
            step *= min(measures.factor(), 0.7)
            reason = "the branch turns too sharply"
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
    problem: PeriodicProblem,
    recent: list[Point],
    step: float,
    bounds: list[float],
    settings: Settings,
) -> tuple[Correction, Point | None]:
    """Predict and correct; a prediction beyond the interval is corrected on its end."""
    last = recent[-1]
    target = last.arclength + step
    guess, row = hermite(recent, target)
    outside = _bound_beyond(guess, bounds)
    if outside is not None:
        guess = hermite(recent, _arclength_at(recent, outside, target))[0]
    else:
        correction = _correct(problem, guess, row, settings)
        if correction.converged:
            outside = _bound_beyond(correction.z, bounds)
            guess = correction.z.copy()
    if outside is not None:
        guess[-1] = outside
        row = np.zeros_like(row)
        row[-1] = np.sign(outside - last.z[-1]) or 1.0
        correction = _correct(problem, guess, row, settings)
    if not correction.converged:
        return correction, None
    if outside is not None:
        correction.z[-1] = outside  # exactly, whatever rounding did
    point = corrected_point(correction, target)
    return correction, replace(point, arclength=last.arclength + arc_between(last, point))


def _bound_beyond(z: Array, bounds: list[float]) -> float | None:
    """Return the end of the interval that the parameter has passed, if it has."""
    lower, upper = bounds
    if z[-1] < lower:
        return lower
    return upper if z[-1] > upper else None


def _correct(problem: PeriodicProblem, guess: Array, row: Array, settings: Settings) -> Correction:
    newton = settings.newton
    return correct(
        problem, guess, row, newton.tolerance, newton.iterations, reach=2 * REJECT * ERROR
    )


def _arclength_at(recent: list[Point], bound: float, beyond: float) -> float:
    """Bisect for where the predicted parameter reaches a bound."""
    near, far = recent[-1].arclength, beyond
    rising = hermite(recent, far)[0][-1] > bound
    for _ in range(40):
        middle = 0.5 * (near + far)
        if (hermite(recent, middle)[0][-1] > bound) == rising:
            far = middle
        else:
            near = middle
    return far


def _measure(
    recent: list[Point], point: Point, correction: Correction, settings: Settings
) -> _Measures:
    turn = float(np.arccos(np.clip(recent[-1].tangent @ point.tangent, -1.0, 1.0)))
    return _Measures(
        max(correction.distance, 1e-12) / ERROR,
        turn / settings.steps.turn,
        _drift(recent, point) / DRIFT,
    )


def _drift(recent: list[Point], point: Point) -> float:
    """Error of the extrapolated test functions, relative to their largest value nearby."""
    if len(recent) == 1:  # nothing to extrapolate from
        return 0.0
    where = np.array([item.arclength for item in recent])
    values = np.array([list(item.tests.values()) for item in recent])
    found = np.array(list(point.tests.values()))
    expected = polynomial(where, values, np.array([point.arclength]))[0]
    size = np.maximum(np.abs(values).max(axis=0), np.abs(found))
    return float((np.abs(found - expected) / np.maximum(size, 1e-12)).max())
