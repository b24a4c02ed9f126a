"""Cycles of an autonomous model: their duration is unknown."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.models.model import Model
from slipfold.orbits.discretisations.segments import Cut, Segments
from slipfold.orbits.discretisations.shooting import SEGMENTS, Shooting
from slipfold.orbits.linearisation import MANY, Conditions, Linearisation, defect_of
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.spectrum.degeneracy import Degeneracy
from slipfold.orbits.spectrum.multipliers import CycleMultipliers

Values = NDArray[np.complex128]

PLANE = 2
"""States of a model whose cycles have one multiplier of their own."""

ALIGNMENTS = 3
"""Corrections of a phase, each of which leaves the square of what was left before."""

STANDING = 1e-9
"""A cycle whose nodes differ by less, in scaled states, is an equilibrium: it has no phase."""


class Cycles(Orbits):
    """Orbits with the duration of one round as a free parameter, and with no phase of their own.

    A cycle may be begun anywhere on it: Newton's steps and tangents are kept orthogonal to the
    flow, which fixes the phase without a condition to be met.

    The model's ``duration`` sets the scale of the duration; `period` is the number of rounds.
    """

    by: Segments
    spectrum: CycleMultipliers
    free_phase = True

    def __init__(
        self,
        model: Model,
        vary: Mapping[str, float],
        period: int = 1,
        segments: int = SEGMENTS,
        by: Cut = Shooting,
    ) -> None:
        free = {"duration": model.values["duration"], **vary}
        super().__init__(model, vary, by(model, free, period, segments), CycleMultipliers())

    def duration(self, z: Array) -> float:
        """Return the duration of one round in seconds."""
        return float(self.free_values(z)[0])

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero, shape (m n + 1,): nothing for the phase."""
        residual = self.by.mismatch(self.nodes(z), self.constants(z))
        return defect_of(residual, np.zeros(1))

    def linearise(self, z: Array) -> Linearisation:
        """Return the mismatch and its derivatives; that steps are orthogonal to the flow is met."""
        nodes, constants = self.nodes(z), self.constants(z)
        transitions = self.by.transitions(nodes, constants)
        settled = self.by.settled(transitions[1], nodes, constants)
        gauge = Conditions(np.zeros(1), self.flow_direction(z)[None])
        return Linearisation(*transitions, gauge, self.spectrum.matrix, settled)

    def eigenvalues(self, z: Array, linearisation: Linearisation) -> Values:
        """Return the multipliers besides that of the flow's direction, largest modulus first.

        In a plane it is one, and by Liouville's formula it is the exponential of the divergence
        integrated over a round: known also where a segment lasts many times the fastest decay.
        """
        logarithm = self.log_multiplier(z)
        if logarithm is None:
            return super().eigenvalues(z, linearisation)
        with np.errstate(over="ignore"):
            return np.array([np.exp(logarithm)], dtype=complex)

    def log_multiplier(self, z: Array) -> float | None:
        """Return the logarithm of the only multiplier besides that of the flow, if it is known."""
        if len(self.scales) != PLANE:
            return None
        return self.by.divergence(self.nodes(z), self.constants(z))

    def log_multiplier_slope(self, z: Array) -> Array:
        """Return its gradient, shape (m n + k,)."""
        by_nodes, by_free = self.by.divergence_slope(self.nodes(z), self.constants(z))
        return np.concatenate([by_nodes.ravel() * np.sqrt(self.segments), by_free])

    def flow_direction(self, z: Array) -> Array:
        """Return the unit vector along which beginning later shifts a cycle; zero at rest."""
        rates = self.by.rates(self.nodes(z), self.constants(z))
        size = float(np.linalg.norm(rates)) or 1.0
        return np.concatenate([rates.ravel() / size, np.zeros(len(self.units))])

    def slope(self, found: Degeneracy, part: Linearisation, z: Array) -> tuple[Array, Array, Array]:
        """Return the gradient of a function of the matrix on the quotient, whose basis turns."""
        nodes, constants = self.nodes(z), self.constants(z)
        if len(nodes) > MANY:
            forward, backward, weights = self.spectrum.carried(found, part)
        else:
            lifted, weights = self.spectrum.lifted(found, part)
            forward, backward = lifted.carried(part.blocks)
        gradient, carried, bent = self.by.changed(forward, backward, nodes, constants)
        rates, slopes, pulls = self.by.changing_rates(nodes[: len(weights)], constants)
        turned = weights / np.linalg.norm(rates, axis=1)[:, None]
        by_nodes = np.einsum("ja,jab->jb", turned, slopes).ravel() * np.sqrt(self.segments)
        gradient[: len(by_nodes)] -= by_nodes
        gradient[self.size :] -= np.einsum("ja,jak->k", turned, pulls)
        return gradient, carried, bent

    def aligned(self, guess: Array, known: Array) -> Array:
        """Return a guess whose phase is that of a cycle nearby.

        Corrections leave the phase as it is in the guess, and extrapolation would magnify small
        differences from one cycle to the next. Between aligned cycles lies no motion along the
        flow, to the third order of their distance.
        """
        for _ in range(ALIGNMENTS):
            direction = self.flow_direction(0.5 * (guess + known))
            guess = guess - (direction @ (guess - known)) * direction
        return guess

    def stands(self, z: Array) -> bool:
        """Whether a cycle has no amplitude: it is an equilibrium."""
        return bool(np.ptp(self.nodes(z) / self.scales, axis=0).max() < STANDING)

    def begun_near(self, z: Array, reference: Array) -> Array:
        """Return the same cycle begun where it lies nearest to another."""
        if self.stands(z):
            return z
        nodes = self.by.begun_near(self.nodes(z), self.constants(z), self.nodes(reference))
        return self.join(nodes, self.free_values(z))
