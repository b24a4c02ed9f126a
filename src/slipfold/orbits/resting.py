"""Equilibria by the vector field itself: nothing is integrated."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.flow import Constants
from slipfold.orbits.shooting import Shooting

__all__ = ["Resting"]

Array = NDArray[np.float64]

OTHER = 1.3
"""Neighbouring states differ by this much more in scale where a result is computed anew: no power
of two, so that all rounding differs."""


class Resting(Shooting):
    """What all problems of equilibria share: one state, its rates and their derivatives.

    An offset, which begins an orbit elsewhere, stands for other scales of the states here.
    """

    def take_other_scales(self) -> None:
        """Measure the states in other scales from now on, so that all rounding differs."""
        self.scales = self.scales * OTHER ** np.arange(len(self.scales))
        self._node_scales = self.scales
        self._ratios = self.scales[None, :] / self.scales[:, None]

    def shifted(self, z: Array, tangent: Array) -> tuple[Self, Array, Array]:
        """Return the same equilibrium in other scales of the states, where rounding differs."""
        other = self.begun_later()
        moved = other.join(self.nodes(z), self.free_values(z))
        direction = other.join(self.nodes(tangent), self.free_values(tangent))
        return other, moved, direction / np.linalg.norm(direction)

    def rates(self, z: Array, constants: Constants) -> Array:
        """Return the rates per unit of time in scaled states, shape (1, n)."""
        return self.flow.rates(self.nodes(z), np.zeros(1), constants) / self.scales

    def jacobian(self, z: Array, constants: Constants) -> Array:
        """Return their derivatives with respect to the scaled states, shape (n, n)."""
        return self.flow.jacobians(self.nodes(z), np.zeros(1), constants)[0] * self._ratios

    def pulls(self, z: Array, constants: Constants) -> Array:
        """Return their derivatives with respect to the k scaled parameters, shape (n, k)."""
        along = constants.rates[:, self.indices]
        found = self.flow.pulls(self.nodes(z)[0], constants, along)
        return found * (self.units / self.scales[:, None])
