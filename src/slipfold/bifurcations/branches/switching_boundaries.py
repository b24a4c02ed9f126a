"""Points of a branch at which the sequence of contact modes changes: GRAZE, STICK, LIFT, MEET."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.closed_branches import closes_at_change
from slipfold.bifurcations.branches.passed_pieces import with_passed
from slipfold.continuation.end import End
from slipfold.continuation.interpolation import arc_between
from slipfold.continuation.locate import LostCurveError
from slipfold.continuation.pieces import (
    PIECE,
    POWERS,
    ROOTS,
    PieceBoundary,
    Vanishing,
    across_gap,
    ahead_of,
    beyond_end,
    locate_boundary,
    locate_loss,
    locate_vanishing,
)
from slipfold.continuation.traced_curve import Found, MonitorResult, StepInterval, Stop, TracedCurve
from slipfold.errors import BREAKDOWNS
from slipfold.flow.equations import Constants
from slipfold.flow.modes import GRAZED, Ending, Mode, Status
from slipfold.orbits.bifurcation_types import CONTACT_TYPES
from slipfold.orbits.continued import Met, locate_marginal_stops, solve_marginal
from slipfold.orbits.marginal import MarginalShooting
from slipfold.orbits.meeting import meeting_between
from slipfold.orbits.orbit_curve import OrbitCurve, OrbitPoint, Orbits
from slipfold.orbits.switched_shooting import Piece, SwitchedShooting


class BORDER:
    """Where changes of contacts are sought, and how near to them orbits are computed."""

    # Slip in the plane, over its size, or square of a stuck interval, in phases, below which a
    # grazing is searched ahead
    near: float = 1e-4
    # Minimum of that at which orbits are computed. Nearer to zero the equations become stiff; the
    # smallest value that works is the most accurate
    smallest: tuple[float, ...] = (1e-6, 8e-6, 1.6e-5, 3.2e-5, 6.4e-5)
    # Arclength beyond the last orbit within which an event explains why there is no other
    nearly: float = 1e-6
    # Arclength by which a point may lie beyond a change of contacts that it is taken to precede:
    # residuals of 1e-10 move orbits by more
    passed: float = -1e-8
    # Phases by which an interval of a mode may move from one point to the next beyond its ends
    elsewhere: float = 0.05
    # Arclength within which a grazing is searched
    ahead: float = 0.02
    # Arclength beside a place where changes meet at which they are distinguished
    beside: float = 1e-7
    swaps: int = 16  # changes that may swap in a step
    # Distance in the scaled parameter of two points that are one: each is known to a tenth of it
    same: float = 1e-9
    # Cosine of the angle between tangents a first look apart, above which they belong to one piece
    smooth: float = 0.9995
    # Growth a phase of what friction lacks, in what it had: released half a thousandth of a phase
    # later, the contact would be held. Perturbations are multiplied by fifty or more
    barely: float = 0.02


BOUNDARY = "boundary"
"""Kind of an internal end: the branch continues where an orbit exists beyond it."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FoundGrazing(Found[OrbitPoint]):
    """A grazing extrapolated from orbits near it.

    The point of slip in the plane is the nearest of them, with the extrapolated unknown. Of several
    grazings at once, and of slip that only just stops, it is the last orbit before them: of that at
    them there is no trajectory.
    """

    place: Vanishing[OrbitPoint]

    @property
    def nearest(self) -> OrbitPoint:
        """The nearest orbit before it."""
        return self.place.nearest

    @property
    def extrapolated(self) -> bool:
        """Whether the point has the extrapolated unknown."""
        return self.point.z is self.place.z


@dataclass(frozen=True, eq=False, kw_only=True)
class FoundMeeting(Found[OrbitPoint]):
    """Two changes of contacts that meet: on the orbit itself both are one, without derivatives."""

    before: OrbitPoint

    @property
    def nearest(self) -> OrbitPoint:
        """An orbit on which one precedes the other."""
        return self.before


CAUGHT = (
    "the orbit sticks, and no other was found beyond: a contact only just stops there, and static "
    "friction above kinetic friction holds it for good or not at all; simulate shows what "
    "trajectories do"
)


HOLDS_MORE = (
    ", and static friction is more than kinetic, so that slip or stick that only just begins lasts"
)


RELEASED = (
    "friction only just releases a contact that sticks: perturbations grow without bound towards "
    "the point at which it holds the contact, and no orbit continues beyond; simulate shows what "
    "trajectories do"
)


def end_of_piece(interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
    """End a smooth piece of a branch where its orbits begin to pass through other modes.

    It ends with the last orbit that has the modes of the piece, and the first with others. Pieces
    that begin and end within the step are looked for on the way there.
    """
    smooth = interval.point.curve.orbits.by.smooth
    return MonitorResult() if smooth or interval.leaves else with_passed(interval, _end_of_piece)


def _end_of_piece(interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
    """Return where the piece ends between the last two known points, if it ends there."""
    curve, (before, after) = interval.traced.curve, interval.history[-2:]
    grazing = _grazing(interval)
    if grazing is not None:
        return grazing
    if before.piece == after.piece:
        if _jumps(before, after):
            raise LostCurveError("contacts change elsewhere in the period")
        return MonitorResult()
    meeting = _meeting(interval.traced, before, after)
    if meeting is not None:
        return meeting
    try:
        boundary = locate_boundary(curve, interval.history, before, after, _change_between)
    except LostCurveError:
        lost = _lost(interval)
        if lost is None:
            raise
        return lost
    kind = _kind(boundary.before.piece, boundary.after.piece)
    met, connected = _met(curve, kind, boundary), boundary.apart < PIECE.apart
    if kind != "MEET" and met is None and not connected and isinstance(curve, Orbits):
        raise LostCurveError("a step led onto orbits of other modes that are not connected")
    found = Found(kind, met or boundary.before, float("inf"))
    end = _end(kind, curve, found.point)
    beyond = boundary.after if connected else met and _first_beyond(boundary.before, met)
    known = kind == "MEET" and _is_known(found, interval.traced)
    return MonitorResult([] if known else [found], Stop(boundary.before, end, beyond=beyond))


def _meeting(
    traced: TracedCurve[OrbitPoint], before: OrbitPoint, after: OrbitPoint
) -> MonitorResult[OrbitPoint] | None:
    """Return where two changes of contacts meet first that swap in a step; None if that fails.

    Several may swap in one step.
    """
    curve = before.curve
    for _ in range(BORDER.swaps):
        if _kind(before.piece, after.piece) != "MEET":
            return None
        row, z, unsure = after.z - before.z, None, 0.0
        row /= np.linalg.norm(row)
        with suppress(*BREAKDOWNS):
            z, unsure = meeting_between(before, after)
        if z is None or not row @ before.z < row @ z < row @ after.z:
            guesses = [0.5 * (before.z + after.z)]
        else:
            beside = max(BORDER.beside, unsure) * row  # nearer both are one change
            guesses = [z - beside, z + beside]
        sides = list[OrbitPoint]()
        for guess in guesses:
            arclength = before.arclength + float(row @ (guess - before.z))
            side = curve.nearest(guess, row, arclength)
            if side is None:
                return None
            sides.append(side)
            before, after = (side, after) if side.piece == before.piece else (before, side)
            if side is after:  # others swap before
                break
        if z is not None and sides == [before, after]:
            met = replace(before, z=z)
            found = FoundMeeting("MEET", met, float("inf"), unsure=unsure, before=before)
            known = [] if _is_known(found, traced) else [found]
            return MonitorResult(known, Stop(before, _end("MEET", curve, before), beyond=after))
    return None


def _met(curve: OrbitCurve, kind: str, boundary: PieceBoundary[OrbitPoint]) -> OrbitPoint | None:
    """Return the orbit that only just meets the change of contacts, None if none is found.

    Slip backwards for a time dt goes as its third power: pieces differ where it is seen only.
    """
    if not isinstance(curve, Orbits):
        return None
    last = boundary.before
    with suppress(*BREAKDOWNS):
        stops = kind in ("MEET", "STICK")
        met = locate_marginal_stops(curve, last, kind) if stops else None
        # Where static friction is more, multipliers jump: the last orbit has those of its side
        if kind == "MEET" or (met is not None and not _holds_more(met.point)):
            return None if met is None else met.point
        change = _change_beside(last, kind, (last, boundary.after))
        if change is not None and change.piece == last.piece:
            return replace(change, arclength=last.arclength)
    return None


def _lost(interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint] | None:
    """Return where orbits cease in the plane, where ever shorter steps come no farther.

    What follows a stop that only just happens goes as the square root of the way to its end.
    """
    curve = interval.traced.curve
    if not curve.orbits.by.slips_in_planes:
        return None
    last = locate_loss(curve, interval.history, *interval.history[-2:])
    left = None if last is None else last.curve.orbits.grazing_margin(last)
    if last is None or (left is not None and left < BORDER.near):  # it vanishes: nearer it is seen
        return None
    beyond = across_gap(curve, last)
    if beyond is not None:
        back = curve.turned(beyond)
        change = _change_ahead(back, 2 * float(np.linalg.norm(beyond.z - last.z)))
        if change is not None:
            end = _end(change.type, curve, change.point)
            return MonitorResult([change], Stop(last, end, beyond=beyond))
    return MonitorResult(stop=Stop(last, End("failed", CAUGHT, curve.place(last.z))))


def _grazing(interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint] | None:
    """Return where slip in the plane begins or ceases to graze, if that is near."""
    orbits, (before, after) = interval.traced.curve, interval.history[-2:]
    if not isinstance(orbits, Orbits) or not orbits.by.slips_in_planes:
        return None
    start, ahead = before, 2 * (after.arclength - before.arclength)
    if before.piece == after.piece:
        start, ahead = after, BORDER.ahead
        left, was = orbits.grazing_margin(after), orbits.grazing_margin(before)
        if left is None or was is None or not left < min(was, BORDER.near):
            return None
    place = _vanishing(orbits, start, orbits.grazing_margin, ahead)
    if place is None:
        return None
    last, beyond = place.nearest, beyond_end(orbits, place.nearest, place.z, place.reach)
    if beyond is not None:
        left, sides = orbits.grazing_margin(beyond), (last.piece, beyond.piece)
        stops = [_counts(modes)[Status.STICK] for modes in sides]
        caught = left is None or left > BORDER.near
        if caught or stops[1] < stops[0]:  # slip knows better where it vanishes than stops do
            back = orbits.turned(beyond)
            distance = float(np.linalg.norm(beyond.z - place.z))
            again = _vanishing(orbits, back, orbits.grazing_margin, 2 * distance)
            if again is not None and again.is_same(place):
                place = again
            elif caught:  # for long: another orbit, which begins apart from this
                beyond = None
    point = replace(place.nearest, z=place.z, arclength=last.arclength)
    found = FoundGrazing("GRAZE", point, float("inf"), place=place)
    return MonitorResult([found], Stop(last, _end("GRAZE", orbits, point), beyond=beyond))


def _vanishing(
    orbits: Orbits,
    start: OrbitPoint,
    left: Callable[[OrbitPoint], float | None],
    ahead: float,
    powers: Array = POWERS,
) -> Vanishing[OrbitPoint] | None:
    """Return where slip, a stop, or a margin vanishes ahead of a point, None if nowhere."""
    found = (locate_vanishing(orbits, start, left, each, ahead, powers) for each in BORDER.smallest)
    return next(filter(None, found), None)


def _at(point: OrbitPoint) -> tuple[Array, Constants]:
    """Return the nodes and the constants of an orbit."""
    orbits = point.curve.orbits
    return orbits.nodes(point.z), orbits.constants(point.z)


def _jumps(before: OrbitPoint, after: OrbitPoint) -> bool:
    """Whether contacts of the one forced orbit do what the other's do nowhere near in the period.

    Pieces of the same modes are not one then: other pieces lie between them.
    """
    orbits = after.curve.orbits
    if orbits.by.smooth or orbits.free_phase:
        return False
    sides = ((before, after), (after, before))
    groups = orbits.by.switched.groups(_at(after)[1])
    for group, pair in product(groups, sides):
        one, other = (item.curve.orbits.by.spans(*_at(item), group) for item in pair)
        for begin, end, mode in one:
            gaps = (
                abs((begin + end - a - b + orbits.period) % (2 * orbits.period) - orbits.period)
                - (end - begin + b - a)
                for a, b, same in other
                if same == mode
            )
            if min(gaps) > 2 * BORDER.elsewhere:
                return True
    return False


def _is_known(found: Found[OrbitPoint], traced: TracedCurve[OrbitPoint]) -> bool:
    """Whether the same change was met just before: by symmetry several contacts, or stops, may."""
    if not traced.found:
        return False
    last = traced.found[-1]
    near = found.point.arclength - last.point.arclength < max(PIECE.looks) + PIECE.apart
    return (
        last.type == found.type and near and abs(last.point.z[-1] - found.point.z[-1]) < BORDER.same
    )


def _last_change(traced: TracedCurve[OrbitPoint]) -> None:
    """Note a change of contacts next to the last point, and where the branch continues beyond.

    The orbit that only just meets the change solves equations that are smooth on both sides of it,
    and each side begins there: to which side an orbit nearer than rounding belongs is not defined.
    """
    last = traced.points[-1]
    orbits = last.curve.orbits
    by = orbits.by
    if not isinstance(by, SwitchedShooting) or isinstance(by, MarginalShooting):
        return
    change = _vanishes_ahead(traced, several=True) or _change_ahead(last, BORDER.nearly)
    change = change or _vanishes_ahead(traced, several=False)
    if change is not None:
        _note(traced, change)
        return
    release = by.slowest_end(*_at(last), Ending.YIELDS)
    if release is not None and release < BORDER.barely:
        traced.end = End("limit", RELEASED, last.curve.place(last.z))


def _note(traced: TracedCurve[OrbitPoint], change: Found[OrbitPoint]) -> None:
    """Note a change of contacts, and the first orbit beyond it."""
    last, met = traced.points[-1], change.point
    while len(traced.points) > 1 and traced.points[-1].arclength > met.arclength:
        traced.points.pop()  # rounding let it pass
    traced.found.append(change)
    traced.end = _end(change.type, met.curve.orbits, met)
    if isinstance(change, FoundGrazing):
        return
    beyond = _first_beyond(last, met)
    if beyond is not None:
        traced.points.append(beyond)


def _first_beyond(last: OrbitPoint, met: OrbitPoint) -> OrbitPoint | None:
    """Return the first orbit beyond a change of contacts next to the last orbit before it."""
    z, tangent = last.curve.moved(met)
    side = replace(met, tangent=tangent, piece=last.piece)
    beyond, by = beyond_end(last.curve, side, z, BORDER.nearly), last.curve.orbits.by
    # Next to slip that begins within a stop in the plane equations are too stiff to be solved
    return across_gap(last.curve, last) if beyond is None and by.slips_in_planes else beyond


def _vanishes_ahead(traced: TracedCurve[OrbitPoint], *, several: bool) -> FoundGrazing | None:
    """Return where orbits at the end of a piece graze several times, or slip only just stops.

    Beyond any of several grazings another motion follows, so that no orbit avoids them all; beyond
    a stop whose slope vanishes there is none. The place is extrapolated from orbits before it, in
    powers of the margin, or of the slope.
    """
    last = traced.points[-1]
    change = MarginalShooting.at(last.curve.orbits.by, *_at(last), "GRAZE") if several else None
    if several and (change is None or change.met.level or not change.met.several):
        return None

    def left(point: OrbitPoint) -> float:
        by, at = point.curve.orbits.by, _at(point)
        if change is not None:
            return change.condition_of(by, *at)[0]
        slope = by.slowest_end(*at, Ending.STOPS) if isinstance(by, SwitchedShooting) else None
        return (slope or 0.0) ** 2

    start = next((point for point in reversed(traced.points) if left(point) > BORDER.near), None)
    if start is None or start.piece != last.piece or not isinstance(start.curve, Orbits):
        return None
    ahead = last.arclength - start.arclength
    place = _vanishing(start.curve, start, left, 2 * ahead, POWERS if several else ROOTS)
    if place is None:
        return None
    beyond = float(np.linalg.norm(place.z - start.z)) - ahead
    if abs(beyond) > BORDER.nearly:
        return None
    return FoundGrazing("GRAZE", last, float("inf"), place=place)


def _change_ahead(point: OrbitPoint, farthest: float) -> Found[OrbitPoint] | None:
    """Return the nearest change of contacts within a distance of a point at which a piece ends."""
    orbits, nearest = point.curve.orbits, None
    by, at = orbits.by, _at(point)
    changes = [(kind, MarginalShooting.at(by, *at, kind)) for kind in GRAZED]
    changes += [("STICK", stop) for _, stop in MarginalShooting.stops_of(by, *at)[:1]]
    for kind, change in changes:
        if change is None or change.met.level:  # slip in the plane vanishes in its own way
            continue
        again, met = _only_just(point, change)
        if again is None or met is None:
            continue
        left = float(again.tangent @ (met.point.z - again.z))
        if BORDER.passed <= left <= farthest and (nearest is None or left < nearest[0]):
            nearest = (
                left,
                Found(kind, replace(met.point, arclength=point.arclength + left), np.inf),
            )
    return None if nearest is None else nearest[1]


def _only_just(point: OrbitPoint, change: MarginalShooting) -> tuple[OrbitPoint | None, Met | None]:
    """Return a point in terms of a change of contacts, and the orbit that only just meets it."""
    if not isinstance(point.curve, Orbits):  # on a locus both conditions would have to hold
        return None, None
    again = point.curve.described_by(change).converted(point)
    return again, None if again is None else solve_marginal(again.curve, again, [change])


def _change_between(before: OrbitPoint, after: OrbitPoint) -> Array | None:
    """Return the unknown at which an orbit between two only just meets their change of contacts."""
    met = _change_met(_kind(before.piece, after.piece), (after, before))
    return None if met is None else before.curve.moved(met)[0]


def _change_beside(last: OrbitPoint, kind: str, known: Sequence[OrbitPoint]) -> OrbitPoint | None:
    """Return the orbit next to the end of a piece that only just meets a change, if one is."""
    met = _change_met(kind, known)
    if met is None or np.linalg.norm(last.curve.moved(met)[0] - last.z) > BORDER.nearly:
        return None
    return met


def left_to_change(last: OrbitPoint, kind: str) -> float:
    """Return how far in the parameter the last orbit before a change may be from it.

    Zero where no orbit meets it, infinity where a breakdown leaves that unknown.
    """
    try:
        met = _met_from(last, kind)
        if met is None or np.linalg.norm(last.curve.moved(met.point)[0] - last.z) > BORDER.nearly:
            return 0.0
    except BREAKDOWNS:
        return np.inf
    return abs(float(met.point.z[-1] - last.z[-1])) + met.rounding


def _change_met(kind: str, known: Sequence[OrbitPoint]) -> OrbitPoint | None:
    """Return the orbit near one of some that only just meets a change of contacts, if one is found.

    Newton's method seldom converges from the side on which a second contact, or stop, changes too.
    """
    for point in known:
        with suppress(*BREAKDOWNS):
            met = _met_from(point, kind)
            if met is not None:
                return met.point
    return None


def _met_from(point: OrbitPoint, kind: str) -> Met | None:
    """Return the orbit near one that only just meets a change of contacts, if one is found."""
    by, at = point.curve.orbits.by, _at(point)
    if not isinstance(by, SwitchedShooting) or isinstance(by, MarginalShooting):
        return None
    if kind not in GRAZED:
        curve = point.curve
        return locate_marginal_stops(curve, point, None) if isinstance(curve, Orbits) else None
    change = MarginalShooting.at(by, *at, kind)
    if change is None or change.met.level:  # slip in the plane vanishes in its own way
        return None
    return _only_just(point, change)[1]


def _end(kind: str, curve: OrbitCurve, point: OrbitPoint) -> End:
    more = kind == "GRAZE" and _holds_more(point)
    reason = (
        f"{CONTACT_TYPES[kind].title}{HOLDS_MORE if more else ''}; no orbit was found beyond; to "
        "follow what trajectories converge to there, compute a response with settled=True that "
        "starts there (--start, --settled), or with gaps=True (--gaps)"
    )
    return End(BOUNDARY, reason, curve.place(point.z))


def _holds_more(point: OrbitPoint) -> bool:
    """Whether the contact that grazes has more static friction than kinetic."""
    by, at = point.curve.orbits.by, _at(point)
    if not isinstance(by, SwitchedShooting):
        return False
    change = by if isinstance(by, MarginalShooting) else MarginalShooting.at(by, *at, "GRAZE")
    if change is None:
        return by.holds_more(*at, slice(None), float(by.start[0]))
    return by.holds_more(*at, change.met.event.which, change.met.phase)


def beyond_boundary(traced: TracedCurve[OrbitPoint]) -> tuple[OrbitCurve, OrbitPoint] | None:
    """Return how a branch continues beyond the end of a piece, None where no orbit does."""
    if traced.end is not None and traced.end.kind == "failed" and len(traced.points) > 1:
        with suppress(*BREAKDOWNS):
            _last_change(traced)
    if traced.end is None or traced.end.kind != BOUNDARY:
        return None
    if closes_at_change(traced):
        return None
    beyond, last = _next_piece(traced), traced.points[-1]
    by = last.curve.orbits.by
    assert isinstance(by, SwitchedShooting)
    resting = by.rests(*_at(last))
    if resting is not None:
        traced.points.pop()
        traced.end = End("limit", resting, traced.end.values)
        return None
    if beyond is None:
        traced.end = End("failed", traced.end.reason, traced.end.values)
    return beyond


def _next_piece(traced: TracedCurve[OrbitPoint]) -> tuple[OrbitCurve, OrbitPoint] | None:
    after = traced.points[-1]
    before = after if len(traced.points) == 1 else traced.points[-2]
    if len(traced.points) > 1 and before.piece == after.piece:  # nothing is beyond
        return None
    curve, orbits = after.curve, after.curve.orbits
    renewed = curve.renewed([after])
    # Nothing is interpolated across the boundary: it is another curve.
    other = curve.described_by(orbits.by) if renewed is None else renewed[0]

    def moved(point: OrbitPoint) -> OrbitPoint | None:
        same = renewed is None and point.curve is curve
        return replace(point, curve=other) if same else other.converted(point)

    item, traced.ahead = traced.ahead, None
    apart = float(np.linalg.norm(after.z - before.z))
    if apart >= BORDER.beside and _kind(before.piece, after.piece) == "MEET":
        first = moved(after)  # so far from where changes meet that it has the tangent of its piece
        beyond = moved(item) if item else None
        if first and beyond and item:
            arclength, parameters = first.arclength + arc_between(first, beyond), len(orbits.widths)
            z = np.append(beyond.z[:-parameters], item.z[-parameters:])  # on a bound exactly
            traced.ahead = replace(beyond, z=z, arclength=arclength)
        return (other, first) if first else None
    known = [point for point in map(moved, ahead_of(curve, before, after)) if point is not None]
    if not known:
        return None
    first, ahead = known[0], known[-1]
    # Rounding may put the first one across the boundary, or its tangent.
    own = first.piece == ahead.piece and first.tangent @ ahead.tangent > BORDER.smooth
    return other, first if own else ahead


def _kind(before: Piece, after: Piece) -> str:
    """Return what happens between orbits that pass through some modes, and through others."""
    counted = [_counts(piece) for piece in (before, after)]
    if counted[0][Status.OPEN] != counted[1][Status.OPEN]:
        return "LIFT"
    if counted[0][Status.STICK] != counted[1][Status.STICK]:
        reversals = [sum(map(_reversals, piece)) for piece in (before, after)]
        return "STICK" if reversals[0] != reversals[1] else "GRAZE"
    return "MEET"


def _counts(piece: Piece) -> dict[Status, int]:
    """Return how often, in all contacts, each status begins on the way round."""
    found = dict.fromkeys(Status, 0)
    for modes in piece:
        for old, new in pairwise([modes[-1], *modes]):
            for was, now in zip(old, new, strict=True):
                found[now] += was is not now
    return found


def _reversals(modes: Sequence[Mode]) -> int:
    """Return how often slip changes its direction without any stick between."""
    return sum(
        int(was) * int(now) == -1
        for old, new in pairwise([modes[-1], *modes])
        for was, now in zip(old, new, strict=True)
    )
