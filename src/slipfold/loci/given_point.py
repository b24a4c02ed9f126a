"""A special point of a branch as an unknown of its locus."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.orbits.check import rests
from slipfold.orbits.continued import on_mesh
from slipfold.orbits.eigenvalues import Cayley
from slipfold.orbits.grazing import GRAZED, GrazingShooting
from slipfold.orbits.kinds import Equilibria, orbits_of
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.reversal import ReversalShooting
from slipfold.orbits.shooting import SEGMENTS
from slipfold.orbits.switched_shooting import SwitchedShooting

GIVING_WAY = (0.0, 1e-4, -1e-4, 3e-4, -3e-4, 1e-3, -1e-3)
"""Shares by which a parameter is changed to leave slip in the plane."""


def as_unknown(
    point: SpecialPoint, model: Model, plane: Mapping[str, float], settings: Settings
) -> tuple[Orbits, Array]:
    """Return what the locus of a special point consists of, and the point as one of them.

    It is of the discretisation that the branch had come to, unless settings ask for one: shooting
    gives an orbit at eight phases, collocation at more.
    """
    if not np.isnan(point.stuck_fraction):
        return _through_stick(point, model, plane)
    if rests(point.model, point.nodes):
        resting = Equilibria(model, plane, Cayley())
        return resting, resting.unknown(point.nodes[:1], point.model)
    chosen = settings.discretisation
    if chosen == "shooting" or (chosen == "automatic" and len(point.nodes) <= SEGMENTS):
        orbits = orbits_of(model, plane, point.period, SEGMENTS)
        every, rest = divmod(len(point.nodes), SEGMENTS)
        if rest:
            raise InputError(
                f"the special point is given at {len(point.nodes)} phases, not {SEGMENTS}; "
                "compute it anew"
            )
        return orbits, orbits.unknown(point.nodes[::every], point.model)
    return on_a_mesh(orbits_of(model, plane, point.period, SEGMENTS), point)


def _through_stick(
    point: SpecialPoint, model: Model, plane: Mapping[str, float]
) -> tuple[Orbits, Array]:
    """Return a special point as an orbit through stick and slip, past its touch if it has one."""
    orbits = orbits_of(model, plane, point.period, 1, by=SwitchedShooting)
    z = orbits.unknown(point.nodes[:1], point.model)
    assert isinstance(orbits.by, SwitchedShooting)
    by: SwitchedShooting | None
    if point.type in GRAZED:
        by, z = _touching(orbits, orbits.by, z, point.type)
    elif point.type == "STICK":
        by = ReversalShooting.at(orbits.by, orbits.nodes(z), orbits.constants(z))
        if by is None:
            raise InputError("the orbit at this STICK turns nowhere; compute it anew")
    else:
        by = orbits.by.better(orbits.nodes(z), orbits.constants(z))
    if by is None:
        return orbits, z
    other = orbits.described_by(by)
    return other, other.adopt(orbits, z)


def _touching(
    orbits: Orbits, known: SwitchedShooting, z: Array, kind: str
) -> tuple[GrazingShooting, Array]:
    """Return what passes the touch of an orbit, and the orbit, or one with a little slip left.

    In the plane nothing can be integrated where slip vanishes, so the first parameter gives way.
    """
    for share in GIVING_WAY:
        near = z.copy()
        near[-2] *= 1 + share
        by = GrazingShooting.at(known, orbits.nodes(near), orbits.constants(near), kind)
        if by is not None:
            return by, near
    raise InputError(f"the orbit at this {kind} touches nothing; compute it anew")


def on_a_mesh(shot: Orbits, point: SpecialPoint) -> tuple[Orbits, Array]:
    """Return a special point as an orbit by collocation, on a mesh that fits it."""
    orbits = orbits_of(shot.model, shot.varied, point.period, len(point.nodes))
    return on_mesh(orbits, orbits.unknown(point.nodes, point.model))
