"""One locus in one direction, from a point of it to its end, with everything found on the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.closing import (
    BEFORE,
    asymmetry,
    meets_its_copy,
    return_to_start,
    step_beside_parent,
)
from slipfold.branches.ending import cut_at_limit, failure_reason, unresolved_reason
from slipfold.branches.settings import Settings
from slipfold.branches.trace import BIRTH, MEMORY, RESOLVED, RETREAT
from slipfold.continuation.locate import lost_reason, orbit_at
from slipfold.continuation.search import Found
from slipfold.continuation.walk import Failure, walk
from slipfold.errors import BREAKDOWNS
from slipfold.loci.detection import find_special_points
from slipfold.loci.locus import LocusEnd
from slipfold.loci.locus_problem import LocusProblem
from slipfold.loci.window import Window
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["LocusTrace", "trace_locus"]

Array = NDArray[np.float64]

FIRST = 0.01
"""First step from a regular point."""

AROUND = 1.5
"""Steps within which a closed locus may pass its first point again."""

EDGE = 1e-9
"""Distance from the window's edge, in its own width, that counts as none."""


@dataclass(eq=False)
class LocusTrace:
    """A locus while it is followed.

    Parameters
    ----------
    problem
        Its equations.
    points
        Accepted points.
    born
        Whether the first point is one of codimension two, which is not to be found again.
    found
        Special points, in order.
    end
        Why it ended; None while it goes on.
    at_parent
        Whether it ended where its orbits become those of half the period, or equilibria.
    """

    problem: LocusProblem
    points: list[OrbitPoint]
    born: bool = False
    found: list[Found] = field(default_factory=list)
    end: LocusEnd | None = None
    at_parent: bool = False


def trace_locus(
    problem: LocusProblem,
    start: OrbitPoint,
    window: Window,
    settings: Settings,
    *,
    born: bool = False,
    watch: Callable[[LocusTrace], None] = lambda trace: None,
) -> LocusTrace:
    """Follow a locus in the direction of its tangent, to its end.

    Parameters
    ----------
    problem
        The equations of the locus.
    start
        First point.
    window
        The locus ends where a parameter leaves its interval.
    settings
        Options.
    born
        Whether the locus begins at a point of codimension two, on another locus.
    watch
        Called after every point; may raise `KeyboardInterrupt`.

    Returns
    -------
    LocusTrace
        With `end` set.
    """
    trace = LocusTrace(problem, [start], born)
    step: float | None = BIRTH if born else FIRST
    leaves = _bound_left(problem, start, window)
    if leaves is not None:
        trace.end = _window_end(trace, leaves)
        return trace
    try:
        while step is not None:
            step = _follow(trace, step, window, settings, watch)
    except KeyboardInterrupt:
        trace.end = _end(
            trace, "interrupted", "interrupted; what was found before is kept", trace.points[-1]
        )
    return trace


def _follow(
    trace: LocusTrace,
    first: float,
    window: Window,
    settings: Settings,
    watch: Callable[[LocusTrace], None],
) -> float | None:
    """Follow the locus until it ends; return None then, or a shorter step to try instead."""
    problem = trace.problem
    bounds = problem.bounds(window)
    cap = partial(step_beside_parent, problem) if problem.ends_at_parent else None
    for item in walk(problem, trace.points, first, bounds, settings, cap):
        before = trace.points[-1]
        if isinstance(item, Failure):
            trace.end = _end(trace, *failure_reason(problem, before, item), before)
            return None
        if np.abs(item.multipliers).max() > RESOLVED:
            trace.end = _end(trace, "unresolved", unresolved_reason(item), item)
            return None
        try:
            _extend(trace, item)
        except BREAKDOWNS as error:
            step = RETREAT * (item.arclength - before.arclength)
            if step < settings.steps.smallest:
                failure = Failure("failed", lost_reason(error))
                trace.end = _end(trace, *failure_reason(problem, before, failure), before)
                return None
            return step
        watch(trace)
        if trace.end is not None:
            return None
    last = trace.points[-1]
    bounds = problem.bounds(window)
    on = [i for i, (place, low, high) in enumerate(bounds) if last.z[place] in (low, high)]
    trace.end = _window_end(trace, on[0])
    return None


def _bound_left(problem: LocusProblem, start: OrbitPoint, window: Window) -> int | None:
    """Return the parameter in which a locus that starts on the edge leaves the window at once."""
    for i, (place, low, high) in enumerate(problem.bounds(window)):
        slope = start.tangent[place]
        gap = high - start.z[place] if slope > 0 else start.z[place] - low
        if gap < EDGE and abs(slope) > EDGE:
            return i
    return None


def _window_end(trace: LocusTrace, index: int) -> LocusEnd:
    problem, last = trace.problem, trace.points[-1]
    name, value = problem.vary[index], problem.values(last.z)[index]
    return _end(trace, "window", f"left the window at {name} = {value:g}", last)


def _end(trace: LocusTrace, kind: str, reason: str, point: OrbitPoint) -> LocusEnd:
    first, second = trace.problem.values(point.z)
    return LocusEnd(kind, reason, (float(first), float(second)))


def _extend(trace: LocusTrace, point: OrbitPoint) -> None:
    """Add a point and all that lies between it and the one before."""
    problem, before = trace.problem, trace.points[-1]
    leaving = trace.born and len(trace.points) == 1
    known = [*trace.points[-MEMORY:], point]
    end: tuple[str, str] | None = None
    if not leaving and problem.ends_at_parent and meets_its_copy(problem, before, point):
        point, end = _at_parent(problem, known, before, point)
        trace.at_parent = True
    else:
        closing = return_to_start(problem, _seen_from(problem, trace.points, point), point)
        if closing is not None:
            point, end = closing, ("closed", "the locus closed on itself")
    limit = cut_at_limit(problem, known, before, point)
    if limit is not None and limit[0].arclength <= point.arclength:
        point, end = limit[0], ("limit", limit[1])
    known[:] = [item for item in known if item.arclength < point.arclength]
    known.append(point)
    found = []
    if point is not before and not leaving:
        found = find_special_points(problem, known, before, point)
    resonance = _first_resonance(problem, found)
    if resonance is not None:
        point = resonance.point
        found = [item for item in found if item.point.arclength <= point.arclength]
        end = ("codimension-2", _resonance_reason(problem, resonance))
    trace.found += found
    if point is not before:
        trace.points.append(point)
    if end is not None:
        trace.end = _end(trace, *end, point)


def _seen_from(
    problem: LocusProblem, points: list[OrbitPoint], point: OrbitPoint
) -> list[OrbitPoint]:
    """Return the points of a locus, the first begun in the phase of the last if it may be near."""
    first, last = points[0], points[-1]
    gap = float(np.linalg.norm((first.z - last.z)[problem.size :]))
    if gap > AROUND * (point.arclength - last.arclength):
        return points
    return [replace(first, z=problem.begun_near(first.z, last.z)), *points[1:]]


def _first_resonance(problem: LocusProblem, found: list[Found]) -> Found | None:
    """Return where a torus locus ends, the pair being real beyond, if it does."""
    if problem.kind != "NS":
        return None
    return next((item for item in found if item.type in ("R1", "R2")), None)


def _resonance_reason(problem: LocusProblem, found: Found) -> str:
    if problem.orbits == "equilibrium":
        return (
            "the locus ends at a Bogdanov-Takens point, BT: the equilibria beyond are neutral "
            "saddles, which are no bifurcation"
        )
    return f"the locus ends at a strong resonance, {found.type}"


def _at_parent(
    problem: LocusProblem, known: list[OrbitPoint], before: OrbitPoint, point: OrbitPoint
) -> tuple[OrbitPoint, tuple[str, str]]:
    """Go back to just before the halves of a locus' orbits become the same."""
    direction = asymmetry(problem, before.z)
    a, b = float(direction @ direction), float(direction @ asymmetry(problem, point.z))
    share = a / (a - b) if b < a else 1.0
    place = before.arclength + min(share, 1.0) * (point.arclength - before.arclength)
    doubled = problem.period % 2 == 0
    what = "become those of half the period" if doubled else "shrink to an equilibrium"
    end = ("codimension-2", f"the locus ends where its orbits {what}")
    for back in (BEFORE, 4 * BEFORE, 16 * BEFORE):
        if back < place - before.arclength:
            last = orbit_at(problem, known, place - back)
            if np.linalg.norm(asymmetry(problem, last.z)) > 0.3 * back:
                return last, end
    return before, end
