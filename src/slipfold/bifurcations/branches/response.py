"""The whole response: the branch it begins with and every branch that leaves it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from slipfold.bifurcations.branches.bifurcations import (
    BIFURCATION,
    CLOSED,
    Bifurcations,
    is_off_circle,
)
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.change import Change
from slipfold.bifurcations.branches.closed_branches import (
    Returns,
    close_on_parent,
    has_image,
    meets_image,
    noise_beside_parent,
    step_beside_parent,
)
from slipfold.bifurcations.branches.ends import BranchEndings
from slipfold.bifurcations.branches.events import Happened, check_events, events_on
from slipfold.bifurcations.branches.homoclinic import nears_homoclinic, stop_near_homoclinic
from slipfold.bifurcations.branches.known_curves import (
    begins_or_ends_at,
    lies_on,
    passing,
)
from slipfold.bifurcations.branches.make_branch import assemble, describe_in_turn
from slipfold.bifurcations.branches.progress import branch_progress, searching
from slipfold.bifurcations.branches.settings import Event, Settings
from slipfold.bifurcations.branches.start import Begin, FirstOrbit, measured_over, parent_start
from slipfold.bifurcations.branches.stops import (
    stop_at_limit,
    stop_in_family,
    stop_undetermined,
    stop_unresolved,
)
from slipfold.bifurcations.branches.switching import (
    Junction,
    find_meeting,
    junctions_on,
    rank_of,
    run_together,
)
from slipfold.bifurcations.branches.switching_boundaries import end_of_piece
from slipfold.continuation.curve_set import CurveSet, FollowedCurve, Start
from slipfold.continuation.end import End
from slipfold.continuation.follow import follow
from slipfold.continuation.locate import ZERO
from slipfold.continuation.step_length import STEP
from slipfold.continuation.traced_curve import Found, Monitor, TracedCurve
from slipfold.continuation.walk import Failure, first_point
from slipfold.errors import BREAKDOWNS
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model
from slipfold.models.quantities import Parameter
from slipfold.models.units import interval
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES
from slipfold.orbits.continued import parameter_rounding
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.progress import Observer
from slipfold.text import outside


def trace_response(
    model: Model,
    vary: str,
    span: tuple[float, float],
    *,
    settings: Settings | None = None,
    events: Sequence[Event] = (),
    observer: Observer | None = None,
    begin: Begin | None = None,
    through_stick: bool = False,
) -> tuple[Branch, ...]:
    """Follow the periodic response in one parameter, and all branches that leave it.

    Of an autonomous model the equilibrium is followed and the cycles from its Hopf points. At
    period doublings the branch of twice the period is followed, at a branch point the other branch,
    in both directions. A branch that is met again is not followed again. Where contacts begin to
    stick the model may end, or branches continue across sticking phases.
    """
    settings = settings or Settings()
    model, first, last = _checked(model, vary, span, events)
    if model.estimated_scales is None:
        model = measured_over(model, vary, (first, last), begin)
    if begin is not None:
        begin = begin.with_scales(model.estimated_scales)
    through_stick = through_stick and settings.discretization == "automatic"
    report = searching(observer, first)
    search = FirstOrbit(model, vary, (first, last), settings, through_stick, report)
    orbits, point, reason = search.find(begin)
    branches = BranchTree(
        model.parameter(vary), (first, last), settings, events, observer, through_stick
    )
    branches.explore(Start(orbits, _ways(orbits, point, (first, last))))
    return branches.assembled(reason)


def _ways(orbits: Orbits, point: OrbitPoint, span: tuple[float, float]) -> tuple[OrbitPoint, ...]:
    """Return the first point; inside the span also with the opposite tangent."""
    value = orbits.value(point.z)
    inside = min(abs(value - end) for end in span) > ZERO.close * orbits.width
    return (point, orbits.turned(point)) if inside else (point,)


def _checked(
    model: Model, vary: str, span: tuple[float, float], events: Sequence[Event]
) -> tuple[Model, float, float]:
    parameter = model.parameter(vary)
    first, last = interval(parameter, span)
    check_events(events, [vary], flow_of(model).output_names)
    return model.replace(**{vary: first}), first, last


@dataclass(eq=False)
class BranchTree(CurveSet[OrbitPoint]):
    """The branches of a response, each from a point of another, while they are followed."""

    parameter: Parameter
    span: tuple[float, float]
    settings: Settings
    events: Sequence[Event]
    observer: Observer | None
    through_stick: bool
    _junctions: list[Junction] = field(default_factory=list, init=False)
    # Branch points that known branches pass as well
    _met: set[Found | None] = field(default_factory=set, init=False)

    def trace(self, start: Start[OrbitPoint], point: OrbitPoint) -> TracedCurve[OrbitPoint]:
        """Follow a branch in one direction; it may end where others are known to begin."""
        orbits, settings, departs = start.curve, self.settings, start.departs
        several = isinstance(start, Junction) and start.several
        return follow(
            orbits,
            point,
            orbits.bounds(self.span),
            partial(self._monitors, first=point, departs=departs, several=several),
            settings=settings,
            departs=departs,
            first_step=partial(_first_step, orbits, point, settings, self._nearest(start))
            if departs
            else None,
            cap=step_beside_parent if has_image(orbits) else None,
            endings=BranchEndings(self.span, settings),
            otherwise=Change(settings, through_stick=self.through_stick).otherwise,
            on_step=self._report,
        )

    def _nearest(self, start: Start[OrbitPoint]) -> float:
        """Return how far from a branch point, in spans, its parent bifurcates for the next time."""
        found = start.found
        if found is None or found.type != "BP" or start.parent is None:
            return np.inf
        known = self.curves[start.parent - 1].traced.found
        own = (item.point.z[-1] for item in known if item.type in BIFURCATION_TYPES)
        apart = (abs(float(value - found.point.z[-1])) for value in own)
        return min((each for each in apart if each > BIFURCATION.located), default=np.inf)

    def _monitors(
        self, orbits: Orbits, first: OrbitPoint, departs: bool, several: bool = False
    ) -> list[Monitor[OrbitPoint]]:
        """Return the monitors of a branch: those that end it first, the most expensive last."""
        monitors: list[Monitor[OrbitPoint]] = [
            end_of_piece,
            partial(stop_unresolved, neared=partial(nears_homoclinic, orbits)),
        ]
        if has_image(orbits):
            children = [item.points[0] for item in self._junctions if not _crosses(item)]
            stop = partial(close_on_parent, orbits, children, first, several=several)
            monitors.append(partial(meets_image, stop=stop))
        if several or not departs:  # a simple branch point at which it starts is found again
            monitors.append(Returns(orbits, CLOSED, singular=several))
        monitors.append(stop_at_limit)
        monitors += [*events_on(orbits, self.events), Bifurcations(orbits, self.span)]
        if orbits.model.forced:
            monitors.append(stop_undetermined)
        if orbits.free_phase:
            largest = self.settings.largest_duration
            monitors.append(partial(stop_near_homoclinic, largest=largest))
        return [*monitors, stop_in_family]

    def children(self, followed: FollowedCurve[OrbitPoint]) -> Sequence[Start[OrbitPoint]]:
        """Return the new junctions of a branch, and the orbits that it closed on.

        A junction that was met before links two branches.
        """
        known = sum(
            found.type == "PD"
            for other in self.curves
            if other is not followed
            for found in other.traced.found
        )
        new, copies = junctions_on(followed, self.settings, known), list[Junction]()
        for i, junction in enumerate(new):
            other = find_meeting(junction, [*self._junctions, *new[:i]])
            if other is not None and other.parent is not None and other.found != junction.found:
                if run_together(junction, other):
                    copies.append(junction)
                    continue
                self.lead(junction.found, other.parent)
                self.lead(other.found, followed.number)
                self._met.add(junction.found)
        new = [item for item in new if item not in copies]
        self._junctions += new
        return [*new, *self._parents(followed)]

    def _parents(self, followed: FollowedCurve[OrbitPoint]) -> Iterator[Start[OrbitPoint]]:
        """Yield the orbits at which a branch ended without one that is known to begin there.

        Not where what begins there would not be followed either.
        """
        for end in followed.traced.reached:
            with suppress(*BREAKDOWNS):
                orbits, point = parent_start(end.curve.orbits, end.z)
                rests, (low, high) = orbits.kind == "equilibrium", sorted(self.span)
                followed_too = rests or 2 * orbits.period <= self.settings.largest_period
                if followed_too and low <= orbits.value(point.z) <= high:
                    yield Start(orbits, _ways(orbits, point, self.span), rank_of(orbits))

    def known(self, start: Start[OrbitPoint]) -> int | None:
        """Return the branch that a start is known to lead to, or lies on."""
        if isinstance(start, Junction) and start.several and start.found not in self._met:
            return None
        numbers = self.leads.get(start.found) if start.found is not None else None
        if numbers:
            return numbers[-1]
        if isinstance(start, Junction) and _crosses(start):
            return None
        meets = begins_or_ends_at if start.departs else lies_on
        return passing(self.curves, start.curve, start.points[0].z, meets)

    def assembled(self, started: End) -> tuple[Branch, ...]:
        """Return all that was followed as data."""
        known = describe_in_turn(self.curves, self._report_described)
        return assemble(self.curves, self.leads, started, known, self._report_orbits)

    def _report(self, traced: TracedCurve[OrbitPoint]) -> None:
        if self.observer is None:
            return
        period, value = traced.curve.period, traced.curve.value(traced.points[-1].z)
        curves = *(followed.traced for followed in self.curves), traced
        names = tuple(name for each in curves for name in _names(each))
        at = len(self.curves) + 1, period, len(traced.points), value, names
        self.observer(branch_progress(self.parameter, *at))

    def _report_described(
        self, followed: FollowedCurve[OrbitPoint], found: Found, done: int
    ) -> None:
        """Report which special point is described next; not after an interruption."""
        if self.observer is None or self.interrupted:
            return
        total = sum(len(each.traced.found) for each in self.curves)
        traced, value = followed.traced, found.point.curve.value(found.point.z)
        at = followed.number, traced.curve.period, len(traced.points), value, _names(traced)
        self.observer(branch_progress(self.parameter, *at, "normal forms", done, total))

    def _report_orbits(self, followed: FollowedCurve[OrbitPoint], done: int) -> None:
        """Report for how many points of a branch all states are computed."""
        if self.observer is None or self.interrupted:
            return
        traced = followed.traced
        total, value = len(traced.points), traced.curve.value(traced.points[done - 1].z)
        at = followed.number, traced.curve.period, total, value, _names(traced)
        self.observer(branch_progress(self.parameter, *at, "orbits", done, total))


def _names(traced: TracedCurve[OrbitPoint]) -> tuple[str, ...]:
    return tuple(item.type for item in traced.found if not isinstance(item, Happened))


def _crosses(junction: Junction) -> bool:
    """Whether it is a branch point: no branch ends there."""
    return junction.found is not None and junction.found.type == "BP"


LEVEL = 1e-7
"""Component of the tangent along the parameter whose sign rounding may decide: near another branch
Newton's method is singular."""


def _first_step(orbits: Orbits, start: OrbitPoint, settings: Settings, near: float) -> float:
    """Leave another branch by a step so short that nothing else can happen within it.

    All multipliers but the critical ones are near those of the common orbit, so that the number
    outside the unit circle may differ by theirs at most. The parameter must continue in its initial
    direction, else there is a fold. Otherwise the step is shortened. So `near` in the parameter as
    the other branch bifurcates, this one may as well.
    """
    apart = np.abs(start.multipliers - 1)
    critical = max(1, int(np.count_nonzero(apart < BIFURCATION.located)))
    others = start.multipliers[apart.argsort()[critical:]]
    beyond = int(np.count_nonzero(outside(others)))

    def reached(step: float) -> OrbitPoint | None:
        """Return the orbit at this distance, None if a bifurcation may lie before it."""
        first = first_point(orbits, start, step, settings)
        if isinstance(first, Failure) or first.piece != start.piece:
            return None
        if not 0 <= first.unstable - beyond <= critical:
            return None
        passes = critical == 1 and abs(first.z[-1] - start.z[-1]) > near / 2
        return None if passes else first

    # Of several branches each is known at that distance, and nearer to the point it is not.
    longest = step = STEP.emanating if critical == 1 else BIFURCATION.radius
    for _ in range(6):
        first = reached(step)
        if first is not None:
            nearer = first_point(orbits, start, step / 4, settings)
            if isinstance(nearer, Failure):
                return step
            if _continues(nearer, first):
                points = [start, nearer, first]
                return _resolved_step(step, points, reached) if has_image(orbits) else step
        step /= 4
    return longest


def _resolved_step(
    step: float, points: list[OrbitPoint], reached: Callable[[float], OrbitPoint | None]
) -> float:
    """Return a longer step if the parameter does not yet change by more than rounding.

    It changes with the square of the amplitude: little at first, but sixteen times as much from
    one point to the next. Along a family it does not change at all. `points` are the common orbit
    and those at a fourth of the step and after the step.
    """
    start, nearer, first = points
    tried = step
    while True:
        before, after = (float(point.z[-1] - start.z[-1]) for point in (nearer, first))
        if abs(after) > STEP.flat:
            return tried
        bordered = nearer.linearization.bordered(nearer.tangent)
        if abs(before) > parameter_rounding(bordered, nearer.z) and 8 < after / before < 32:
            return tried
        tried *= 4
        further = reached(tried) if tried < 1 else None
        if further is None or not _continues(first, further):
            return step
        nearer, first = first, further


def _continues(nearer: OrbitPoint, first: OrbitPoint) -> bool:
    """Whether as many perturbations grow at both, and the parameter moves in the same direction.

    It may hardly move at one of them.
    """
    if nearer.unstable != first.unstable and all(map(is_off_circle, (nearer, first))):
        return False
    slopes = float(nearer.tangent[-1]), float(first.tangent[-1])
    level = max(LEVEL, noise_beside_parent(nearer)[1])
    return slopes[0] * slopes[1] > 0 or min(map(abs, slopes)) < level
