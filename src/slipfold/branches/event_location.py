"""Where on a branch a user's event happens."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from slipfold.branches.event import Event
from slipfold.branches.location import locate
from slipfold.branches.point import Point
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.extrema import find_extrema

__all__ = ["event_function", "find_events"]


def find_events(
    problem: PeriodicProblem,
    known: list[Point],
    before: Point,
    point: Point,
    events: Sequence[Event],
) -> list[tuple[Event, Point]]:
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
        if (function(before) > 0) != (function(point) > 0):
            found.append((event, locate(problem, known, before, point, function)))
    return sorted(found, key=lambda pair: pair[1].arclength)


def event_function(problem: PeriodicProblem, event: Event) -> Callable[[Point], float]:
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

    def function(point: Point) -> float:
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
