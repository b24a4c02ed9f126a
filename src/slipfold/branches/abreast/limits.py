"""Where branches that were followed side by side end at a limit of the model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.abreast.located import EXACT, Approached, approach, settled_zeros
from slipfold.branches.abreast.walk import Bracket, Walk
from slipfold.branches.stops import LIMIT_CLOSE
from slipfold.orbits.orbit_batch import Corrected, OrbitBatch, Settled

LAST = 3
"""Orbits at the end of a branch that are settled anew: before, those beside a singularity are known
to a few digits less, and on which side of the limit they are may not be."""

BEYOND = 1.5, 1.1
"""Times the distance to the limit, as it seems, by which it is passed; the second where there is
no orbit so near to a singularity."""

FARTHEST = 5.0
"""Times the distance of the last two orbits by which that may be: a walk that sees the limit in its
own steps, which are coarser, ends up to three before it."""


@dataclass(frozen=True, eq=False)
class AtLimit:
    """The last orbit of a branch, at a limit of the model."""

    orbit: Settled  # this one alone
    arclength: float
    limit: int  # which, by number
    margin: float  # by how much it is kept, up to rounding


def orbits_at_limits(orbits: OrbitBatch, walk: Walk, tolerance: float) -> dict[int, AtLimit | None]:
    """Return where branches end that ended at a limit, by their numbers; None where that fails."""
    found: dict[int, AtLimit | None] = {
        number: None for number, fate in enumerate(walk.fates) if fate == "limit"
    }
    numbers = [number for number in found if len(walk.points[number]) >= LAST]
    if not numbers:
        return found
    points = [point for number in numbers for point in walk.points[number][-LAST:]]
    z, tangents, places = (np.array(item) for item in zip(*points, strict=True))
    cases = np.repeat(walk.cases[numbers], LAST)
    settled = orbits.settled(cases, z, tangents, tolerance)
    known = orbits.margins(cases, settled.z)
    brackets = list[Bracket]()
    for row, number in enumerate(numbers):
        some = slice(row * LAST, (row + 1) * LAST)
        parts = settled.z[some], tangents[some], places[some], known[some]
        bracket = _bracket(orbits, number, int(walk.cases[number]), *parts)
        brackets += [] if bracket is None else [bracket]

    def margins(which: Sequence[Bracket], now: Corrected) -> Array:
        return _margins(orbits, which, now.z)

    items = approach(orbits, brackets, margins, LIMIT_CLOSE)
    near = [item for item in items if item is not None]

    def left(which: Sequence[Approached], now: Settled) -> Array:
        return _margins(orbits, [item.bracket for item in which], now.z)

    zeros = settled_zeros(orbits, near, left, LIMIT_CLOSE, tolerance)
    for item, zero in zip(near, zeros, strict=True):
        if zero is not None:
            at = AtLimit(zero[0], item.arclength, _limit(orbits, item.bracket), zero[1])
            found[item.bracket.branch] = at
    return found


def _bracket(
    orbits: OrbitBatch,
    branch: int,
    case: int,
    z: Array,
    tangents: Array,
    places: Array,
    margins: Array,
) -> Bracket | None:
    """Return two orbits between which one limit is broken; None if there is no such limit.

    Shapes: z, tangents (LAST, u); places (LAST,); margins (LAST, n_limits).
    """
    if not (margins[-2] > 0).all():
        z, tangents, places, margins = z[:-1], tangents[:-1], places[:-1], margins[:-1]
    elif (margins[-1] > 0).all():
        length = places[-1] - places[-2]
        left = margins[-1] / np.maximum(margins[-2] - margins[-1], 1e-300) * length
        if not BEYOND[0] * float(left.min()) < FARTHEST * length:
            return None
        some, row = np.array([case]), tangents[-1:]
        for share in BEYOND:
            further = share * float(left.min())
            now = orbits.correct(some, z[-1:] + further * row, row, EXACT, further)
            if now.found[0]:
                break
        z, tangents = np.concatenate([z, now.z]), np.concatenate([tangents, now.tangents])
        places = np.append(places, places[-1] + further)
        margins = np.concatenate([margins, orbits.margins(some, now.z)])
    broken = np.flatnonzero(~(margins[-1] > 0))
    if not (margins[-2] > 0).all() or len(broken) != 1 or not np.isfinite(tangents[-2:]).all():
        return None
    index = int(broken[0])
    name = orbits.model.limits[index].name
    values = margins[-2:, index]
    return Bracket(branch, case, name, z[-2:], tangents[-2:], places[-2:], values, (0, 0))


def _limit(orbits: OrbitBatch, bracket: Bracket) -> int:
    return [limit.name for limit in orbits.model.limits].index(bracket.kind)


def _margins(orbits: OrbitBatch, brackets: Sequence[Bracket], z: Array) -> Array:
    """Return by how much orbits keep the limits that lie in brackets, shape (k,)."""
    cases = np.array([item.case for item in brackets])
    which = [_limit(orbits, item) for item in brackets]
    return np.asarray(orbits.margins(cases, z)[np.arange(len(which)), which])
