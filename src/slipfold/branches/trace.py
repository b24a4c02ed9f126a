"""One branch from its first point to its end, with everything found on the way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from slipfold.branches.branch import End
from slipfold.branches.detection import Found, find_bifurcations
from slipfold.branches.event import Event
from slipfold.branches.interpolation import POINTS, hermite, well_spaced
from slipfold.branches.location import LostBranchError, insert, locate, orbit_at
from slipfold.branches.point import Point, make_point
from slipfold.branches.settings import Settings
from slipfold.branches.walk import Failure, walk
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.extrema import find_extrema
from slipfold.orbits.limits import limit_margins

__all__ = ["Trace", "trace_branch"]

Array = NDArray[np.float64]

BIRTH = 3e-3
"""First step away from a period doubling, in scaled states: the branch is singular at zero."""

FIRST = 0.02
"""First step of a response."""

MEMORY = 6
"""Points behind the current one that serve interpolation."""

EVERYWHERE = (-np.inf, np.inf)

SAME = 1e-5
"""Two orbits this close are one; steps and orbits differ by much more."""


@dataclass(eq=False)
class Trace:
    """A branch while it is followed.

    Parameters
    ----------
    problem
        The boundary-value problem.
    points
        Accepted points.
    found
        Bifurcations, in order.
    events
        Name and point of the user's events, in order.
    end
        Why it ended; None while it goes on.
    """

    problem: PeriodicProblem
    points: list[Point]
    found: list[Found] = field(default_factory=list)
    events: list[tuple[Event, Point]] = field(default_factory=list)
    end: End | None = None


def trace_branch(
    problem: PeriodicProblem,
    start: Point,
    span: tuple[float, float],
    settings: Settings,
    *,
    doubled: bool = False,
    doublings: Sequence[tuple[PeriodicProblem, Point]] = (),
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
    doubled
        Whether the branch was born at a period doubling.
    doublings
        Known period doublings of the parent, where a doubled branch may return.
    events
        Values to be located.
    watch
        Called after every point.

    Returns
    -------
    Trace
        With `end` set.
    """
    trace = Trace(problem, [start])
    try:
        first = _first_step(problem, start, settings) if doubled else FIRST
        for item in walk(problem, start, first, span, settings):
            if isinstance(item, Failure):
                trace.end = _failure(trace, item)
                break
            _extend(trace, item, doubled, doublings, events)
            watch(trace)
            if trace.end is not None:
                break
        else:
            trace.end = _span_end(trace)
    except KeyboardInterrupt:
        value = problem.value(trace.points[-1].z)
        trace.end = End(
            "interrupted",
            f"interrupted at {problem.vary} = {value:.6g}; what was found before is kept",
            value,
        )
    return trace


def _first_step(problem: PeriodicProblem, start: Point, settings: Settings) -> float:
    """Leave a period doubling by a step so short that nothing else can happen within it.

    All multipliers of the doubled orbit but the critical one are near those of its parent, so the
    number outside the circle may differ by that one alone; else the step is shortened.
    """
    others = np.delete(start.multipliers, np.abs(start.multipliers - 1).argmin())
    outside = int(np.count_nonzero(np.abs(others) > 1))
    step = BIRTH
    for _ in range(6):
        first = next(iter(walk(problem, start, step, EVERYWHERE, settings)))
        if not isinstance(first, Failure) and first.unstable in (outside, outside + 1):
            return step
        step /= 4
    return BIRTH


def _extend(
    trace: Trace,
    point: Point,
    doubled: bool,
    doublings: Sequence[tuple[PeriodicProblem, Point]],
    events: Sequence[Event],
) -> None:
    """Add a point and all that lies between it and the one before."""
    problem, before = trace.problem, trace.points[-1]
    born = doubled and len(trace.points) == 1
    known = [*trace.points[-MEMORY:], point]
    try:
        if doubled and not born and _asymmetry(before) @ _asymmetry(point) < 0:
            point = _close_on_parent(trace, known, point, doublings)
        elif not doubled and _returns(problem, trace.points, point):
            trace.end = End("closed", "the branch closed on itself", problem.value(point.z))
        point = _stop_at_limit(trace, known, before, point)
        if not born:
            trace.found += find_bifurcations(problem, known, before, point)
        _find_events(trace, known, before, point, events)
    except LostBranchError as error:
        trace.end = End(
            "failed",
            f"the branch was lost near {problem.vary} = {problem.value(point.z):.6g}: {error}; "
            "try a smaller largest step",
            problem.value(point.z),
        )
    trace.points.append(point)
    if trace.end is not None and trace.end.kind == "closed" and doubled:
        _append_parent(trace, doublings)


# -- ends ------------------------------------------------------------------------------------


def _asymmetry(point: Point) -> Array:
    """Difference between an orbit and its copy half a period later; zero on the parent."""
    return _split(point.z)


def _split(z: Array) -> Array:
    half = (len(z) - 1) // 2
    return z[:half] - z[half:-1]


def _close_on_parent(
    trace: Trace,
    known: list[Point],
    point: Point,
    doublings: Sequence[tuple[PeriodicProblem, Point]],
) -> Point:
    """Go back to just before the branch meets its own phase-shifted copy.

    Where it does, the orbit is that of the parent's period doubling and Newton's method is
    singular, so the last regular point lies a short step before it.
    """
    problem, before = trace.problem, trace.points[-1]
    direction = _asymmetry(before)
    near = well_spaced(known, before.arclength, point.arclength, POINTS)
    root = brentq(
        lambda place: direction @ _split(hermite(near, place)[0]),
        before.arclength,
        point.arclength,
        xtol=1e-6,
    )
    length = root - before.arclength
    value = _parent_value(trace, doublings, problem.value(point.z))
    trace.end = End(
        "closed",
        f"the branch closed on its parent's period doubling at {problem.vary} = {value:.9g}",
        value,
    )
    last = orbit_at(problem, known, before.arclength + max(length - BIRTH, 0.5 * length))
    known.remove(point)
    insert(known, last)
    return last


def _parent_value(
    trace: Trace, doublings: Sequence[tuple[PeriodicProblem, Point]], value: float
) -> float:
    known = [parent.value(point.z) for parent, point in doublings]
    near = [item for item in known if abs(item - value) < 0.05 * trace.problem.width]
    return min(near, key=lambda item: abs(item - value)) if near else value


def _append_parent(trace: Trace, doublings: Sequence[tuple[PeriodicProblem, Point]]) -> None:
    """End a closed branch exactly on the parent's period doubling."""
    problem, last, end = trace.problem, trace.points[-1], trace.end
    assert end is not None  # it is closed
    for parent, point in doublings:
        if parent.value(point.z) == end.value:
            nodes = parent.nodes(point.z)[np.arange(0, 2 * parent.segments, 2) % parent.segments]
            z = problem.pack(nodes, end.value)
            length = float(np.linalg.norm(z - last.z))
            square = point.monodromy @ point.monodromy
            place = last.arclength + length
            trace.points.append(make_point(z, last.tangent, place, square, point.residual))


def _returns(problem: PeriodicProblem, points: list[Point], point: Point) -> bool:
    """Whether the last step passed the first point again."""
    first, before = points[0], points[-1]
    if len(points) < 4:
        return False
    along = (first.z - before.z) @ before.tangent
    length = point.arclength - before.arclength
    if not 0 < along < length or np.linalg.norm(first.z - before.z) > 1.5 * length:
        return False
    try:
        passed = orbit_at(problem, [*points[-2:], point], before.arclength + along)
    except LostBranchError:
        return False
    return bool(np.linalg.norm(passed.z - first.z) < SAME + 0.05 * along**2)


def _stop_at_limit(trace: Trace, known: list[Point], before: Point, point: Point) -> Point:
    """Cut the step where the model's validity ends."""
    problem = trace.problem
    margins = limit_margins(problem, point.z)
    for index in np.flatnonzero(~(margins > 0)):
        limit = problem.model.limits[index]
        at = locate(
            problem, known, before, point,
            lambda item, index=index: float(limit_margins(problem, item.z)[index]),
        )  # fmt: skip
        if at.arclength <= point.arclength:
            point = at
            value = problem.value(at.z)
            trace.end = End("limit", limit.reason.format(value=limit.bound), value)
    if point not in known:
        known[:] = [item for item in known if item.arclength < point.arclength]
        known.append(point)
    return point


def _failure(trace: Trace, failure: Failure) -> End:
    """Say where the branch stopped and which limit of the model is nearest."""
    problem, last = trace.problem, trace.points[-1]
    value = problem.value(last.z)
    limits = problem.model.limits
    margins = limit_margins(problem, last.z)
    nearest = ", ".join(
        f"{limit.output} is {margin + limit.bound:.3g} there (limit {limit.bound:g})"
        for limit, margin in zip(limits, margins, strict=True)
    )
    return End(failure.kind, f"stopped at {problem.vary} = {value:.6g}: {failure.reason}; {nearest}", value)


def _span_end(trace: Trace) -> End:
    value = trace.problem.value(trace.points[-1].z)
    return End("span", f"reached the end of the span at {trace.problem.vary} = {value:g}", value)


# -- events ----------------------------------------------------------------------------------


def _find_events(
    trace: Trace, known: list[Point], before: Point, point: Point, events: Sequence[Event]
) -> None:
    for event in events:
        function = _event_function(trace.problem, event)
        if (function(before) > 0) != (function(point) > 0):
            at = locate(trace.problem, known, before, point, function)
            trace.events.append((event, at))
            if event.stop and trace.end is None:
                value = trace.problem.value(at.z)
                trace.end = End(
                    "event", f"{event.measure} of {event.name} reached {event.value:g}", value
                )


def _event_function(problem: PeriodicProblem, event: Event) -> Callable[[Point], float]:
    if event.measure == "parameter":
        return lambda point: problem.value(point.z) - event.value

    def function(point: Point) -> float:
        extrema = find_extrema(
            problem.model, problem.vector(point.z)[None], problem.nodes(point.z)[None],
            problem.period,
        )  # fmt: skip
        low, high = extrema.of(event.name)
        measured = {"max": high, "min": low, "peak_to_peak": high - low}[event.measure]
        return float(measured[0]) - event.value

    return function
