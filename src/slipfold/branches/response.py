"""The whole response: the branch of period 1 and every branch of doubled period that leaves it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch, End
from slipfold.branches.describe import describe_bifurcation, describe_event
from slipfold.branches.event import Event
from slipfold.branches.point import Point
from slipfold.branches.progress import Observer, Progress
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.branches.start import (
    doubled_start,
    equilibrium_start,
    hopf_start,
    orbit_start,
    response_start,
)
from slipfold.branches.trace import Trace, trace_branch
from slipfold.errors import InputError
from slipfold.flow import flow_of
from slipfold.models.model import Model
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.cycle_problem import CycleProblem
from slipfold.orbits.periodic_orbit import PeriodicOrbit

__all__ = ["trace_response"]

BIRTHS = ("PD", "HB")
"""Types of special points at which branches of longer period or of cycles are born."""

MATCH = 1e-7
"""Two values of a parameter this close, in spans, belong to one period doubling."""


def trace_response(
    model: Model,
    vary: str,
    span: tuple[float, float],
    *,
    settings: Settings | None = None,
    events: Sequence[Event] = (),
    observer: Observer | None = None,
    start: PeriodicOrbit | None = None,
) -> tuple[Branch, ...]:
    """Follow the periodic response in one parameter, and all branches of doubled period.

    Of an autonomous model the equilibrium is followed, with its folds and Hopf points.

    Parameters
    ----------
    model
        The model; its value of `vary` plays no part.
    vary
        Name of the parameter.
    span
        First and last value of the parameter; may descend.
    settings
        Options of continuation.
    events
        Values to be located.
    observer
        Called after every point; may raise `KeyboardInterrupt` to stop with what is done.
    start
        An orbit at the first value of the span; it is followed instead.

    Returns
    -------
    tuple of Branch
        The branch of period 1 first, then doubled branches in the order of their birth.

    Raises
    ------
    InputError
        If the input cannot be used or no orbit is found at the start of the span.
    """
    settings = settings or Settings()
    model, first, last = _checked(model, vary, span, events)
    branches: list[Branch] = []
    waiting = [_first(model, vary, first, last, start)]
    while waiting:
        item = waiting.pop(0)
        if item.is_reached(branches):
            continue
        trace = _follow(item, len(branches) + 1, last, first, settings, events, observer)
        branch, doublings = _as_branch(trace, item, len(branches) + 1)
        branches.append(branch)
        _link(branches, item, branch)
        if branch.stopped.kind == "interrupted":
            break
        if branch.kind == "equilibrium" or 2 * branch.period <= settings.largest_period:
            waiting += [
                _Waiting(
                    trace.problem,
                    point,
                    End("born", f"born at {vary} = {special.value:.9g}", special.value),
                    (branch.id, index),
                    tuple((trace.problem, other) for _, _, other in doublings),
                )
                for index, special, point in doublings
            ]
    return tuple(branches)


class _Waiting:
    """A branch still to be followed."""

    def __init__(
        self,
        problem: PeriodicProblem,
        start: Point,
        begun: End,
        parent: tuple[int, int] | None,
        doublings: tuple[tuple[PeriodicProblem, Point], ...],
    ) -> None:
        self.problem = problem
        self.start = start
        self.begun = begun
        self.parent = parent
        self.doublings = doublings

    def is_reached(self, branches: list[Branch]) -> bool:
        """Whether a branch that is known ended on this period doubling."""
        if self.parent is None:
            return False
        parent, index = self.parent
        return branches[parent - 1].special[index].leads_to is not None


def _checked(
    model: Model, vary: str, span: tuple[float, float], events: Sequence[Event]
) -> tuple[Model, float, float]:
    parameter = model.parameter(vary)
    first, last = (parameter.check(float(value)) for value in span)
    if first == last:
        raise InputError(
            f"the span of {vary} from {first:g} to {last:g} is empty; give two different values"
        )
    outputs = flow_of(model).output_names
    for event in events:
        if event.measure == "parameter":
            if event.name != vary:
                raise InputError(
                    f"event on parameter {event.name!r} cannot occur; the response varies {vary}"
                )
        elif event.name not in outputs:
            raise InputError(
                f"no output {event.name!r} for an event; there are {', '.join(outputs)}"
            )
    return model.replace(**{vary: first}), first, last


def _first(
    model: Model, vary: str, first: float, last: float, orbit: PeriodicOrbit | None
) -> _Waiting:
    """Return the first branch: from the orbit given, or the response, or the equilibrium."""
    if orbit is not None:
        problem, start = orbit_start(orbit, vary, first, last)
        return _Waiting(problem, start, _span_begin(vary, first), None, ())
    begin = _first_point if model.forced else _first_equilibrium
    return _Waiting(*begin(model, vary, first, last), None, ())


def _first_point(
    model: Model, vary: str, first: float, last: float
) -> tuple[PeriodicProblem, Point, End]:
    """Start at the first value of the span, or at the last where the first has no response."""
    problem, forward = (
        PeriodicProblem(model, vary, 1, abs(last - first)),
        math.copysign(1.0, last - first),
    )
    try:
        start = response_start(problem, first, forward)
        return problem, start, _span_begin(vary, first)
    except InputError as error:
        try:
            start = response_start(problem, last, -forward)
        except InputError:
            raise error from None
    end = End(
        "span",
        f"there is no response of period 1 at {vary} = {first:g}, so the span was followed from "
        f"its other end, {vary} = {last:g}",
        last,
    )
    return problem, start, end


def _first_equilibrium(
    model: Model, vary: str, first: float, last: float
) -> tuple[PeriodicProblem, Point, End]:
    """Start at the equilibrium at the first value of the span."""
    problem, start = equilibrium_start(model, vary, first, last)
    return problem, start, _span_begin(vary, first)


def _span_begin(vary: str, first: float) -> End:
    return End("span", f"the span begins at {vary} = {first:g}", first)


def _follow(
    item: _Waiting,
    number: int,
    last: float,
    first: float,
    settings: Settings,
    events: Sequence[Event],
    observer: Observer | None,
) -> Trace:
    def watch(trace: Trace) -> None:
        if observer is not None:
            names = tuple(found.type for found in trace.found)
            value = trace.problem.value(trace.points[-1].z)
            period = trace.problem.period
            observer(Progress(number, period, len(trace.points), value, names))

    if item.parent is None:
        return trace_branch(
            item.problem, item.start, (first, last), settings, events=events, watch=watch
        )
    born = hopf_start if item.problem.kind == "equilibrium" else doubled_start
    problem, start = born(item.problem, item.start)
    return trace_branch(
        problem,
        start,
        (first, last),
        settings,
        doubled=True,
        doublings=item.doublings,
        events=events,
        watch=watch,
    )


def _as_branch(
    trace: Trace, item: _Waiting, number: int
) -> tuple[Branch, list[tuple[int, SpecialPoint, Point]]]:
    """Return the branch as data, and its period doublings with their place in `special`."""
    problem, points = trace.problem, trace.points
    assert trace.end is not None  # every trace ends
    pairs: list[tuple[SpecialPoint, Point]] = [
        (describe_bifurcation(problem, found), found.point) for found in trace.found
    ]
    pairs += [(describe_event(problem, event, point), point) for event, point in trace.events]
    pairs.sort(key=lambda pair: pair[0].arclength)
    branch = Branch(
        id=number,
        kind="equilibrium" if problem.kind == "equilibrium" else "periodic",
        period=problem.period,
        parent=item.parent[0] if item.parent else None,
        model=problem.model,
        vary=problem.vary,
        parameter=np.array([problem.value(point.z) for point in points]),
        nodes=np.array([problem.nodes(point.z) for point in points]),
        multipliers=np.array([problem.all_multipliers(point.multipliers) for point in points]),
        residual=np.array([point.residual for point in points]),
        arclength=np.array([point.arclength for point in points]),
        special=tuple(special for special, _ in pairs),
        stopped=trace.end,
        begun=item.begun,
        durations=_durations(problem, points),
    )
    doublings = [
        (index, special, point)
        for index, (special, point) in enumerate(pairs)
        if special.type in BIRTHS
    ]
    return branch, doublings


def _durations(problem: PeriodicProblem, points: Sequence[Point]) -> NDArray[np.float64] | None:
    """Durations of one round of cycles in seconds; None where the parameters give them."""
    if not isinstance(problem, CycleProblem):
        return None
    return np.array([problem.duration(point.z) for point in points])


def _link(branches: list[Branch], item: _Waiting, branch: Branch) -> None:
    """Note on the parent which of its period doublings this branch joins."""
    if item.parent is None:
        return
    number, index = item.parent
    parent = branches[number - 1]
    width = item.problem.width
    special = list(parent.special)
    for place, point in enumerate(special):
        closed = branch.stopped.kind == "closed" and point.type in BIRTHS
        if place == index or (closed and abs(point.value - branch.stopped.value) < MATCH * width):
            special[place] = replace(point, leads_to=branch.id)
    branches[number - 1] = replace(parent, special=tuple(special))
