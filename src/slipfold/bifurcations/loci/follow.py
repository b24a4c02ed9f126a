"""Loci of a window: one from its first point to its end, and all that leave it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from slipfold.arrays import Array
from slipfold.bifurcations.branches.change import Change
from slipfold.bifurcations.branches.closed_branches import Returns, has_image, step_beside_parent
from slipfold.bifurcations.branches.ends import failure_reason
from slipfold.bifurcations.branches.events import Happened, check_events, events_on
from slipfold.bifurcations.branches.homoclinic import locus_nears
from slipfold.bifurcations.branches.known_curves import begins_or_ends_at, lies_on, passing
from slipfold.bifurcations.branches.settings import Event, Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.branches.stops import stop_at_limit, stop_standing, stop_unresolved
from slipfold.bifurcations.branches.switching_boundaries import end_of_piece
from slipfold.bifurcations.loci.locus import Locus, locus_title
from slipfold.bifurcations.loci.locus_equations import (
    LOCUS,
    LocusEquations,
    equations_of,
    mirrors,
)
from slipfold.bifurcations.loci.make_locus import as_loci, pair_of, plane_of
from slipfold.bifurcations.loci.special_points import SpecialPoints, tests_of, without_repeats
from slipfold.bifurcations.loci.start import (
    LocusStart,
    as_unknown,
    ends_at_parent,
    ends_beside_parent,
    on_a_mesh,
    parents_of,
    regular_start,
    starts_at,
    undamped,
)
from slipfold.bifurcations.loci.window import (
    LocusLine,
    Plane,
    Window,
    measured_across,
    parse_plane,
)
from slipfold.continuation.curve_set import CurveSet, FollowedCurve, Start
from slipfold.continuation.end import End
from slipfold.continuation.follow import Endings, follow
from slipfold.continuation.traced_curve import Found, Monitor, TracedCurve
from slipfold.continuation.walk import Failure
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model
from slipfold.orbits.bifurcation_types import EXTREMUM_TYPES, FOLLOWED_TYPES, LOCUS_TYPES
from slipfold.orbits.check import rests
from slipfold.orbits.critical import crossing_gap
from slipfold.orbits.orbit_curve import OrbitPoint
from slipfold.progress import Observer

UNFORCED = 1e-6
"""Amplitude of the forcing, over the width of the window, below which orbits are free cycles."""


def _monitors(
    curve: LocusEquations, settings: Settings, events: Sequence[Event]
) -> list[Monitor[OrbitPoint]]:
    """What is watched along a locus: what ends it early first, what takes longest last."""
    monitors: list[Monitor[OrbitPoint]] = [end_of_piece, stop_unresolved]
    if has_image(curve.orbits):
        monitors.append(partial(ends_at_parent, settings=settings))
    return [
        *monitors,
        Returns(curve, "the locus closed on itself"),
        stop_standing,
        stop_at_limit,
        *events_on(curve, events),
        SpecialPoints(curve),
    ]


@dataclass(frozen=True, eq=False)
class _LocusEndings(Endings[OrbitPoint]):
    """The ends of loci in words."""

    window: Window
    settings: Settings

    def left(self, traced: TracedCurve[OrbitPoint]) -> End:
        """Return the end of a locus that left the window."""
        curve, last = traced.curve, traced.points[-1]
        gaps = [
            min(abs(last.z[place] - low), abs(high - last.z[place]))
            for place, low, high in curve.orbits.bounds(*self.window)
        ]
        nearest = gaps.index(min(gaps))
        edge = min(self.window[nearest], key=lambda end: abs(end - curve.place(last.z)[nearest]))
        reason = f"left the window at {plane_of(curve.orbits)[nearest]} = {edge:g}"
        return End("window", reason, pair_of(curve, last))

    def failed(self, traced: TracedCurve[OrbitPoint], failure: Failure) -> End:
        """Return the end of a locus that could not be followed."""
        curve, last = traced.curve, traced.points[-1]
        stop = ends_beside_parent(curve, last, self.settings)
        if stop is not None and stop.beyond is not None:
            traced.points.append(stop.beyond)
            traced.reached = (stop.reached,)
            return stop.end
        if _is_unforced(curve, last):
            reason = (
                f"reached {curve.orbits.model.forcing_amplitude} = 0, where the orbit is a free "
                "cycle, of any phase"
            )
            return End("window", reason, pair_of(curve, last))
        kind, reason = failure_reason(curve.orbits, last, failure)
        if kind == "failed" and (neared := locus_nears(curve.orbits, traced.points)):
            loop, clause = neared
            reason = f"{clause}, beside which multipliers change too fast to be followed ({reason})"
            return End(loop, reason, pair_of(curve, last))
        if clause := undamped(curve, last.multipliers):
            reason = f"{clause} ({reason})"
        return End(kind, reason, pair_of(curve, last))

    def contradiction(self, traced: TracedCurve[OrbitPoint]) -> tuple[OrbitPoint, str] | None:
        """Return where a parameter turns; at the tip of a tongue of entrainment it is rounding."""
        found = super().contradiction(traced)
        return None if found and _is_unforced(traced.curve, found[0]) else found


def _is_unforced(curve: LocusEquations, point: OrbitPoint) -> bool:
    """Whether the forcing has vanished, so that derivatives by the phase are rounding."""
    plane, amplitude = plane_of(curve.orbits), curve.orbits.model.forcing_amplitude
    return amplitude in plane and abs(point.z[plane.index(amplitude) - 2]) < UNFORCED


SEVERAL = (
    "points at which several multipliers are critical at once, as by a symmetry, are not followed "
    "in two parameters"
)

OWN = ("duration",)
"""Parameters that belong to an orbit of an autonomous model, not to the case."""


def follow_loci(
    points: Sequence[SpecialPoint],
    vary: tuple[str, str],
    window: Window,
    *,
    settings: Settings | None = None,
    observer: Observer | None = None,
    switch: bool = True,
    remarks: list[str] | None = None,
    events: Sequence[Event] = (),
) -> tuple[Locus, ...]:
    """Follow the loci of special points in two parameters, each locus once.

    What is to be said of points without a locus of their own is added to the remarks.
    """
    if not points:
        return ()
    base = points[0].model
    vary, window = parse_plane(base, vary, window)
    for point in points:
        _check_point(point, base, vary, window)
    check_events(events, vary, flow_of(base).output_names)
    largest = 2 * max(point.period for point in points)
    types = LOCUS_TYPES if switch else ()
    remarks = [] if remarks is None else remarks
    if not base.forced:  # of its branch, sizes may be those at an end where nothing moves
        sizes = measured_across(base, vary, window).estimated_scales
        points = [replace(point, model=point.model.with_scales(sizes)) for point in points]
    plane = Plane(base, vary, window, settings or Settings(), observer)
    return follow_found(points, plane, types, largest, remarks, events=events)


_Refusal = tuple[SpecialPoint, LocusEquations, Array, InputError]


def follow_found(
    points: Iterable[SpecialPoint],
    plane: Plane,
    types: Sequence[str],
    largest_period: int,
    remarks: list[str],
    *,
    through_stick: bool = False,
    events: Sequence[Event] = (),
) -> tuple[Locus, ...]:
    """Follow the loci of special points, each before the next point is requested.

    A branch point whose branches cross in one parameter only is a point of a locus of folds. Loci
    in slip end where contacts begin to stick, or continue through stick.
    """
    work: _Loci | None = None
    refusals: list[_Refusal] = []
    for point in points:
        own = replace(plane, model=point.model)
        work = work or _Loci(own, types, largest_period, through_stick, events)
        with work.kept_if_interrupted():
            _take_up(work, point, remarks, refusals)
        if work.interrupted:
            break
    if work is None:
        return ()
    if refusals and not (work.curves or through_stick):  # a set without loci is a result
        raise refusals[0][-1]
    with work.kept_if_interrupted():
        for point, curve, z, refusal in refusals:
            # Nor does a locus that was followed later
            if passing(work.curves, curve, z, lies_on) is None:
                alone = _without_locus(point, plane.names, refusal)
                remarks.append(SEVERAL if point.several else alone)
    return as_loci(work.curves, work.leads, work.report_described)


def _take_up(
    work: _Loci, point: SpecialPoint, remarks: list[str], refusals: list[_Refusal]
) -> None:
    """Follow the locus of a special point, and all that begin on it, unless one passes there."""
    try:
        curve, z = work.taken_up(point)
    except InputError as error:
        if not work.through_stick:
            raise
        remarks.append(_without_locus(point, work.plane.names, error))
        return
    if curve.condition == "BP" and crossing_gap(curve.orbits, z) > LOCUS.vanishes:
        remarks.append(_isolated(curve, z))
        curve = LocusEquations(curve.orbits, "LP")
    if all(passing(work.curves, curve, z, meets) is None for meets in (lies_on, mirrors)):
        start = work.start(curve, z, point)
        if isinstance(start, InputError):
            refusals.append((point, curve, z, start))
        else:
            work.explore(start)


def _check_point(point: SpecialPoint, base: Model, vary: tuple[str, str], window: Window) -> None:
    if point.type not in FOLLOWED_TYPES:
        raise InputError(
            f"a special point of type {point.type} has no locus in {vary[0]} and {vary[1]}; give "
            f"one of type {', '.join(FOLLOWED_TYPES)}"
        )
    if point.type in EXTREMUM_TYPES and point.vary not in vary:
        raise InputError(
            f"the {point.type} is an extremum along {point.vary}, which the plane of {vary[0]} and "
            f"{vary[1]} lacks; give {point.vary} and another parameter"
        )
    if point.model.kind != base.kind:
        raise InputError("the special points belong to different models; follow them one by one")
    for name, value in point.model.values.items():
        if name not in (*vary, *OWN) and value != base.values[name]:
            raise InputError(
                f"the special points differ in {name}: {base.values[name]:g} and {value:g}; "
                f"vary {name} or follow them one by one"
            )
    for name, (low, high) in zip(vary, window, strict=True):
        value = point.model.values[name]
        if not low <= value <= high:
            raise InputError(
                f"the special point at {name} = {value:.6g} is outside the window from {low:g} to "
                f"{high:g}; give a window that holds it"
            )


@dataclass(eq=False)
class _Loci(CurveSet[OrbitPoint]):
    """Loci followed so far, and how they are followed."""

    plane: Plane
    types: Sequence[str]
    largest_period: int
    through_stick: bool
    events: Sequence[Event]
    lines: int = 0  # followed so far, one in each direction
    _bases: dict[str, Model] = field(default_factory=dict)

    def taken_up(self, point: SpecialPoint) -> tuple[LocusEquations, Array]:
        """Return the equations of a point's locus, and the point as an unknown of theirs.

        Those of a kind share one model, so that unknowns compare.
        """
        plane = dict(zip(self.plane.names, self.plane.size.tolist(), strict=True))
        given = {name: point.model.values[name] for name in OWN if not point.model.forced}
        own = self.plane.model.replace(**given)
        kind = "rests" if rests(point.model, point.nodes) else "moves"
        base = self._bases.setdefault(kind, own)
        orbits, z = as_unknown(point, base, plane, self.plane.settings)
        return equations_of(orbits, point, z), z

    def start(
        self, curve: LocusEquations, z: Array, point: SpecialPoint
    ) -> LocusStart | InputError:
        """Return the first point of a locus, by collocation where shooting does not find it."""
        try:
            return regular_start(curve, z, self.plane.settings)
        except InputError as error:
            given = self.plane.settings.discretization != "automatic" or not curve.orbits.by.smooth
            if given or curve.orbits.kind == "equilibrium":
                return error
            refusal = error
        try:
            orbits, z = on_a_mesh(curve.orbits, point)
            return regular_start(curve.with_orbits(orbits), z, self.plane.settings)
        except BREAKDOWNS:
            return refusal

    def trace(self, start: Start[OrbitPoint], point: OrbitPoint) -> TracedCurve[OrbitPoint]:
        """Follow a locus in one direction."""
        assert isinstance(start, LocusStart)
        orbits, settings, window = start.curve.orbits, self.plane.settings, self.plane.window
        traced = follow(
            start.curve,
            point,
            orbits.bounds(*window),
            lambda curve: _monitors(curve, settings, self.events),
            settings=settings,
            departs=start.departs,
            first_step=start.step,
            cap=step_beside_parent if has_image(orbits) else None,
            endings=_LocusEndings(window, settings),
            otherwise=Change(settings, through_stick=self.through_stick).otherwise,
            on_step=self._report,
        )
        self.lines += 1
        if start.crosses and point is start.points[0]:
            traced.found[:0] = _crossed(traced, start)
        return traced

    def _follow(self, start: Start[OrbitPoint]) -> FollowedCurve[OrbitPoint]:
        followed = super()._follow(start)
        followed.traced.found[:] = without_repeats(followed.traced.found)
        return followed

    def children(self, followed: FollowedCurve[OrbitPoint]) -> Sequence[Start[OrbitPoint]]:
        """Return the loci that begin or pass at points of codimension two, in their order."""
        number = followed.number
        if followed.interrupted or not self.types:
            return ()
        starts = [
            replace(start, found=found)
            for found in followed.traced.found
            if not isinstance(found, Happened)
            for start in _starts(followed.traced.curve, found, self.types, self.plane.settings)
        ]
        curve = followed.traced.curve
        ends = [parents_of(curve, last, self.plane.settings) for last in followed.traced.reached]
        starts += [start for start in ends if start is not None]
        wanted = [
            start
            for start in starts
            if start.curve.condition in self.types
            and start.curve.orbits.period <= self.largest_period
        ]
        return [
            replace(start, rank=(*followed.start.rank, i), parent=number)
            for i, start in enumerate(wanted)
        ]

    def known(self, start: Start[OrbitPoint]) -> int | None:
        """Return the number of the locus that passes a start, if it was followed already."""
        assert isinstance(start, LocusStart)
        at = start.beside or (start.points[0].z,)
        meets = begins_or_ends_at if start.doubled else lies_on
        numbers = (passing(self.curves, start.curve, z, meets) for z in at)
        number = next((number for number in numbers if number is not None), None)
        if number is not None and start.doubled:
            self._place_end(self.curves[number - 1], start)
        return number

    def _place_end(self, followed: FollowedCurve[OrbitPoint], start: Start[OrbitPoint]) -> None:
        """Set the exact end of a locus that ends on its parent."""
        traced, z = followed.traced, start.points[0].z
        place = start.curve.place(z)
        if not traced.reached:
            return
        orbits = start.curve.orbits
        if followed.started is not None and begins_or_ends_at(traced.points[:1], orbits, z):
            followed.started = End(followed.started.kind, followed.started.reason, place)
        if traced.end is not None and begins_or_ends_at(traced.points[-1:], orbits, z):
            traced.end = End(traced.end.kind, traced.end.reason, place)

    def report_described(
        self, followed: FollowedCurve[OrbitPoint], point: OrbitPoint, done: int
    ) -> None:
        """Report which normal form is computed next, unless interrupted."""
        if self.interrupted:
            return
        curve = followed.traced.curve
        total = sum(len(each.traced.points) + len(each.traced.found) for each in self.curves)
        self.plane.report("normal forms", done, total, pair_of(curve, point), title_of(curve))

    def _report(self, traced: TracedCurve[OrbitPoint]) -> None:
        if self.plane.observer is None:
            return
        curve = traced.curve
        names = "".join(f", {found.type}" for found in traced.found)
        start, last = (pair_of(curve, point) for point in (traced.points[0], traced.points[-1]))
        title = title_of(curve)
        text = f"{title}, {len(traced.points)} points{names}"
        line = LocusLine(self.lines, curve.condition, curve.orbits.period, title, start)
        self.plane.report("loci", len(self.curves), None, last, text, line=line)


def title_of(curve: LocusEquations) -> str:
    """Return the title of a locus that is followed."""
    orbits = curve.orbits
    forced = orbits.model.forced
    return locus_title(curve.condition, orbits.period, orbits.kind, forced, curve.quantity)


def _isolated(curve: LocusEquations, z: Array) -> str:
    """Say that the other parameter parts the branches that cross at a branch point."""
    pairs = zip(curve.orbits.varied, curve.place(z), strict=True)
    at = ", ".join(f"{name} = {value:.6g}" for name, value in pairs)
    return (
        f"the branch point at {at} is isolated in the plane: near it no branches cross, and it "
        "has no locus; it lies on a locus of folds, where that turns"
    )


def _without_locus(point: SpecialPoint, vary: tuple[str, str], error: InputError) -> str:
    """Say that a point has no locus in the result."""
    at = ", ".join(f"{name} = {point.model.values[name]:.6g}" for name in vary)
    return f"the locus of the {point.type} at {at} was not followed: {error}"


def _crossed(trace: TracedCurve[OrbitPoint], start: LocusStart) -> list[Found]:
    """Return the point of codimension two that a locus was started from, as found on it."""
    if len(trace.points) < 2:
        return []
    (first, second), kind, found = trace.points[:2], start.crosses, start.found
    test = tests_of(kind, first.tests)[-1]
    if test == "second":  # nothing detects it on this locus: folds are singular at DP
        if kind != "DP" or found is None:
            return []
        return [replace(found, point=replace(found.point, arclength=first.arclength))]
    slope = (second.tests[test] - first.tests[test]) / (second.arclength - first.arclength)
    return [Found(kind, first, slope)]


def _starts(
    curve: LocusEquations, found: Found, types: Sequence[str], settings: Settings
) -> list[LocusStart]:
    """Return the loci that start at a point; none where what they start from breaks down."""
    try:
        return list(starts_at(curve, found, types, settings))
    except BREAKDOWNS:
        return []
