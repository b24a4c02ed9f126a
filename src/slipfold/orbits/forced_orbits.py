"""Periodic orbits of a forced model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slipfold.arrays import Array
from slipfold.models.model import Model
from slipfold.orbits.discretisations.segments import Cut, Segments
from slipfold.orbits.discretisations.shooting import SEGMENTS, Shooting
from slipfold.orbits.linearisation import NO_CONDITIONS, Linearisation, defect_of
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.spectrum.degeneracy import Degeneracy
from slipfold.orbits.spectrum.multipliers import Multipliers


class ForcedOrbits(Orbits):
    """Orbits whose duration is known, as the forcing's period is.

    `by` makes the discretisation of model, free parameters, period and number of segments.
    """

    by: Segments

    def __init__(
        self,
        model: Model,
        vary: Mapping[str, float],
        period: int = 1,
        segments: int = SEGMENTS,
        by: Cut = Shooting,
    ) -> None:
        super().__init__(model, vary, by(model, vary, period, segments), Multipliers())

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero, shape (m n,)."""
        residual = self.by.mismatch(self.nodes(z), self.constants(z))
        return defect_of(residual, NO_CONDITIONS.values)

    def linearise(self, z: Array) -> Linearisation:
        """Return the mismatch and its derivatives."""
        nodes, constants = self.nodes(z), self.constants(z)
        transitions = self.by.transitions(nodes, constants)
        settled = self.by.settled(transitions[1], nodes, constants)
        return Linearisation(*transitions, settled=settled)

    def slope(self, found: Degeneracy, part: Linearisation, z: Array) -> tuple[Array, Array, Array]:
        """Return the gradient of a function of the monodromy matrix."""
        forward, backward = found.carried(part.blocks)
        return self.by.changed(forward, backward, self.nodes(z), self.constants(z))

    def in_phase(self, z: Array, like: Array) -> Array:
        """Return the same orbit begun in that forcing period in which it lies nearest another."""
        nodes, constants = self.nodes(z), self.constants(z)
        begun = [z]
        for turn in range(1, self.period):
            moved = self.by.states(nodes, constants, self.by.start + turn)
            begun.append(np.concatenate([self.flat(moved), z[self.size :]]))
        begun = [self.beside(copy, like) for copy in begun]
        return min(begun, key=lambda copy: float(np.linalg.norm(copy - like)))
