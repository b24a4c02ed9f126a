"""Special points at which other branches begin, and which branches they join."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.bifurcations.branches.bifurcations import BIFURCATION, SeveralCritical
from slipfold.bifurcations.branches.closed_branches import halves_pass_alike, same_orbit
from slipfold.bifurcations.branches.homoclinic import snakes_about
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.standing import Collision
from slipfold.bifurcations.branches.start import method_for
from slipfold.continuation.curve_set import FollowedCurve, Start
from slipfold.continuation.step_length import STEP
from slipfold.continuation.traced_curve import Found, TracedCurve
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.bifurcation_types import CONTACT_TYPES
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.critical import doubled_orbit, hopf_cycle
from slipfold.orbits.kinds import Equilibria
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.test_functions import ALIKE, angles_on_circle, match_multipliers


@dataclass(frozen=True, eq=False)
class Junction(Start[OrbitPoint]):
    """A special point of a known branch at which another branch begins."""

    several: bool = False  # whether other branches begin there as well, as by a symmetry


def rank_of(curve: Orbits) -> tuple[int, int]:
    """Return the priority of a branch: equilibria come before cycles, shorter periods earlier."""
    return int(curve.kind != "equilibrium"), curve.period


def junctions_on(
    followed: FollowedCurve[OrbitPoint], settings: Settings, known: int = 0
) -> list[Junction]:
    """Return the points of a branch at which others begin.

    So many period doublings were found on the branches before it.

    Equilibria are followed before cycles, and shorter periods before longer ones, since a branch
    may end where another one begins. A branch that snakes to a homoclinic orbit has infinitely many
    such points: those near its end are excluded, and so are longer periods. So they are where
    branches double many times, as in canard explosions or without damping.
    """
    junctions, traced = [], followed.traced
    about = snakes_about(traced.found, followed.started, traced.end)
    doublings = known + sum(found.type == "PD" for found in traced.found)
    crowded = bool(about) or doublings > BIFURCATION.crowded
    largest = min(settings.largest_period, settings.snaking_period if crowded else np.inf)
    for place, found in enumerate(traced.found):
        orbits, left = found.point.curve, [abs(found.point.z[-1] - value) for value in about]
        if min(left, default=np.inf) < BIFURCATION.tail:
            continue
        try:
            if isinstance(found, SeveralCritical):
                children, found = branches_around(orbits, found, largest)
                traced.found[place] = found
            elif found.type in CONTACT_TYPES:
                children = doubled_at_change(traced, found, largest)
            else:
                children = emanating_branches(orbits, found, settings, largest)
        except BREAKDOWNS:  # no branch can be followed from there; the point itself is reported
            continue
        for start in children:
            curve = start.curve
            # At a branch point the other branch continues in both directions.
            several = isinstance(found, SeveralCritical) or len(children) > 1
            crosses = found.type == "BP" and not several
            both = (start, curve.turned(start)) if crosses else (start,)
            common = curve, both, rank_of(curve), True, followed.number, found
            junctions.append(Junction(*common, several=several))
    if about and traced.end is not None:
        reason = (
            f"{traced.end.reason}; what begins within {BIFURCATION.tail:g} of the span of where it "
            "turns is not followed (a narrower span shows it), and no period above "
            f"{largest:g}"
        )
        traced.end = replace(traced.end, reason=reason)
    elif largest < settings.largest_period and traced.end is not None:
        reason = (
            f"{traced.end.reason}; branches double {doublings} times up to there, and of what "
            f"doubles on this one no period above {largest:g} is followed unless requested "
            "(--largest-period)"
        )
        traced.end = replace(traced.end, reason=reason)
    return junctions


def emanating_branches(
    orbits: Orbits, found: Found, settings: Settings, largest: float
) -> list[OrbitPoint]:
    """Return the first points of branches that begin at a special point.

    None of too long a period. At a Hopf point several pairs of eigenvalues may be critical: cycles
    of each frequency are followed.
    """
    if found.type == "BP" and found.other is not None:
        tests = {**found.point.tests, "LP": float(found.other[-1])}
        return [replace(found.point, tangent=found.other, arclength=0.0, tests=tests)]
    z, residual = found.point.z, found.point.residual
    cycles = settings.largest_period > 0
    if isinstance(found, Collision):  # families of cycles lie beside it, at any value
        return []
    if isinstance(orbits, Equilibria) and found.type == "HB" and cycles:
        method = partial(method_for, settings)
        angles = np.sort(angles_on_circle(found.point.moving))
        begins = np.flatnonzero(np.diff(angles, prepend=-1.0) > ALIKE)
        if len(angles) < 2 and orbits.standing is None:
            return [hopf_cycle(orbits, z, residual, method)]
        first = list[OrbitPoint]()
        for at, count in zip(begins, np.diff(begins, append=len(angles)), strict=True):
            cycle = partial(
                hopf_cycle, orbits, z, residual, method, frequency=angles[at] / orbits.unit(z)
            )
            first += cycles_around(orbits.jacobian(z), cycle, angles[at], count)
        return sorted(first, key=lambda each: each.curve.duration(each.z))
    if found.type == "PD" and 2 * orbits.period <= largest:
        return [doubled_orbit(orbits, z, residual)]
    return []


def doubled_at_change(
    traced: TracedCurve[OrbitPoint], found: Found, largest: float
) -> list[OrbitPoint]:
    """Return the orbit whose contacts change, passed twice, if doubled orbits begin there.

    The return map is continuous there, with other derivatives A and B on either side. Orbits that
    pass the change in every second period begin there if A and B together have an odd number of
    real eigenvalues below -1: M. di Bernardo, M. I. Feigin, S. J. Hogan and M. E. Homer, Chaos,
    Solitons and Fractals 10 (1999) 1881-1908. To first order they are fixed points of B A.
    """
    sides = _sides_of(traced, found)
    if sides is None or 2 * sides[0].curve.period > largest:
        return []
    if sides[0].curve.by.slips_in_planes:  # where the map has no derivative at a grazing
        return []
    flips = [
        np.count_nonzero((side.multipliers.imag == 0) & (side.multipliers.real < -1))
        for side in sides
    ]
    if sum(flips) % 2 == 0:
        return []
    orbits = sides[0].curve
    z, _ = orbits.moved(found.point)
    child = orbits.with_period(2 * orbits.period)
    first, second = (orbits.linearize(side.z) for side in sides)
    blocks = second.blocks @ first.blocks
    twice = replace(first, blocks=blocks, along=second.blocks @ first.along + second.along)
    along = np.linalg.svd(twice.jacobian)[2][-1]
    # Along one of both ways the first period is that before the change. From the other, Newton's
    # method leads to the same orbit a period later.
    near = list[tuple[float, Array, OrbitPoint]]()
    for row in (along, -along):
        guess = z + STEP.emanating * row
        doubled = child.nearest(guess, row)
        if doubled is not None and not halves_pass_alike(doubled):
            near.append((float(np.linalg.norm(doubled.z - guess)), row, doubled))
    if not near:
        return []
    _, row, doubled = min(near, key=lambda item: item[0])
    start = child.derived_point(z, row, 0.0, twice.monodromy, sides[0].residual)
    return [replace(start, piece=doubled.piece)]


def _sides_of(
    traced: TracedCurve[OrbitPoint], found: Found
) -> tuple[OrbitPoint, OrbitPoint] | None:
    """Return the orbits next to a change of contacts; None where the branch does not pass it."""
    at = found.point.arclength

    def left(pair: tuple[OrbitPoint, OrbitPoint]) -> float:
        return max(pair[0].arclength - at, at - pair[1].arclength, 0.0)

    changes = [pair for pair in pairwise(traced.points) if pair[0].piece != pair[1].piece]
    if not changes:
        return None
    before, after = min(changes, key=left)
    if left((before, after)) > BIFURCATION.located or not isinstance(before.curve, Orbits):
        return None
    again = before.curve.converted(after)
    return None if again is None else (before, again)


def branches_around(
    orbits: Orbits, found: SeveralCritical, largest: float
) -> tuple[list[OrbitPoint], SeveralCritical]:
    """Return the first points of branches that leave one where several multipliers are critical.

    There the Jacobian has a kernel of more dimensions than two: the tangent of the branch that is
    known, and a space. Branches cross a small sphere in it in isolated points, which Newton's
    method finds from directions all around. Of branches that are symmetric images of each other one
    is followed. The point is returned as well, with how many are not, and how many hardly were
    found.
    """
    point = found.point
    if found.type == "PD":
        if 2 * orbits.period > largest:
            return [], found
        # Along the parent an orbit does the same twice.
        moved = point.z + BIFURCATION.differenced * point.tangent
        first, beside = (doubled_orbit(orbits, z, point.residual) for z in (point.z, moved))
        along = (beside.z - first.z) / BIFURCATION.differenced
        orbits, point = first.curve, replace(first, tangent=along)
    right = np.linalg.svd(orbits.linearize(point.z).jacobian)[2][-1 - found.count :]
    along = right @ point.tangent
    space = np.linalg.svd(along[None])[2][1:] @ right
    points, times = _crossing(orbits, point, space, BIFURCATION.radius, BIFURCATION.sphere)
    distinct = _distinct(orbits, point, points)
    children = []
    for item in distinct:
        tangent = (item.z - point.z) / np.linalg.norm(item.z - point.z)
        tests = {**point.tests, "LP": float(tangent[-1])}
        start = replace(point, tangent=tangent, arclength=0.0, tests=tests, linearization=None)
        children.append(start)
    rare = sum(each < BIFURCATION.times for each in times) if found.count > 2 else 0
    return children, replace(found, images=len(points) - len(distinct), rare=rare)


def cycles_around(
    jacobian: Array, cycle: Callable[..., OrbitPoint], angle: float, count: int
) -> list[OrbitPoint]:
    """Return the first points of branches of cycles where several pairs have one frequency.

    Any combination of the critical vectors turns, but few are directions of branches, as those of
    waves round a ring. They are found like branches that leave one where several multipliers are
    critical; the amplitude has to be larger, since cycles of any direction close to its third
    power. `cycle` makes a cycle of no amplitude, of a given critical vector if there is one.
    """
    first = cycle()
    if count == 1:
        return [first]
    child, none = first.curve, np.zeros(len(first.curve.units))
    vectors = np.linalg.svd(jacobian - 1j * angle * np.eye(len(jacobian)))[2][-count:].conj()
    turns = np.exp(2j * np.pi * np.arange(child.segments) / child.segments)[:, None]
    rows = [
        np.append(np.real(turns * q), none) for vector in vectors for q in (vector, 1j * vector)
    ]
    space = np.linalg.qr(np.transpose(rows))[0].T
    points, _ = _crossing(child, first, space, BIFURCATION.amplitude, BIFURCATION.round)
    moved = [(item.z - first.z) @ space.T @ space for item in _distinct(child, first, points)]
    turned = [(turns.conj() * away[: child.size].reshape(len(turns), -1)).sum(0) for away in moved]
    return [cycle(vector=vector) for vector in turned] or [first]


def _crossing(
    orbits: Orbits, point: OrbitPoint, space: Array, radius: float, batch: int
) -> tuple[list[OrbitPoint], list[int]]:
    """Return where branches cross a small sphere in a space, and from how many directions."""
    points, times = list[OrbitPoint](), list[int]()
    for number, direction in enumerate(_directions(len(space), batch)):
        if number % batch == 0 and min(times, default=0) >= BIFURCATION.times:
            break
        row, counted = direction @ space, 1
        while (item := _beside(orbits, point, row, space, radius)) is not None:
            same = [orbits.distance(item.z, other.z) <= ALIKE for other in points]
            if any(same):
                times[same.index(True)] += counted
                break
            points.append(item)
            times.append(counted)
            # The branch goes on there. What is found so says nothing of the directions.
            row, counted = (point.z - item.z) @ space.T @ space, 0
    return points, times


def _distinct(orbits: Orbits, point: OrbitPoint, points: Sequence[OrbitPoint]) -> list[OrbitPoint]:
    """Return orbits of branches around a point, of images one."""
    distinct: list[tuple[OrbitPoint, dict[float, Complex]]] = []
    for item in points:
        spectra = dict(_spectra(orbits, point, item))
        if not any(_are_images(spectra, known) for _, known in distinct):
            distinct.append((item, spectra))
    return [item for item, _ in distinct]


def _directions(count: int, batch: int) -> Array:
    """Return directions all around in so many dimensions, of any length.

    In more than two there is no telling how few of them lead to a branch: where some branches were
    found from one or two only, others may have been missed.
    """
    if count == 2:
        angles = 2 * np.pi * np.arange(BIFURCATION.directions) / BIFURCATION.directions
        return np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.random.default_rng(0).normal(size=(BIFURCATION.most * batch, count))


def _beside(
    orbits: Orbits, point: OrbitPoint, row: Array, space: Array, radius: float
) -> OrbitPoint | None:
    """Return the orbit of another branch that lies near a direction; None if none is found."""
    found = None
    for _ in range(3):  # until the row is the direction of the branch itself
        row = row / np.linalg.norm(row)
        guess = _nearest_orbit(orbits, point.z, radius * row, space)
        found = orbits.nearest(guess, row)
        if found is None:
            return None
        row = (found.z - point.z) @ space.T @ space
    return found


def _nearest_orbit(orbits: Orbits, z: Array, away: Array, space: Array) -> Array:
    """Return what satisfies the equations best with a given displacement in a space.

    The parameter is right then, and Newton's method does not lead to a branch farther round.
    Shapes: z, away (u,); space (k, u).
    """
    near = z + away
    for _ in range(3):
        part = orbits.linearize(near)
        matrix = np.vstack([part.jacobian, space])
        missing = np.concatenate([-part.defect, space @ (z + away - near)])
        near = near + np.linalg.lstsq(matrix, missing, rcond=None)[0]
    return near


def _spectra(
    orbits: Orbits, point: OrbitPoint, item: OrbitPoint
) -> Iterator[tuple[float, Complex]]:
    """Yield changes of the parameter along a branch from an orbit, and the multipliers there."""
    rise, ratio = float(item.z[-1] - point.z[-1]), BIFURCATION.ratio
    if abs(rise) < BIFURCATION.alike:  # it hardly changes: with which power is rounding
        yield 0.0, item.multipliers
        return
    first = int(np.ceil(np.log(abs(rise) / BIFURCATION.compared) / np.log(ratio)))
    for wanted in np.copysign(BIFURCATION.compared * ratio ** np.arange(first, 1.0), rise).tolist():
        away, along = item.z - point.z, item.tangent
        with np.errstate(all="ignore"):  # it changes with a power of the distance
            grows = float(along[:-1] @ away[:-1]) / float(away[:-1] @ away[:-1])
            guess = point.z + away * (wanted / away[-1]) ** (grows * away[-1] / along[-1])
        guess[-1] = point.z[-1] + wanted
        reach = 0.2 * float(np.linalg.norm(guess - point.z))
        row = hold_parameter(len(point.z) - 1)
        found = orbits.nearest(guess, row, within=reach, reach=reach)
        if found is None:  # it is on another branch
            return
        item = found
        yield wanted, item.multipliers


def _are_images(first: dict[float, Complex], second: dict[float, Complex]) -> bool:
    """Whether two branches are images: wherever the parameter is the same, spectra are.

    The scales of states, and with them the distances of two images, need not be symmetric.
    """
    apart = [
        np.abs(match_multipliers(first[rise], second[rise]) - first[rise]).max()
        / max(1.0, np.abs(first[rise]).max())
        for rise in first.keys() & second.keys()
    ]
    return bool(max(apart, default=np.inf) < BIFURCATION.alike)


def find_meeting(junction: Junction, known: Sequence[Junction]) -> Junction | None:
    """Return the same branch point as it was found on a known branch, if it was."""
    return next((other for other in known if _are_one(junction, other)), None)


def run_together(junction: Junction, other: Junction) -> bool:
    """Whether the branches on which one branch point was found twice are one, and do not cross.

    So they are where both ways round a closed curve begin at a point of many directions. How the
    parameter changes along them, and the duration, does not depend on the phase.
    """
    first, second = junction.found, other.found
    if first is None or second is None or second.other is None:
        return False
    free = len(first.point.curve.units)
    own, known, crossing = (
        each[-free:] for each in (first.point.tangent, second.point.tangent, second.other)
    )

    def apart(one: Array) -> float:
        return min(float(np.linalg.norm(own - one)), float(np.linalg.norm(own + one)))

    return apart(known) < apart(crossing)


def _are_one(junction: Junction, other: Junction) -> bool:
    """Whether two branch points are the same orbit, whatever its phase."""
    if junction.found is None or other.found is None:
        return False
    if (junction.found.type, other.found.type) != ("BP", "BP"):
        return False
    point, known = junction.found.point, other.found.point
    orbits, their = point.curve, known.curve
    if (orbits.kind, orbits.period) != (their.kind, their.period):
        return False
    if abs(orbits.value(point.z) - their.value(known.z)) >= BIFURCATION.same_value * orbits.width:
        return False
    return same_orbit(orbits, point.z, known)
