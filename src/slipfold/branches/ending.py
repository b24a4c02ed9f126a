"""Where a branch has to end: limits of the model, the span, a failure, a user's event."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipfold.branches.branch import End
from slipfold.branches.event import Event
from slipfold.branches.event_location import event_function
from slipfold.continuation.locate import locate
from slipfold.continuation.walk import Failure
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.limits import limit_margins
from slipfold.orbits.orbit_point import OrbitPoint
from slipfold.orbits.shooting import Shooting

__all__ = [
    "cut_at_event",
    "cut_at_limit",
    "failure_end",
    "failure_reason",
    "family_end",
    "span_end",
    "unresolved_end",
    "unresolved_reason",
]

FAMILY = 200
"""Orbits with one value of the parameter after which a family is followed no farther."""

STANDS_STILL = 1e-9
"""Change of the parameter, in spans, that is none: special points are located to less."""

CLOSE_TO_LIMIT = 5.0
"""A branch lost with an output within this factor of its bound ends because of that limit."""

LIMIT_CLOSE = 1e-9
"""Arclength to which the end of the model is found: it is a convention within 1e-4 anyway."""


def cut_at_limit(
    problem: Shooting, known: list[OrbitPoint], before: OrbitPoint, point: OrbitPoint
) -> tuple[OrbitPoint, str] | None:
    """Return where between two points the model ceases to be valid, and why, if it does.

    Parameters
    ----------
    problem
        The equations.
    known
        Points of the curve in order; grows.
    before, point
        Neighbouring points.
    """
    cuts = []
    for index in np.flatnonzero(~(limit_margins(problem, point.z) > 0)):
        limit = problem.model.limits[index]

        def margin(item: OrbitPoint, index: int = int(index)) -> float:
            return float(limit_margins(problem, item.z)[index])

        at = locate(problem, known, before, point, margin, LIMIT_CLOSE)
        cuts.append((at, limit.reason.format(value=margin(at) + limit.bound)))
    return min(cuts, key=lambda cut: cut[0].arclength, default=None)


def cut_at_event(
    problem: PeriodicProblem,
    known: list[OrbitPoint],
    before: OrbitPoint,
    point: OrbitPoint,
    events: Sequence[Event],
) -> tuple[OrbitPoint, End, Event] | None:
    """Return where between two points an event stops the branch, and which, if one does.

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
    cuts = []
    for event in events:
        function = event_function(problem, event)
        if event.stop and (function(before) > 0) != (function(point) > 0):
            at = locate(problem, known, before, point, function)
            reason = f"stopped as asked: {event.measure} of {event.name} is {event.value:g}"
            cuts.append((at, End("event", reason, problem.value(at.z)), event))
    return min(cuts, key=lambda cut: cut[0].arclength, default=None)


def cut_at_span(
    problem: PeriodicProblem,
    known: list[OrbitPoint],
    before: OrbitPoint,
    outside: OrbitPoint,
    span: tuple[float, float],
) -> tuple[OrbitPoint, End]:
    """Return where a branch leaves the span before it turns back.

    Parameters
    ----------
    problem
        The boundary-value problem.
    known
        Points of the branch in order; grows.
    before
        A point inside the span.
    outside
        A later one outside.
    span
        The span.
    """
    bound = max(span) if problem.value(outside.z) > max(span) else min(span)
    at = locate(problem, known, before, outside, lambda item: problem.value(item.z) - bound)
    return at, span_end(problem, at)


def failure_end(
    problem: PeriodicProblem, last: OrbitPoint, failure: Failure, clause: str = ""
) -> End:
    """Say where a branch failed, and how far the model's limits are there.

    Parameters
    ----------
    problem
        The boundary-value problem.
    last
        The last point.
    failure
        Why there is no next one.
    clause
        What is known of where the branch leads, as a clause: it is then the reason.
    """
    value = problem.value(last.z)
    kind, reason = failure_reason(problem, last, failure)
    if kind == "failed" and clause:
        return End("homoclinic", f"{clause} (no cycle was found any nearer to it)", value)
    return End(kind, f"{reason}; {clause}" if clause else reason, value)


def family_end(problem: PeriodicProblem, points: Sequence[OrbitPoint]) -> End | None:
    """Return the end of a branch along which the parameter stands still, None if it goes on.

    The cycles round a centre form such a family. It may be followed as far as one likes, and
    nothing new happens on it.

    Parameters
    ----------
    problem
        The boundary-value problem.
    points
        Points of the branch.
    """
    if len(points) <= FAMILY:
        return None
    values = [point.z[-1] for point in points[-FAMILY:]]
    if max(values) - min(values) > STANDS_STILL:
        return None
    value = problem.value(points[-1].z)
    shown = 0.0 if abs(value) < STANDS_STILL * problem.width else value
    reason = (
        f"{FAMILY} orbits have the same {problem.vary} = {shown:.9g}: they are a family, as round "
        "a centre, that goes on; stop it at an amplitude by an event"
    )
    return End("family", reason, value)


def failure_reason(problem: Shooting, last: OrbitPoint, failure: Failure) -> tuple[str, str]:
    """Return the kind and the sentence of a failure, with how far the model's limits are.

    Parameters
    ----------
    problem
        The equations.
    last
        The last point.
    failure
        Why there is no next one.
    """
    if failure.kind != "failed":
        return failure.kind, failure.reason
    try:
        margins = limit_margins(problem, last.z)
    except BREAKDOWNS:
        return failure.kind, failure.reason
    for limit, margin in zip(problem.model.limits, margins, strict=True):
        if margin < (CLOSE_TO_LIMIT - 1) * limit.bound:
            reason = limit.reason.format(value=margin + limit.bound)
            return "limit", f"{reason} (no orbit was found any nearer to the limit)"
    limits = ", ".join(
        f"{limit.output} = {margin + limit.bound:.3g} (limit {limit.bound:g})"
        for limit, margin in zip(problem.model.limits, margins, strict=True)
    )
    there = f"; there {limits}" if limits else ""
    return "failed", f"{failure.reason}{there}"


def unresolved_end(problem: PeriodicProblem, point: OrbitPoint, clause: str = "") -> End:
    """Say that an orbit is too unstable for its multipliers to be known.

    Parameters
    ----------
    problem
        The boundary-value problem.
    point
        The orbit.
    clause
        What is known of where the branch leads, as a clause: it is then the reason.
    """
    value, reason = problem.value(point.z), unresolved_reason(point)
    if clause:
        return End("homoclinic", f"{clause}; {reason}", value)
    return End("unresolved", reason, value)


def unresolved_reason(point: OrbitPoint) -> str:
    """Return the sentence that says that an orbit is too unstable.

    Parameters
    ----------
    point
        The orbit.
    """
    return (
        f"a multiplier of {np.abs(point.multipliers).max():.1e} leaves too few digits for the "
        "others, so bifurcations could be missed beyond; the orbit is as good as unobservable there"
    )


def span_end(problem: PeriodicProblem, last: OrbitPoint) -> End:
    """Say that a branch reached the end of the span.

    Parameters
    ----------
    problem
        The boundary-value problem.
    last
        The last point.
    """
    value = problem.value(last.z)
    return End("span", f"reached the end of the span at {problem.vary} = {value:g}", value)
