"""Equilibria by the vector field itself: nothing is integrated."""

from __future__ import annotations

from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.orbits.discretisations.discretisation import Discretisation

OTHER = 1.3
"""Neighbouring states differ by this much more in scale where a result is computed anew: no power
of two, so that all rounding differs."""


class VectorField(Discretisation):
    """The rates of one state, per unit of time in scaled states, and their derivatives."""

    def with_period(self, period: int) -> VectorField:
        """Return the same: equilibria repeat after any time."""
        return self

    def shifted(
        self, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[VectorField, Array, Array]:
        """Return the same in other scales of the states, so that all rounding differs."""
        other = VectorField(self.model, self.free)
        other.measure_in(self.scales * OTHER ** np.arange(len(self.scales)))
        return other, nodes, along

    def rates(self, nodes: Array, constants: Constants) -> Array:
        """Return the rates, shape (1, n). Shapes: nodes (1, n)."""
        return self.flow.rates(nodes, np.zeros(1), constants) / self.scales

    def jacobian(self, nodes: Array, constants: Constants) -> Array:
        """Return their derivatives with respect to the scaled states, shape (n, n).

        Shapes: nodes (1, n).
        """
        return self.flow.jacobians(nodes, np.zeros(1), constants)[0] * self.ratios

    def pulls(self, nodes: Array, constants: Constants) -> Array:
        """Return their derivatives with respect to the k scaled parameters, shape (n, k).

        Shapes: nodes (1, n).
        """
        along = constants.rates[:, self.indices]
        return self.flow.pulls(nodes, np.zeros(1), constants, along)[0] * self.pull_units

    def curvatures(self, nodes: Array, constants: Constants, vectors: Array) -> tuple[Any, Any]:
        """Return the derivatives of ``jacobian @ vectors``, shapes (r, n, n) and (r, n, k).

        Shapes: nodes (1, n); vectors (r, n).
        """
        states, phases = np.tile(nodes, (len(vectors), 1)), np.zeros(len(vectors))
        along = constants.rates[:, self.indices]
        second, mixed = self.flow.curvatures(
            states, phases, constants, vectors * self.scales, along
        )
        return second * self.ratios, mixed * self.pull_units
