"""Shooting through stick and slip past a change of contacts that is only just met."""

from __future__ import annotations

from abc import abstractmethod

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.orbits.discretisations.switched_shooting import SwitchedShooting


class MetShooting(SwitchedShooting):
    """Orbits that pass a place where something is only just met, alike on either side of it.

    So they depend smoothly on everything there, and so does what is zero where it is met.
    """

    level = 0.0
    """What is left of it, over its size, where it cannot vanish."""

    @abstractmethod
    def touched(self, nodes: Array, constants: Constants) -> tuple[float, Array, Array]:
        """Return what is zero where it is met, over its size, with its derivatives.

        By scaled states and scaled free parameters. Shapes: nodes (1, n); returns (), (n,), (k,).
        """
