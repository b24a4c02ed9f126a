"""Laws in which the contact remembers its past in a deflection."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from slipfold.models.friction.law import FrictionLaw
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import State

__all__ = ["MemoryLaw"]


@dataclass(frozen=True)
class MemoryLaw(FrictionLaw):
    """A law with a deflection z as memory, a vector in the plane; it never sticks.

    A subclass gives `rates_of_memory` besides what a law without memory gives.
    """

    sticks: ClassVar[bool] = False
    unit: ClassVar[str] = "m"
    """Unit of the deflection."""

    @abstractmethod
    def rates_of_memory(
        self, slip: tuple[Expression, ...], memory: tuple[Expression, ...], p: Symbols
    ) -> tuple[Expression, ...]:
        """Time derivatives of the deflection, per second.

        Parameters
        ----------
        slip
            Velocity of the counter-body relative to the body in m/s, one or two components.
        memory
            The deflection, as many components.
        p
            The parameters by name.
        """

    def memory(self, dimensions: int) -> tuple[State, ...]:
        """Return the states ``z``, or ``zx`` and ``zy``.

        Parameters
        ----------
        dimensions
            1 for slip along a line, 2 for slip in a plane.
        """
        if dimensions == 1:
            return (State("z", self.unit, "deflection of the contact", "$z$"),)
        return tuple(
            State(f"z{axis}", self.unit, f"deflection of the contact along {axis}", f"$z_{axis}$")
            for axis in "xy"
        )

    def memory_rates(
        self, slip: Sequence[Expression], memory: Sequence[Expression], p: Symbols | None = None
    ) -> tuple[Expression, ...]:
        """Time derivatives of the deflection, per second.

        Parameters
        ----------
        slip
            Velocity of the counter-body relative to the body in m/s, one or two components.
        memory
            The deflection, as many components.
        p
            The parameters by name; the law's own values if None.
        """
        return self.rates_of_memory(tuple(slip), tuple(memory), self.values if p is None else p)
