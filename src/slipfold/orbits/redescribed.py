"""Points of a curve of orbits in terms of another discretisation, or of another mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slipfold.continuation.interpolation import POINTS, arc_between
from slipfold.continuation.newton import correct
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.collocation import Collocation
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.orbit_point import OrbitPoint
from slipfold.orbits.segments import Segments

__all__ = ["by_collocation", "renewed", "retaken"]

FIRST = 64
"""Intervals of the mesh on which an orbit is taken up by collocation."""

ROUNDS = 4
"""Meshes that are tried until one fits."""


def retaken(orbits: Orbits, point: OrbitPoint, known: Orbits) -> OrbitPoint | None:
    """Return a point of other orbits in terms of these, None if it is lost."""
    before, after = known.by, orbits.by
    assert isinstance(before, Segments)
    assert isinstance(after, Segments)
    nodes, along = before.moved_to(
        after,
        known.nodes(point.z),
        known.constants(point.z),
        known.nodes(point.tangent),
        known.free_values(point.tangent),
    )
    z = orbits.join(nodes, known.free_values(point.z))
    row = orbits.join(along, known.free_values(point.tangent))
    try:
        correction = correct(orbits, z, row / np.linalg.norm(row))
    except BREAKDOWNS:
        return None
    return orbits.point(correction, point.arclength) if correction.converged else None


def renewed(orbits: Orbits, points: Sequence[OrbitPoint]) -> tuple[Orbits, list[OrbitPoint]] | None:
    """Return the last points on a mesh that fits the last one, None if its own does."""
    last = points[-1].z
    if not isinstance(orbits.by, Collocation):
        return None
    by = orbits.by.better(orbits.nodes(last), orbits.constants(last))
    if by is None:
        return None
    other, moved = orbits.described_by(by), list[OrbitPoint]()
    for point in [item for item in points[-POINTS:] if item.curve is orbits][::-1]:
        again = retaken(other, point, orbits)
        if again is None:
            break
        if moved:
            again = replace(again, arclength=moved[0].arclength - arc_between(again, moved[0]))
        moved.insert(0, again)
    return (other, moved) if moved else None


def by_collocation(orbits: Orbits, point: OrbitPoint) -> tuple[Orbits, OrbitPoint] | None:
    """Return orbits by collocation instead of shooting, and a point of theirs; None if lost."""
    count = FIRST * orbits.period
    by = Collocation(orbits.model, orbits.by.free, orbits.period, count)
    other = orbits.described_by(by)
    again = retaken(other, point, orbits)
    for _ in range(ROUNDS):
        if again is None:
            return None
        following = renewed(other, [again])
        if following is None:
            break
        other, (again,) = following
    return None if again is None else (other, again)
