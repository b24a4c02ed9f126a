"""Cycles of an autonomous model at a bifurcation in two free parameters."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.orbits.critical_problem import CriticalProblem
from slipfold.orbits.cycle_problem import (
    CycleLinearisation,
    aligned_cycle,
    gauge_conditions,
    quotient_basis,
)
from slipfold.orbits.degeneracy import Degeneracy
from slipfold.orbits.linearisation import Linearisation
from slipfold.orbits.phase_alignment import begun_nearest

__all__ = ["CriticalCycle"]

Array = NDArray[np.float64]


class CriticalCycle(CriticalProblem):
    r"""Cycles with a critical multiplier besides that of the flow, in two free parameters.

    An unknown ``z`` holds the scaled states at m phases, the scaled duration of one round and both
    scaled parameters. As for the cycles of a branch, steps are kept orthogonal to the flow, and
    the condition of the bifurcation is one of the monodromy matrix on the quotient by the flow's
    direction (see `slipfold.orbits.cycle_problem`).
    """

    @staticmethod
    def _free(
        model: Model, vary: tuple[str, str], widths: tuple[float, float]
    ) -> tuple[list[str], list[float]]:
        """The duration of one round, then the parameters."""
        return ["duration", *vary], [model.values["duration"], *widths]

    def duration(self, z: Array) -> float:
        """Return the duration of one round in seconds."""
        return float(self.free_values(z)[0])

    def plain(self, z: Array) -> Linearisation:
        """Return the mismatch and its derivatives, without the condition of the bifurcation."""
        transitions = self.transitions(self.nodes(z), self.constants(z))
        return CycleLinearisation(*transitions, gauge_conditions(self, z))

    def aligned(self, guess: Array, known: Array) -> Array:
        """Return a guess whose phase is that of a cycle nearby."""
        return aligned_cycle(self, guess, known)

    def begun_near(self, z: Array, reference: Array) -> Array:
        """Return a cycle begun where it passes nearest to another."""
        return begun_nearest(self, z, reference)

    def _gradient(self, found: Degeneracy, plain: Linearisation, z: Array) -> tuple[Any, Any, Any]:
        r"""Differentiate the degeneracy of the quotient's matrix :math:`B^T M B`.

        The basis B of what is orthogonal to the flow's direction f turns with it: where
        :math:`M f = f`, the derivative of :math:`p^T B^T M B q` is
        :math:`(B p)^T dM (B q) - (B p)^T df \; (f^T M B q)`.
        """
        gradients = plain.conditions.gradients
        assert gradients is not None
        n, nodes, constants = len(self.scales), self.nodes(z), self.constants(z)
        direction = gradients[0, :n] / np.linalg.norm(gradients[0, :n])
        basis = quotient_basis(direction)
        lifted = Degeneracy(found.value, found.left @ basis.T, found.right @ basis.T)
        gradient, carried, bent = super()._gradient(lifted, plain, z)
        weights = (direction @ plain.product @ lifted.right.T) @ lifted.left
        rate = self.flow.rates(nodes[:1], self._start[:1], constants)[0] / self.scales
        slope = self.flow.jacobians(nodes[:1], self._start[:1], constants)[0] * self._ratios
        pulls = self.flow.pulls(nodes[0], constants, constants.rates[:, self.indices])
        turned = weights / np.linalg.norm(rate)
        gradient[:n] -= turned @ slope * np.sqrt(self.segments)
        gradient[self.size :] -= turned @ (pulls * (self.units / self.scales[:, None]))
        return gradient, carried, bent
