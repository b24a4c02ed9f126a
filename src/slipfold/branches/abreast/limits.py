"""Where branches that were followed side by side end at a limit of the model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.abreast.located import Approached, approach
from slipfold.branches.abreast.orbits_of_cases import Corrected, OrbitsOfCases
from slipfold.branches.abreast.walk import Bracket, Walk
from slipfold.branches.stops import LIMIT_CLOSE
from slipfold.orbits.forced_orbits import ForcedOrbits
from slipfold.orbits.limits import limit_margins

__all__ = ["approached_limits"]

Array = NDArray[np.float64]

LAST = 3
"""Orbits at the end of a branch that are settled anew: before, those beside a singularity are known
to a few digits less, and on which side of the limit they are may not be."""

BEYOND = 1.5
"""Times the distance to the limit, as it seems, by which it is passed."""


def approached_limits(
    orbits: OrbitsOfCases, walk: Walk, tolerance: float
) -> dict[int, Approached | None]:
    """Return where branches end that ended at a limit, by their numbers; None where that fails."""
    found: dict[int, Approached | None] = {
        number: None for number, fate in enumerate(walk.fates) if fate == "limit"
    }
    numbers = [number for number in found if len(walk.points[number]) >= LAST]
    if not numbers:
        return found
    points = [point for number in numbers for point in walk.points[number][-LAST:]]
    z, tangents, places = (np.array(item) for item in zip(*points, strict=True))
    cases = np.repeat(walk.cases[numbers], LAST)
    settled = orbits.settled(cases, z, tangents, tolerance)
    brackets = list[Bracket]()
    for row, number in enumerate(numbers):
        some = slice(row * LAST, (row + 1) * LAST)
        bracket = _bracket(
            orbits, number, int(walk.cases[number]), settled.z[some], tangents[some], places[some]
        )
        brackets += [] if bracket is None else [bracket]

    def margins(which: Sequence[Bracket], now: Corrected) -> Array:
        pairs = zip(which, now.z, strict=True)
        return np.array([_margins(orbits, item.case, z)[_limit(orbits, item)] for item, z in pairs])

    items = approach(orbits, brackets, margins, LIMIT_CLOSE)
    return found | {bracket.branch: item for bracket, item in zip(brackets, items, strict=True)}


def _bracket(
    orbits: OrbitsOfCases, branch: int, case: int, z: Array, tangents: Array, places: Array
) -> Bracket | None:
    """Return two orbits between which one limit is broken; None if there is no such limit.

    Shapes: z, tangents (LAST, u); places (LAST,).
    """
    known = [_margins(orbits, case, item) for item in z[-2:]]
    if not (known[0] > 0).all():
        z, tangents, places = z[:-1], tangents[:-1], places[:-1]
        known = [_margins(orbits, case, z[-2]), known[0]]
    elif (known[1] > 0).all():
        length = places[-1] - places[-2]
        left = known[1] / np.maximum(known[0] - known[1], 1e-300) * length
        further = BEYOND * float(left.min())
        if not further < length:
            return None
        beyond = z[-1] + further * tangents[-1]
        row = tangents[-1:]
        now = orbits.correct(np.array([case]), beyond[None], row, 1e-6, length)
        z = np.array([z[-1], now.z[0]])
        tangents = np.array([tangents[-1], now.tangents[0]])
        places = np.array([places[-1], places[-1] + further])
        known = [known[1], _margins(orbits, case, now.z[0])]
    broken = np.flatnonzero(~(known[1] > 0))
    if not (known[0] > 0).all() or len(broken) != 1 or not np.isfinite(tangents).all():
        return None
    index = int(broken[0])
    values = np.array([known[0][index], known[1][index]])
    name = orbits.models[case].limits[index].name
    return Bracket(branch, case, name, z[-2:], tangents[-2:], places[-2:], values, (0, 0))


def _limit(orbits: OrbitsOfCases, bracket: Bracket) -> int:
    return [limit.name for limit in orbits.models[bracket.case].limits].index(bracket.kind)


def _margins(orbits: OrbitsOfCases, case: int, z: Array) -> Array:
    """Return by how much an orbit keeps each limit."""
    if not np.isfinite(z).all():
        return np.full(len(orbits.models[case].limits), np.nan)
    alone = ForcedOrbits(orbits.models[case], {orbits.vary: orbits.width}, orbits.period)
    return limit_margins(alone, z)
