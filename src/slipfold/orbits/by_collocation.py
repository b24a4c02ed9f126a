"""Orbits by collocation that go on where shooting has come to."""

from __future__ import annotations

from slipfold.orbits.discretisations.collocation import Collocation
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["FIRST", "by_collocation"]

FIRST = 64
"""Intervals of the mesh on which an orbit is taken up by collocation."""

ROUNDS = 4
"""Meshes that are tried until one fits."""


def by_collocation(orbits: Orbits, point: OrbitPoint) -> tuple[Orbits, OrbitPoint] | None:
    """Return orbits by collocation instead of shooting, and a point of theirs; None if lost."""
    count = FIRST * orbits.period
    by = Collocation(orbits.model, orbits.by.free, orbits.period, count)
    other = orbits.described_by(by)
    again = other.retaken(point, orbits)
    for _ in range(ROUNDS):
        if again is None:
            return None
        following = other.renewed([again])
        if following is None:
            break
        other, (again,) = following
    return None if again is None else (other, again)
