"""Where on a branch a user's event happens."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from slipfold.branches.event import Event
from slipfold.continuation.interpolation import polynomial, well_spaced
from slipfold.continuation.locate import insert, locate, orbit_at
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.extrema import find_extrema
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["event_function", "find_events"]

DEPTH = 6
"""An interval is divided this often."""

TOUCH = 0.3
"""A function that falls between two points to this share of its values there is looked at."""


def find_events(
    problem: PeriodicProblem,
    known: list[OrbitPoint],
    before: OrbitPoint,
    point: OrbitPoint,
    events: Sequence[Event],
) -> list[tuple[Event, OrbitPoint]]:
    """Locate the events between two points, in order of arclength.

    Parameters
    ----------
    problem
        The boundary-value problem.
    known
        Points of the branch in order; grows.
    before, point
        Neighbouring points.
    events
        The user's events.
    """
    found = []
    for event in events:
        function = event_function(problem, event)
        found += [(event, at) for at in _crossings(problem, known, before, point, function)]
    return sorted(found, key=lambda pair: pair[1].arclength)


def _crossings(
    problem: PeriodicProblem,
    known: list[OrbitPoint],
    a: OrbitPoint,
    b: OrbitPoint,
    function: Callable[[OrbitPoint], float],
    depth: int = 0,
) -> list[OrbitPoint]:
    """Find all zeros between two points, also two that leave no sign change at the ends.

    The function is interpolated; where it may reach zero in between, the orbit there is computed
    and both halves are searched.
    """
    f_a, f_b = function(a), function(b)
    near = well_spaced(known, a.arclength, b.arclength, 4)
    where = np.array([item.arclength for item in near])
    grid = np.linspace(a.arclength, b.arclength, 34)[1:-1]
    inner = polynomial(where, np.array([function(item) for item in near]), grid)
    inner = inner if f_a > 0 else -inner
    lowest = int(inner.argmin())
    if f_a * f_b > 0 and depth < DEPTH and inner[lowest] < TOUCH * min(abs(f_a), abs(f_b)):
        middle = orbit_at(problem, known, float(grid[lowest]))
        insert(known, middle)
        left = _crossings(problem, known, a, middle, function, depth + 1)
        return left + _crossings(problem, known, middle, b, function, depth + 1)
    if f_b == 0 and f_a != 0:
        return [b]
    return [locate(problem, known, a, b, function)] if f_a * f_b < 0 else []


def event_function(problem: PeriodicProblem, event: Event) -> Callable[[OrbitPoint], float]:
    """Return the function of a point that is zero at an event.

    Parameters
    ----------
    problem
        The boundary-value problem.
    event
        The event.
    """
    if event.measure == "parameter":
        return lambda point: problem.value(point.z) - event.value

    def function(point: OrbitPoint) -> float:
        extrema = find_extrema(
            problem.model,
            problem.vector(point.z)[None],
            problem.nodes(point.z)[None],
            problem.period,
        )
        low, high = extrema.of(event.name)
        measured = {"max": high, "min": low, "peak_to_peak": high - low}[event.measure]
        return float(measured[0]) - event.value

    return function
