"""Orbits by collocation that go on where shooting has come to."""

from __future__ import annotations

import numpy as np

from slipfold.orbits.cycles import STANDING
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
    size = np.ptp(orbits.nodes(point.z) / orbits.scales, axis=0).max()
    if orbits.free_phase and size < STANDING:
        return other, _newborn(other, orbits, point)
    again = other.retaken(point, orbits)
    for _ in range(ROUNDS):
        if again is None:
            return None
        following = other.renewed([again])
        if following is None:
            break
        other, (again,) = following
    return None if again is None else (other, again)


def _newborn(other: Orbits, orbits: Orbits, point: OrbitPoint) -> OrbitPoint:
    """Return a cycle of no amplitude, the direction of which turns once, at other phases."""
    turns = np.exp(2j * np.pi * np.arange(orbits.segments) / orbits.segments)
    critical = turns.conj() @ orbits.nodes(point.tangent) * (2 / orbits.segments)
    later = np.exp(2j * np.pi * np.arange(other.segments) / other.segments)
    nodes = np.tile(orbits.nodes(point.z)[:1], (other.segments, 1))
    z = other.join(nodes, orbits.free_values(point.z))
    tangent = other.join(np.real(later[:, None] * critical), orbits.free_values(point.tangent))
    tangent /= np.linalg.norm(tangent)
    return other.known_point(z, tangent, point.arclength, point.monodromy, point.residual)
