"""The whole response: the branch it begins with and every branch that leaves it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from slipfold.branches.assembly import assemble
from slipfold.branches.branch import Branch
from slipfold.branches.closing import Birth
from slipfold.branches.detection import CLOSED
from slipfold.branches.event import Event
from slipfold.branches.events import Happened
from slipfold.branches.junction import Junction, Meeting, find_meeting, junctions_on, linked
from slipfold.branches.progress import Observer, Progress
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.branches.start import equilibrium_start, orbit_start, response_start
from slipfold.branches.trace import trace_branch
from slipfold.continuation.end import End
from slipfold.continuation.search import Found
from slipfold.continuation.trail import Trail, joined
from slipfold.errors import BREAKDOWNS, InputError, breakdown
from slipfold.flow import flow_of
from slipfold.flow.typical_sizes import measured_within
from slipfold.models.model import Model
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.orbit_point import OrbitPoint
from slipfold.orbits.periodic_orbit import PeriodicOrbit

__all__ = ["measured_over", "trace_response"]


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
    """Follow the periodic response in one parameter, and all branches that leave it.

    Of an autonomous model the equilibrium is followed and the cycles born at its Hopf points. At
    period doublings the branch of twice the period is followed, at a branch point the other branch,
    in both directions. A branch that is met again is not followed again.

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
        The branch of period 1 first, then those that leave it: equilibria before cycles, shorter
        periods before longer ones, else in the order in which they were met.

    Raises
    ------
    InputError
        If the input cannot be used or no orbit is found at the start of the span.
    """
    settings = settings or Settings()
    model, first, last = _checked(model, vary, span, events)
    if model.found_sizes is None:
        model = measured_over(model, vary, (first, last), start)
    if start is not None:
        start = replace(start, model=model)
    following = _Following((first, last), settings, events, observer)
    trace, branch, found = following.first(*_first(model, vary, first, last, start))
    branches, known = [branch], junctions_on(trace.curve, 1, found, settings.largest_period)
    waiting = list(known)
    while waiting and not branches[-1].interrupted:
        junction = min(waiting, key=lambda item: item.rank)
        waiting.remove(junction)
        if junction.is_reached(branches):
            continue
        number = len(branches) + 1
        special = branches[junction.branch - 1].special[junction.place]
        births = [item.birth for item in known if not item.two_sided]
        trace, branch, found = following.other(junction, number, special, births)
        new = junctions_on(trace.curve, number, found, settings.largest_period)
        meetings = [Meeting(junction.branch, junction.place, number)]
        meetings += [
            Meeting(item.branch, item.place, number)
            for item in known
            if any(item.birth is reached for reached in trace.reached)
        ]
        meetings += _met_again(new, known)
        branches = linked([*branches, branch], meetings)
        known += new
        waiting += new
    return tuple(branches)


def measured_over(
    model: Model, vary: str, span: tuple[float, float], start: PeriodicOrbit | None = None
) -> Model:
    """Return a model that knows how large its states become over a span of a parameter.

    Parameters
    ----------
    model
        The model, at the first value of the span.
    vary
        Name of the parameter.
    span
        Its values.
    start
        An orbit at the first value, if one is known.
    """
    values = [{vary: value} for value in (span[0], sum(span) / 2, span[1])]
    return measured_within(model, values, None if start is None else start.nodes)


def _met_again(new: Sequence[Junction], known: Sequence[Junction]) -> list[Meeting]:
    """Return what joins a branch to those that it met at branch points known already."""
    meetings = []
    for i, junction in enumerate(new):
        other = find_meeting(junction, [*known, *new[:i]])
        if other is not None:
            meetings.append(Meeting(junction.branch, junction.place, other.branch))
            meetings.append(Meeting(other.branch, other.place, junction.branch))
    return meetings


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
) -> tuple[PeriodicProblem, OrbitPoint, End]:
    """Return the first branch: from the orbit given, or the response, or the equilibrium.

    Where the first value of the span has none, it begins at the last.
    """
    if orbit is not None:
        problem, start = orbit_start(orbit, vary, first, last)
        return problem, start, _span_begin(vary, first)
    try:
        return (*_begin(model, vary, first, last), _span_begin(vary, first))
    except InputError as error:
        try:
            problem, start = _begin(model.replace(**{vary: last}), vary, last, first)
        except InputError:
            raise error from None
    what = "response of period 1" if model.forced else "regular equilibrium"
    end = End(
        "span",
        f"there is no {what} at {vary} = {first:g}, so the span was followed from "
        f"its other end, {vary} = {last:g}",
        (last,),
    )
    return problem, start, end


def _begin(
    model: Model, vary: str, first: float, last: float
) -> tuple[PeriodicProblem, OrbitPoint]:
    """Return the response or the equilibrium at one end of the span."""
    try:
        if not model.forced:
            return equilibrium_start(model, vary, first, last)
        problem = PeriodicProblem(model, vary, 1, abs(last - first))
        return problem, response_start(problem, first, math.copysign(1.0, last - first))
    except InputError:
        raise
    except BREAKDOWNS as error:
        raise InputError(
            f"nothing was found at {vary} = {first:g}: {breakdown(error)}; start the span elsewhere"
        ) from None


def _span_begin(vary: str, first: float) -> End:
    return End("span", f"the span begins at {vary} = {first:g}", (first,))


@dataclass(frozen=True, eq=False)
class _Following:
    """How branches are followed, and who watches."""

    span: tuple[float, float]
    settings: Settings
    events: Sequence[Event]
    observer: Observer | None

    def first(
        self, problem: PeriodicProblem, start: OrbitPoint, begun: End
    ) -> tuple[Trail[OrbitPoint], Branch, list[tuple[int, Found]]]:
        """Follow the branch that the response begins with."""
        trace = self._trace(1, problem, start)
        return (trace, *assemble(trace, 1, None, begun))

    def other(
        self, junction: Junction, number: int, special: SpecialPoint, births: Sequence[Birth]
    ) -> tuple[Trail[OrbitPoint], Branch, list[tuple[int, Found]]]:
        """Follow the branch that begins at a junction, at a branch point in both directions."""
        problem, start = junction.birth.problem, junction.birth.start
        trace = self._trace(number, problem, start, True, births)
        begun, beginning = self._born(special), None
        if junction.two_sided:
            # A branch that comes back to where it began has been followed in both directions.
            around = bool(trace.end and trace.end.reason == CLOSED)
            begun = trace.end if around and trace.end else begun
            beginning = replace(special, arclength=0.0, leads_to=junction.branch)
            if trace.end is not None and trace.end.kind != "interrupted" and not around:
                backward = self._trace(number, problem, problem.turned(start), True, births)
                begun = backward.end or begun
                trace = joined(backward, trace)
        return (trace, *assemble(trace, number, junction.branch, begun, beginning))

    def _born(self, special: SpecialPoint) -> End:
        return End("born", f"born at {special.vary} = {special.value:.9g}", (special.value,))

    def _trace(
        self,
        number: int,
        problem: PeriodicProblem,
        start: OrbitPoint,
        departs: bool = False,
        births: Sequence[Birth] = (),
    ) -> Trail[OrbitPoint]:
        def watch(trace: Trail[OrbitPoint]) -> None:
            if self.observer is not None:
                names = tuple(
                    found.type for found in trace.found if not isinstance(found, Happened)
                )
                value = trace.curve.value(trace.points[-1].z)
                period = trace.curve.period
                self.observer(Progress(number, period, len(trace.points), value, names))

        return trace_branch(
            problem,
            start,
            self.span,
            self.settings,
            departs=departs,
            births=births,
            events=self.events,
            watch=watch,
        )
