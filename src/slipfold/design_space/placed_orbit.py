"""A response that goes where parameters take it, and how much it vibrates."""

from __future__ import annotations

from typing import Self

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.settings import Settings
from slipfold.continuation.newton import Correction
from slipfold.design_space.placed import Placed
from slipfold.errors import InputError
from slipfold.loci.gradients import corrected
from slipfold.models.model import Model
from slipfold.orbits.find import periodic_orbit
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.shooting import SEGMENTS

PHASES = 64
"""Equidistant phases a forcing period over which a motion is averaged: of a smooth periodic one
that is exact but for harmonics above the 32nd."""


class PlacedOrbit(Placed):
    """A forced response at some values of the parameters."""

    @classmethod
    def at(cls, model: Model, names: tuple[str, ...]) -> Self:
        """Return the response of a model, of period 1."""
        orbit = periodic_orbit(model)
        orbits = orbits_of(model, {names[0]: abs(model.values[names[0]]) or 1.0}, 1, SEGMENTS)
        z = orbits.unknown(orbit.nodes[:: len(orbit.nodes) // SEGMENTS], model)
        found = corrected(orbits, z, -1, Settings())
        if not found.converged:
            raise InputError(f"the response of {model!r} is not found again ({found.failure})")
        return cls(names, orbits, found, model)

    def level(self, state: int) -> tuple[float, Array]:
        """Return how much a state vibrates, root mean square about its mean, and derivatives.

        Shapes: returns (), (d,).
        """
        phases = np.arange(PHASES) / PHASES
        slopes, moving = [], np.empty(0)
        for name, rate in zip(self.names, self.rates, strict=True):
            orbits, z = self.beside(name)
            nodes, constants = orbits.nodes(z), orbits.constants(z)
            which, states, matrices, vectors = orbits.by.carried_to(nodes, constants, phases)
            nodes_rate = self.orbits.nodes(rate)[which]
            along = np.einsum("jb,jb->j", matrices[:, state], nodes_rate) + vectors[:, state, 0]
            moving = states[:, state] - states[:, state].mean()
            slopes.append(float(moving @ (along - along.mean())) / PHASES)
        level = float(np.sqrt(np.mean(moving**2)))
        return level, np.array(slopes) / level

    def _curve(self, orbits: Orbits) -> Orbits:
        return orbits

    def _placed(self, orbits: Orbits, found: Correction, model: Model) -> Self:
        return type(self)(self.names, orbits, found, model)
