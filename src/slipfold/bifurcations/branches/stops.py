"""Monitors that end a curve of orbits: limits, unresolved multipliers, families."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.bifurcations import BIFURCATION, slope_noise
from slipfold.bifurcations.branches.passed_pieces import with_passed
from slipfold.continuation.end import End
from slipfold.continuation.locate import locate
from slipfold.continuation.traced_curve import MonitorResult, StepInterval, Stop
from slipfold.orbits.limits import margins_at
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.shooting import RESOLVED


class STOP:
    """Rules for ending curves of orbits."""

    # Number of orbits at one value of the parameter after which a family ends. Around a center they
    # are thirty thousand times as large then, and rounding soon prevents corrections
    family: int = 150
    # Equilibria with one value of the parameter, none of them singular, after which they run away;
    # those of a whole branch, singular over a length of one, after which they are a family; points
    # of a locus at one place of the plane after which it stands still
    away: int = 10
    # Distance from the first orbit, in scales of states, beyond which an orbit runs away, as at an
    # undamped resonance: multipliers come within 1e-5 of one, and rounding makes branch points
    far: float = 5e4
    # Change of the parameter, in spans, that counts as zero: special points are located more
    # exactly, so that all further ones would have the same value
    constant: float = 1e-9
    # Component of a unit tangent along the parameters that is none: with a larger one they change
    # by less than `constant` only where steps are short, not where the locus stands still
    still: float = 1e-6
    # Arclength to which a limit is located: its bound is a convention within 1e-4 anyway
    limit_close: float = 1e-9
    # Ratio of the change of an orbit to an error of its equations: rounding of 1e-14 moves it by
    # 1e-5 then, more than Newton's method takes for rounding, and steps would become ever shorter
    loose: float = 1e9
    # Product of two multipliers beyond which it soon overflows
    overflows: float = 1e300
    # Distance of a multiplier from one beyond which errors move an orbit little
    one: float = 1e-3


LOOPS = ("homoclinic", "heteroclinic")
"""Kinds of ends at which cycles near a loop."""

Neared = tuple[str, str] | None
"""Which of them, and words for it; None where cycles near none."""


def stop_at_limit(interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
    """End a curve where the model ceases to be valid: at the first limit that is broken."""
    orbits = interval.point.curve.orbits
    if not (orbits.by.smooth and orbits.model.limits):  # a trajectory that meets one ends there
        return MonitorResult()
    return with_passed(interval, _broken)


def _broken(interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
    """End a curve at the first limit that it breaks between the last two known points."""
    curve, (before, after) = interval.traced.curve, interval.history[-2:]
    cuts = list[Stop[OrbitPoint]]()
    for index in (~(margins_at(after) > 0)).nonzero()[0].tolist():
        limit = curve.orbits.model.limits[index]

        def margin(item: OrbitPoint, index: int = index) -> float:
            return float(margins_at(item)[index])

        at = locate(curve, interval.history, before, after, margin, STOP.limit_close)
        reason = limit.reason.format(value=margin(at) + limit.bound)
        cuts.append(Stop(at, End("limit", reason, curve.place(at.z))))
    return MonitorResult(stop=min(cuts, key=lambda stop: stop.point.arclength, default=None))


def stop_unresolved(
    interval: StepInterval[OrbitPoint],
    neared: Callable[[Sequence[OrbitPoint]], Neared] = lambda points: None,
) -> MonitorResult[OrbitPoint]:
    """End a curve before an orbit too unstable for its multipliers to be known.

    `neared` says where the curve leads, from its points so far; if that is known, it is the reason.
    """
    *_, second, largest = (1.0, 1.0, *np.sort(np.abs(interval.point.multipliers)))
    curve = interval.traced.curve
    growing = curve.orbits.by.growing
    if largest <= (STOP.overflows / max(second, 1.0) if growing else RESOLVED):
        return MonitorResult()
    reason = (
        f"a multiplier of {largest:.1e} leaves too few digits for the others, so bifurcations "
        "could be missed beyond; the orbit is practically unobservable there"
    )
    kind, leads = neared(interval.traced.points) or ("unresolved", "")
    reason = f"{leads}; {reason}" if leads else reason
    end = End(kind, reason, curve.place(interval.point.z))
    return MonitorResult(stop=Stop(interval.before, end))


def stop_undetermined(interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
    """End a branch where its orbits belong to a family, to rounding.

    Undamped orbits of large amplitude do: the forcing has almost no effect, and any phase is
    possible. The second orbit in a row that rounding moves far is the last; one is a branch point.
    """
    if interval.leaves or not _moves(interval.before) > STOP.loose:
        return MonitorResult()
    moves = _moves(interval.point)
    if not moves > STOP.loose:
        return MonitorResult()
    reason = (
        f"an error of the equations moves the orbit by {moves:.0e} times as much: to rounding "
        "it belongs to a family, with any phase; with a little damping there is one orbit"
    )
    end = End("unresolved", reason, interval.traced.curve.place(interval.point.z))
    return MonitorResult(stop=Stop(interval.point, end))


def _moves(point: OrbitPoint) -> float:
    """Return the ratio of changes of an orbit to errors of its equations; 0 if it is small."""
    orbits, part = point.curve, point.linearization
    if part is None or np.abs(point.multipliers - 1).min(initial=np.inf) > STOP.one:
        return 0.0
    bordered = part.bordered(point.tangent)
    last = range(orbits.size - len(orbits.scales), orbits.size)  # ends of the last segment
    moves = [np.linalg.norm(bordered.solve(np.eye(1, len(point.z), i)[0])) for i in last]
    return float(np.sqrt(orbits.segments) * max(moves))


def stop_standing(interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
    """End a locus along which both parameters stand still, as where all states are critical.

    Towards a homoclinic orbit they do so too, while the duration grows. A cusp is one point.
    """
    points = [*interval.traced.points, interval.point][-STOP.away :]
    places = np.array([point.z[-2:] for point in points])
    along = np.array([point.tangent[-2:] for point in points])
    moves = np.ptp(places, axis=0).max() > STOP.constant or np.abs(along).max() > STOP.still
    if len(points) < STOP.away or moves:
        return MonitorResult()
    curve = interval.traced.curve
    orbits, place = curve.orbits, curve.place(interval.point.z)
    rounded = np.where(np.abs(places[-1]) < STOP.constant, 0.0, place)
    at = ", ".join(f"{n} = {v:.9g}" for n, v in zip(orbits.varied, rounded, strict=True))
    still = f"the locus stands still at {at}: its last {STOP.away}"
    durations = orbits.durations(points) if orbits.free_phase else None
    if durations is not None and (np.diff(durations) > STOP.constant * durations[1:]).all():
        reason = (
            f"{still} cycles take ever longer there, {durations[0]:.4g} to {durations[-1]:.4g} "
            "s, as towards a homoclinic orbit"
        )
        return MonitorResult(stop=Stop(interval.point, End("duration", reason, place)))
    what = "equilibria" if orbits.kind == "equilibrium" else "orbits"
    reason = f"{still} {what} are all critical there, to rounding; choose other parameters"
    return MonitorResult(stop=Stop(interval.point, End("family", reason, place)))


def stop_in_family(interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
    """End a branch at the last of many points with the same value of the parameter.

    The cycles around a center form such a family, which has no natural end.
    """
    orbits = interval.traced.curve
    points = [*interval.traced.points, interval.point][-STOP.family :]
    value, rounded = orbits.value(interval.point.z), _rounded(orbits, interval.point)
    many, rests = len(interval.traced.points) >= STOP.family, orbits.kind == "equilibrium"
    if rests and len(points) >= STOP.away:  # a branch that is constant here is so everywhere
        many |= bool(np.linalg.norm(points[-1].z - points[0].z) > 1)
    first = interval.traced.points[0]  # a vibration about a large mean does not run away
    start = first.curve.orbits.nodes(first.z)[0]
    moved = size_in_scales(orbits, interval.point, start)
    far = not rests and moved > STOP.far
    if (many or far) and in_family(points):
        return MonitorResult(stop=Stop(interval.point, family_end(orbits, points)))
    if far:
        where = f" at {orbits.vary} = {rounded:.9g}"
    elif rests and _runs_away(points[-STOP.away :]):
        where = f" while {orbits.vary} stays at {value:.9g}"
    else:
        return MonitorResult()
    reason = far_away(orbits, interval.point, where)
    end = End("unresolved", reason, orbits.place(interval.point.z))
    return MonitorResult(stop=Stop(interval.point, end))


def family_end(orbits: Orbits, points: Sequence[OrbitPoint]) -> End:
    """Say that points of a branch are a family."""
    what, center = (
        ("equilibria", "on a line")
        if orbits.kind == "equilibrium"
        else ("orbits", "around a center")
    )
    reason = (
        f"{len(points)} {what} have the same {orbits.vary} = {_rounded(orbits, points[-1]):.9g}: "
        f"they are a family, as {center}, and it continues; give an event at which it ends"
    )
    return End("family", reason, orbits.place(points[-1].z))


def _rounded(orbits: Orbits, point: OrbitPoint) -> float:
    """Return the first parameter of a point, zero where it is no more than rounding."""
    return 0.0 if abs(point.z[-1]) < STOP.constant else orbits.value(point.z)


def in_family(points: Sequence[OrbitPoint]) -> bool:
    """Whether the parameter is constant and every orbit is singular.

    In a canard explosion the parameter is constant as well, but orbits are regular; and where steps
    are short, it changes little from one to the next.
    """
    values, last = [point.z[-1] for point in points], points[-1]
    if abs(last.tests["LP"]) > max(BIFURCATION.noise, slope_noise(last)):
        return False
    folds = all(abs(point.tests["fold"]) < BIFURCATION.on_circle for point in points)
    return max(values) - min(values) <= STOP.constant and folds


def _runs_away(points: Sequence[OrbitPoint]) -> bool:
    """Whether equilibria move though the parameter does not: none of them is singular."""
    values = [point.z[-1] for point in points]
    regular = all(abs(point.tests["fold"]) > BIFURCATION.on_circle for point in points)
    return len(points) == STOP.away and max(values) - min(values) < STOP.constant and regular


def size_in_scales(orbits: Orbits, point: OrbitPoint, start: Array | float = 0.0) -> float:
    """Return the largest distance of an orbit from a state, in the scales of states."""
    return float(np.abs((orbits.nodes(point.z) - start) / orbits.scales).max())


def far_away(orbits: Orbits, point: OrbitPoint, where: str) -> str:
    """Say which state has become large."""
    nodes = orbits.nodes(point.z)
    node, farthest = divmod(int(np.abs(nodes / orbits.scales).argmax()), nodes.shape[1])
    name = orbits.flow.output_names[farthest]
    what = orbits.kind if orbits.kind == "equilibrium" else "orbit"
    state = nodes[node, farthest]
    return (
        f"the {what} runs away to {name} = {state:.4g}{where}; a limit of {name} ends the branch "
        "earlier"
    )
