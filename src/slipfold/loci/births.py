"""Loci of orbits that are born at another orbit: where they begin, and where they end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.closed_branches import MeetsCopy, asymmetry
from slipfold.branches.settings import Settings
from slipfold.continuation.end import End
from slipfold.continuation.follow import BIRTH, follow
from slipfold.continuation.search import Found
from slipfold.continuation.trail import Sight, Stop, Stretch
from slipfold.continuation.walk import Failure, walk
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.loci.locus import CODIMENSION_TWO
from slipfold.loci.locus_equations import LocusEquations
from slipfold.loci.special_points import TWO_PAIRS, SpecialPoints
from slipfold.loci.start import LocusStart, is_complex, of_each_pair, passing, regular_start
from slipfold.orbits.critical import (
    Emanating,
    critical_direction,
    crossing_gap,
    doubled_orbit,
    hopf_cycle,
)
from slipfold.orbits.eigenvalues import Cayley
from slipfold.orbits.kinds import Equilibria
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.test_functions import floquet_multipliers

BORN = {
    "GH": (("LP", 0),),
    "HH": (("NS", 0), ("NS", 1)),
    "ZH": (("NS", 0), ("BP", 0)),
    "GPD": (("LP", 0),),
    "R2": (("NS", 0),),
}
"""Types of the loci of cycles that are born at an equilibrium or of orbits of twice the period, by
type of the point of codimension two; of cycles also the number of the critical pair."""

CROSSED = 1e-6
"""A branch point at which the other parameter parts the branches is farther from a crossing."""

FIRST_STEPS = (BIRTH, 4 * BIRTH, 16 * BIRTH)
"""First steps that are tried: equations of folds vanish with the third power of the amplitude."""

NEAR = 0.02
"""Distance between the halves of an orbit, in scaled states, below which its parent is looked at:
there a locus is a parabola, and the last digits of its equations are lost."""

REACH = 4.0
"""Values of the parameters within so many times that distance may be those of its parent."""

STEPS = 16
"""Points of the parent's locus on either side."""


def starts_at(
    trail: LocusEquations, found: Found, types: Sequence[str], settings: Settings
) -> Iterator[LocusStart]:
    """Return the loci of some types that begin or pass at a point of codimension two, but its own.

    Through LPPD, LPNS, PDNS, BT, ZH, R1 and R2 pass loci of two types, of which that of pairs ends
    at BT, R1 and R2; through HH and NSNS two of the same type. Folds of cycles are born at GH, of
    doubled orbits at GPD; tori of cycles at HH, one locus for each pair, and at ZH, of doubled
    orbits at R2.
    """
    point, orbits, condition = found.point, found.point.curve.orbits, trail.condition
    # A point may be described by the equations of another locus that passes there.
    curve = LocusEquations(orbits, condition)
    if (found.type, condition) == ("DP", "BP"):
        yield from _leaving_along(orbits, "LP", point, "DP", settings)
        return
    if found.type in TWO_PAIRS:
        yield from of_each_pair(curve, point.z, settings)
    yield from passing(curve, found, types, settings)
    crossed = crossing_gap(orbits, point.z) < CROSSED
    if found.type == "ZH" and crossed and "HB" in types:
        yield from _leaving_along(orbits, "HB", point, "", settings)
    born = [] if (found.type, condition) == ("R2", "NS") else [*BORN.get(found.type, ())]
    if found.type == "ZH":  # of a symmetry, other cycles branch off; without it, tori begin
        born = [item for item in born if (item[0] == "BP") == crossed]
    for kind, pair in [item for item in born if item[0] in types]:
        yield from _born(_newborn(orbits, point.z, pair), kind, point, settings)


def _newborn(orbits: Orbits, z: Array, pair: int) -> Emanating:
    if isinstance(orbits, Equilibria):
        return hopf_cycle(orbits, z, pair=pair)
    return doubled_orbit(orbits, z)


def _born(
    first: Emanating, condition: str, parent: OrbitPoint, settings: Settings
) -> Iterator[LocusStart]:
    """Return the locus of orbits that are born at a point, unless it leads to their parents."""
    curve = LocusEquations(first.orbits, condition)
    start = _leaving(curve, first.z, first.tangent, first.monodromy, parent.residual)
    if start is None:
        return
    for step in FIRST_STEPS:
        after = next(iter(walk(curve, [start], step, (), settings)))
        if isinstance(after, Failure):
            continue
        if np.linalg.norm(asymmetry(first.orbits, after.z)) < 0.5 * BIRTH:
            continue
        if condition != "NS" or is_complex(after):
            yield LocusStart(curve, (start,), departs=True, doubled=True, step=step)
        return


def _leaving_along(
    orbits: Orbits, condition: str, point: OrbitPoint, crosses: str, settings: Settings
) -> Iterator[LocusStart]:
    """Return the locus that leaves an orbit of a symmetry along the vector that breaks it.

    Half of it mirrors the other. Its equations hold on all orbits of the symmetry as well.
    """
    tangent = np.append(critical_direction(orbits, point.z), np.zeros(2))
    curve = LocusEquations(orbits, condition)
    start = _leaving(curve, point.z, tangent, point.monodromy, point.residual)
    if start is None:
        return
    after = next(iter(walk(curve, [start], BIRTH, (), settings)))
    if not isinstance(after, Failure) and abs(float((after.z - point.z) @ tangent)) > 0.5 * BIRTH:
        images = after.z, 2 * point.z - after.z
        yield LocusStart(curve, (start,), departs=True, crosses=crosses, beside=images)


def _leaving(
    curve: LocusEquations, z: Array, tangent: Array, monodromy: Array, residual: float
) -> OrbitPoint | None:
    """Return the first point of a locus that leaves another one, where its equations are singular.

    None if its orbit cannot be integrated. Shapes: monodromy (n, n).
    """
    linearisation = curve.orbits.linearise(z)
    if not np.isfinite(linearisation.blocks).all():
        return None
    multipliers = floquet_multipliers(monodromy)
    return OrbitPoint(
        z,
        tangent,
        0.0,
        curve.tests(z, linearisation, multipliers, tangent),
        0,
        residual,
        piece=curve.orbits.piece(z),
        curve=curve,
        monodromy=monodromy,
        multipliers=multipliers,
    )


# -- where they end ---------------------------------------------------------------------------


def parents_of(curve: LocusEquations, reached: OrbitPoint, settings: Settings) -> LocusStart | None:
    """Return the locus of the parents at which a locus ends, from what it ended on.

    That is one of its own orbits, or the point of theirs that those are born at.
    """
    own, other = curve.orbits, reached.curve.orbits
    if (own.kind, own.period) == (other.kind, other.period):
        return _parent_start(curve, reached, settings)
    try:
        return regular_start(reached.curve, reached.z, settings)
    except InputError:
        return None


def _parent_start(
    curve: LocusEquations, point: OrbitPoint, settings: Settings
) -> LocusStart | None:
    """Return the period doubling or Hopf point that an orbit shrinks to."""
    orbits = curve.orbits
    nodes = orbits.nodes(point.z)
    if orbits.period % 2:
        resting = Equilibria(orbits.model, orbits.varied, Cayley())
        z = resting.pack(nodes.mean(axis=0, keepdims=True), orbits.values(point.z))
        parent = LocusEquations(resting, "HB")
    else:
        half = orbits.with_period(orbits.period // 2)
        rounds = [half.by.start, half.by.start + half.period]
        halves = orbits.by.states(nodes, orbits.constants(point.z), np.concatenate(rounds))
        both = halves.reshape(2, half.segments, -1)
        z = half.join(both.mean(axis=0), orbits.free_values(point.z))
        parent = LocusEquations(half, "PD")
    try:
        return regular_start(parent, z, settings)
    except InputError:
        return None


class EndsAtParent:
    """Ends a locus where its orbits shrink to those that they are born at.

    Newton's method is singular there, the more so the higher the order to which equations vanish:
    the point of codimension two at which they are born is looked for on the locus of the parents.
    """

    def __init__(self, curve: LocusEquations, settings: Settings) -> None:
        self._curve = curve
        self._settings = settings
        self._meets = MeetsCopy(curve, partial(_at_parent, curve))

    def watch(self, stretch: Stretch[OrbitPoint]) -> Sight[OrbitPoint]:
        """Return the end, if an orbit is near its parent, or the locus goes on as its own copy."""
        if stretch.leaves:
            return Sight()
        orbits = self._curve.orbits
        before, here = (
            float(np.linalg.norm(asymmetry(orbits, item.z)))
            for item in (stretch.before, stretch.point)
        )
        if here < min(before, NEAR):
            stop = ends_beside_parent(self._curve, stretch.point, self._settings)
            if stop is not None:
                return Sight(stop=stop)
        sight = self._meets.watch(stretch)
        if sight.stop is None:
            return sight
        named = ends_beside_parent(self._curve, sight.stop.point, self._settings)
        return Sight(stop=named or sight.stop)


def _at_parent(curve: LocusEquations, last: OrbitPoint, meeting: object) -> Stop[OrbitPoint]:
    """Return the end of a locus where the halves of its orbits become the same."""
    reason = f"the locus ends where its orbits {_shrinking(curve.orbits)}"
    return Stop(last, End("codimension-2", reason, curve.place(last.z)), reached=last)


def _shrinking(orbits: Orbits) -> str:
    doubled = orbits.period % 2 == 0
    return "become those of half the period" if doubled else "shrink to an equilibrium"


def ends_beside_parent(
    curve: LocusEquations, last: OrbitPoint, settings: Settings
) -> Stop[OrbitPoint] | None:
    """Return the end of a locus at the point of codimension two that its orbits are born at.

    None if there is no such point near its last orbit.
    """
    apart = float(np.linalg.norm(asymmetry(curve.orbits, last.z)))
    kinds = {kind for kind, born in BORN.items() if curve.condition in dict(born)}
    try:
        start = _parent_start(curve, last, settings) if kinds else None
        found = None if start is None else _nearest(start, kinds, REACH * apart, last, settings)
        return None if found is None else _end(curve, last, found)
    except BREAKDOWNS:
        return None


def _nearest(
    start: LocusStart, kinds: set[str], reach: float, last: OrbitPoint, settings: Settings
) -> Found | None:
    """Return the nearest point of some types on a locus, if one is within reach."""
    curve = start.curve
    first = start.points[0]
    count = len(first.z)
    bounds = [(i, first.z[i] - reach, first.z[i] + reach) for i in (count - 2, count - 1)]
    few = replace(settings, steps=replace(settings.steps, points=STEPS))
    found = [
        item
        for point in start.points
        for item in follow(
            curve, point, bounds, [SpecialPoints(curve)], settings=few, first_step=reach / STEPS
        ).found
        if item.type in kinds
    ]
    free = last.z[-2:]
    return min(
        found, key=lambda item: float(np.linalg.norm(item.point.z[-2:] - free)), default=None
    )


def _end(curve: LocusEquations, last: OrbitPoint, found: Found) -> Stop[OrbitPoint] | None:
    """Return the end of a locus at a point of its parents, with the orbit that both share."""
    orbits, parents = curve.orbits, found.point.curve.orbits
    pairs = {pair for condition, pair in BORN[found.type] if condition == curve.condition}
    firsts = [_newborn(parents, found.point.z, pair) for pair in sorted(pairs)]
    adopted = [orbits.in_phase(orbits.adopt(item.orbits, item.z), last.z) for item in firsts]
    gaps = [float(np.linalg.norm(z - last.z)) for z in adopted]
    nearest = int(np.argmin(gaps))
    point = _leaving(
        curve, adopted[nearest], last.tangent, firsts[nearest].monodromy, found.point.residual
    )
    if point is None or not gaps[nearest] < REACH * NEAR:
        return None
    beyond = replace(point, arclength=last.arclength + gaps[nearest])
    name = CODIMENSION_TWO[found.type]
    reason = f"the locus ends at {found.type}, {name}, where its orbits {_shrinking(orbits)}"
    end = End("codimension-2", reason, found.point.curve.place(found.point.z))
    return Stop(last, end, beyond, reached=found.point)
