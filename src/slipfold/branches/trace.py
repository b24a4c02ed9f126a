"""One branch from its first point to its end, with everything found on the way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from slipfold.branches.branch import End
from slipfold.branches.closing import (
    Birth,
    birth_point,
    close_on_parent,
    has_copy,
    meets_its_copy,
    return_to_start,
    step_beside_parent,
)
from slipfold.branches.detection import find_bifurcations
from slipfold.branches.edge import EDGE, end_on_edge
from slipfold.branches.ending import (
    cut_at_event,
    cut_at_limit,
    cut_at_span,
    failure_end,
    family_end,
    span_end,
    unresolved_end,
)
from slipfold.branches.event import Event
from slipfold.branches.event_location import find_events
from slipfold.branches.homoclinic import homoclinic_end, nears_homoclinic
from slipfold.branches.settings import Settings
from slipfold.continuation.locate import lost_reason
from slipfold.continuation.search import Found
from slipfold.continuation.walk import Failure, walk
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["BIRTH", "CLOSED", "MEMORY", "RESOLVED", "RETREAT", "Trace", "trace_branch"]

BIRTH = 3e-3
"""First step away from where another curve passes, in scaled states: this one is singular there."""

FIRST = 0.02
"""First step of a response."""

MEMORY = 6
"""Points behind the current one that serve interpolation."""

CLOSED = "the branch closed on itself"
"""How a closed curve ends."""

REACH = 1.0
"""Steps are shorter, so a cycle whose duration and parameter differ by more is not the next."""

SAME = 1e-5
"""Two branch points this close are one: each is known to 1e-9 or better."""

RETREAT = 0.3
"""Share of a step that is taken instead where the branch between its ends was not found."""

RESOLVED = 1e7
"""Largest multiplier beside which those near the unit circle are still known to five digits."""


@dataclass(eq=False)
class Trace:
    """A branch while it is followed.

    Parameters
    ----------
    problem
        The boundary-value problem.
    points
        Accepted points.
    departs
        Whether the branch begins where another one passes.
    births
        Known places where branches begin: this one may end there.
    found
        Bifurcations, in order.
    events
        The user's events and their points, in order.
    end
        Why it ended; None while it goes on.
    reached
        Where it ended, if another branch begins there: none or one, two if it has two ends.
    """

    problem: PeriodicProblem
    points: list[OrbitPoint]
    departs: bool = False
    births: Sequence[Birth] = ()
    found: list[Found] = field(default_factory=list)
    events: list[tuple[Event, OrbitPoint]] = field(default_factory=list)
    end: End | None = None
    reached: tuple[Birth, ...] = ()


def trace_branch(
    problem: PeriodicProblem,
    start: OrbitPoint,
    span: tuple[float, float],
    settings: Settings,
    *,
    departs: bool = False,
    births: Sequence[Birth] = (),
    events: Sequence[Event] = (),
    watch: Callable[[Trace], None] = lambda trace: None,
) -> Trace:
    """Follow a branch to its end.

    Parameters
    ----------
    problem
        The boundary-value problem.
    start
        First point.
    span
        The branch ends where the parameter leaves this interval.
    settings
        Options.
    departs
        Whether the branch begins where another one passes.
    births
        Known places where branches begin: this one may end there.
    events
        Values to be located.
    watch
        Called after every point.

    Returns
    -------
    Trace
        With `end` set.
    """
    trace = Trace(problem, [start], departs, births)
    try:
        step: float | None = _first_step(problem, start, settings) if departs else FIRST
        if departs and _leaves_at_once(problem, start, step or 0.0, span, settings):
            trace.end, step = span_end(problem, start), None
        while step is not None:
            step = _follow(trace, step, span, settings, events, watch)
    except KeyboardInterrupt:
        value = problem.value(trace.points[-1].z)
        trace.end = End(
            "interrupted",
            f"interrupted at {problem.vary} = {value:.6g}; what was found before is kept",
            value,
        )
    return trace


def _follow(
    trace: Trace,
    first: float,
    span: tuple[float, float],
    settings: Settings,
    events: Sequence[Event],
    watch: Callable[[Trace], None],
) -> float | None:
    """Follow the branch until it ends; return None then.

    Where an orbit between two points cannot be found, the branch is not known well enough there:
    the last step is undone, and a shorter one to take instead is returned.
    """
    problem = trace.problem
    cap = partial(step_beside_parent, problem) if has_copy(problem) else None
    for item in walk(problem, trace.points, first, problem.bounds(span), settings, cap):
        before = trace.points[-1]
        if isinstance(item, Failure):
            _give_up(trace, item, span, settings)
            return None
        if np.abs(item.multipliers).max() > RESOLVED:
            trace.end = unresolved_end(problem, item, nears_homoclinic(problem, trace.points))
            return None
        try:
            _extend(trace, item, span, events)
        except BREAKDOWNS as error:
            step = RETREAT * (item.arclength - before.arclength)
            if step < settings.steps.smallest:
                _give_up(trace, Failure("failed", lost_reason(error)), span, settings)
                return None
            return step
        if trace.end is None:
            trace.end = homoclinic_end(problem, trace.points, settings.largest_duration)
        if trace.end is None:
            trace.end = family_end(problem, trace.points)
        watch(trace)
        if trace.end is not None:
            return None
    trace.end = span_end(problem, trace.points[-1])
    return None


def _give_up(trace: Trace, failure: Failure, span: tuple[float, float], settings: Settings) -> None:
    """End a branch that cannot be followed: where it failed, or on the end of the span."""
    problem = trace.problem
    try:
        ending = end_on_edge(problem, trace.points, span, settings)
    except BREAKDOWNS:
        ending = None
    if failure.kind != "failed" or ending is None:
        clause = nears_homoclinic(problem, trace.points)
        trace.end = failure_end(problem, trace.points[-1], failure, clause)
        return
    trace.points, found, trace.end = ending
    sure = trace.points[-2].arclength
    trace.found = [item for item in trace.found if item.point.arclength <= sure] + found
    trace.events = [item for item in trace.events if item[1].arclength <= sure]


def _first_step(problem: PeriodicProblem, start: OrbitPoint, settings: Settings) -> float:
    """Leave another branch by a step so short that nothing else can happen within it.

    All multipliers of the orbit but the critical one are near those where the branches meet, so the
    number outside the circle may differ by that one alone; else the step is shortened.
    """
    others = np.delete(start.multipliers, np.abs(start.multipliers - 1).argmin())
    outside = int(np.count_nonzero(np.abs(others) > 1))
    step = BIRTH
    for _ in range(6):
        first = next(iter(walk(problem, [start], step, (), settings)))
        if not isinstance(first, Failure) and first.unstable in (outside, outside + 1):
            return step
        step /= 4
    return BIRTH


def _leaves_at_once(
    problem: PeriodicProblem,
    start: OrbitPoint,
    step: float,
    span: tuple[float, float],
    settings: Settings,
) -> bool:
    """Whether a branch that begins on the edge of the span lies beyond it."""
    ends = problem.bounds(span)[0][1:]
    if min(abs(start.z[-1] - end) for end in ends) > EDGE:
        return False
    first = next(iter(walk(problem, [start], step, (), settings)))
    return isinstance(first, Failure) or not _inside(problem, first, span)


def _inside(problem: PeriodicProblem, point: OrbitPoint, span: tuple[float, float]) -> bool:
    return min(span) <= problem.value(point.z) <= max(span)


def _extend(
    trace: Trace, point: OrbitPoint, span: tuple[float, float], events: Sequence[Event]
) -> None:
    """Add a point and all that lies between it and the one before."""
    problem, before, end = trace.problem, trace.points[-1], None
    born = trace.departs and len(trace.points) == 1
    known = [*trace.points[-MEMORY:], point]
    reached = None
    if has_copy(problem) and not born and meets_its_copy(problem, before, point):
        point, end, reached = close_on_parent(problem, known, before, point, trace.births)
    elif not trace.departs:
        closing = return_to_start(problem, _begun_alike(trace), point)
        if closing is not None:
            point = closing
            end = End("closed", CLOSED, problem.value(point.z))
    happened: list[tuple[Event, OrbitPoint]] = []
    limit = cut_at_limit(problem, known, before, point)
    if limit is not None and limit[0].arclength <= point.arclength:
        point, end = limit[0], End("limit", limit[1], problem.value(limit[0].z))
    stop = cut_at_event(problem, known, before, point, events)
    if stop is not None:
        point, end = stop[:2]
        happened.append((stop[2], point))
    known[:] = [item for item in known if item.arclength < point.arclength]
    known.append(point)
    found = [] if born or point is before else find_bifurcations(problem, known, before, point)
    left = [item for item in found if not _inside(problem, item.point, span)]
    if left:  # the branch turns back outside the span: it ends where it leaves
        point, end = cut_at_span(problem, known, before, left[0].point, span)
        found = [item for item in found if item.point.arclength < point.arclength]
    again = _start_again(trace, found)
    if again is not None:  # round a closed curve
        point = again
        end = End("closed", CLOSED, problem.value(point.z))
        found = [item for item in found if item.point.arclength < point.arclength]
        known[:] = [*(item for item in known if item.arclength < point.arclength), point]
    passing = [event for event in events if not event.stop]
    happened = find_events(problem, known, before, point, passing) + happened
    # Nothing is kept unless all of it was found.
    trace.found += found
    trace.events += happened
    if point is not before:
        trace.points.append(point)
    trace.end = end
    if reached is not None and end is not None and end.kind == "closed":
        trace.reached = (reached,)
        trace.points.append(birth_point(problem, point, reached))


def _begun_alike(trace: Trace) -> list[OrbitPoint]:
    """Return the points with the first one begun where it lies nearest to the last.

    Round a closed curve, cycles come back begun elsewhere.
    """
    problem, first, last = trace.problem, trace.points[0], trace.points[-1]
    free = slice(problem.size, None)
    if problem.kind != "cycle" or np.linalg.norm(first.z[free] - last.z[free]) > REACH:
        return trace.points
    return [replace(first, z=problem.in_phase(first.z, last.z)), *trace.points[1:]]


def _start_again(trace: Trace, found: Sequence[Found]) -> OrbitPoint | None:
    """Return the branch point that the branch began at, if it comes to it again."""
    if not trace.departs:
        return None
    problem, start = trace.problem, trace.points[0]
    for item in found:
        if item.type == "BP" and problem.distance(start.z, item.point.z) < SAME:
            return item.point
    return None
