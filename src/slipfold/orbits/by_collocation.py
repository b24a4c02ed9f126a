"""Orbits by collocation that go on where shooting has come to."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from slipfold.arrays import Array
from slipfold.orbits.cycles import STANDING
from slipfold.orbits.discretisations.collocation import FIRST, ROUNDS, Collocation
from slipfold.orbits.discretisations.scheme import STAGES
from slipfold.orbits.discretisations.segments import Segments
from slipfold.orbits.orbit_curve import OrbitCurve, Orbits
from slipfold.orbits.orbit_point import OrbitPoint

C = TypeVar("C", bound=OrbitCurve)


def by_collocation(curve: C, point: OrbitPoint) -> tuple[C, OrbitPoint] | None:
    """Return a curve by collocation on a mesh that fits, and a point of it; None if lost."""
    orbits = curve.orbits
    if isinstance(orbits.by, Collocation):
        return _fitted(curve, point)
    count = FIRST * orbits.period
    assert isinstance(orbits.by, Segments)
    scheme = orbits.by.scheme(orbits.nodes(point.z), orbits.constants(point.z))
    by = Collocation(orbits.model, orbits.by.free, orbits.period, count, scheme=scheme)
    other = curve.described_by(by)
    size = np.ptp(orbits.nodes(point.z) / orbits.scales, axis=0).max()
    if orbits.free_phase and size < STANDING:
        return (other, _newborn(other, orbits, point)) if isinstance(other, Orbits) else None
    again = other.retaken(point)
    return None if again is None else _fitted(other, again)


def on_mesh(orbits: Orbits, z: Array, stages: int = STAGES) -> tuple[Orbits, Array]:
    """Describe an orbit by collocation on a mesh that fits it; nothing is corrected."""
    assert isinstance(orbits.by, Segments)
    scheme = orbits.by.scheme(orbits.nodes(z), orbits.constants(z), stages)
    count = max(orbits.segments, FIRST * orbits.period)
    by: Collocation | None = Collocation(
        orbits.model, orbits.by.free, orbits.period, count, scheme=scheme
    )
    for _ in range(ROUNDS):
        if by is None:
            break
        other = orbits.described_by(by)
        orbits, z = other, other.adopt(orbits, z)
        by = by.better(orbits.nodes(z), orbits.constants(z))
    return orbits, z


def _fitted(curve: C, point: OrbitPoint) -> tuple[C, OrbitPoint]:
    for _ in range(ROUNDS):
        following = curve.renewed([point])
        if following is None:
            break
        curve, (point,) = following
    return curve, point


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
