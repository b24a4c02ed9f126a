"""Special points at which other branches begin, and which branches they join."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.closed_branches import SAME_ORBIT, Birth
from slipfold.branches.homoclinic import snakes_about
from slipfold.branches.settings import Settings
from slipfold.branches.start import method_for
from slipfold.continuation.curve_set import FollowedCurve, Start
from slipfold.continuation.traced_curve import Found
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.critical import Emanating, doubled_orbit, hopf_cycle
from slipfold.orbits.kinds import Equilibria
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits

SAME_VALUE = 1e-7
"""Difference of the parameter, in spans, below which two branch points may be one."""


TAIL = 0.01
"""Distance, in spans, from the value about which a branch snakes, within which emanating branches
are not followed: at every fold the same branches begin, on an ever smaller scale."""


@dataclass(frozen=True, eq=False)
class Junction(Start[OrbitPoint]):
    """A special point of a known branch at which another branch begins."""

    orbits: Orbits | None = None  # equations of the branch on which it lies
    birth: Birth | None = None  # the branch that begins there


def junctions_on(followed: FollowedCurve[OrbitPoint], settings: Settings) -> list[Junction]:
    """Return the points of a branch at which others begin.

    Equilibria are followed before cycles, and shorter periods before longer ones, since a branch
    may end where another one begins. A branch that snakes to a homoclinic orbit has infinitely many
    such points: those near its end are excluded, and so are longer periods.
    """
    junctions, traced = [], followed.traced
    about = snakes_about(traced.found, followed.started, traced.end)
    largest = min(settings.largest_period, settings.snaking_period if about else np.inf)
    for found in traced.found:
        orbits, left = found.point.curve, [abs(found.point.z[-1] - value) for value in about]
        if min(left, default=np.inf) < TAIL:
            continue
        try:
            birth = emanating_branch(orbits, found, settings, largest)
        except BREAKDOWNS:  # no branch can be followed from there; the point itself is reported
            continue
        if birth is None:
            continue
        start, curve = birth.start, birth.orbits
        # At a branch point the other branch continues in both directions.
        both = (start, curve.turned(start)) if found.type == "BP" else (start,)
        rank = (int(curve.kind != "equilibrium"), curve.period)
        junctions.append(
            Junction(curve, both, rank, True, followed.number, found, orbits=orbits, birth=birth)
        )
    if about and traced.end is not None:
        reason = (
            f"{traced.end.reason}; what begins within {TAIL:g} of the span of that value, at one "
            f"turn after the other, is not followed (a narrower span shows it), and no period "
            f"above {largest:g}"
        )
        traced.end = replace(traced.end, reason=reason)
    return junctions


def emanating_branch(
    orbits: Orbits, found: Found, settings: Settings, largest: float
) -> Birth | None:
    """Return the branch that begins at a special point, if its period is not too long."""
    if found.type == "BP" and found.other is not None:
        return Birth(orbits, _other_branch(found, found.other))
    cycles = settings.largest_period > 0
    if isinstance(orbits, Equilibria) and found.type == "HB" and cycles:
        method = partial(method_for, settings)
        return _born(hopf_cycle(orbits, found.point.z, method), found.point)
    if found.type == "PD" and 2 * orbits.period <= largest:
        return _born(doubled_orbit(orbits, found.point.z), found.point)
    return None


def _born(first: Emanating, point: OrbitPoint) -> Birth:
    curve = first.orbits
    start = curve.derived_point(first.z, first.tangent, 0.0, first.monodromy, point.residual)
    return Birth(curve, start)


def _other_branch(found: Found, tangent: NDArray[np.float64]) -> OrbitPoint:
    tests = {**found.point.tests, "LP": float(tangent[-1])}
    return replace(found.point, tangent=tangent, arclength=0.0, tests=tests)


def find_meeting(junction: Junction, known: Sequence[Junction]) -> Junction | None:
    """Return the same branch point as it was found on a known branch, if it was."""
    return next((other for other in known if _are_one(junction, other)), None)


def _are_one(junction: Junction, other: Junction) -> bool:
    """Whether two branch points are the same orbit, whatever its phase."""
    if junction.found is None or other.found is None:
        return False
    if (junction.found.type, other.found.type) != ("BP", "BP"):
        return False
    orbits, their = junction.orbits, other.orbits
    if orbits is None or their is None or not Birth(orbits, junction.found.point).fits(their):
        return False
    z, other_z = junction.found.point.z, other.found.point.z
    if abs(orbits.value(z) - their.value(other_z)) >= SAME_VALUE * orbits.width:
        return False
    return orbits.distance(orbits.adopt(their, other_z), z) < SAME_ORBIT
