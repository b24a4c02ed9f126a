"""Laws in which the contact remembers its past in a deflection."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from slipfold.models.friction.contact_state import ContactState
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import State


@dataclass(frozen=True)
class MemoryLaw(FrictionLaw):
    """A law with a deflection z as memory, a vector in the plane; it never sticks.

    A subclass gives `rates_of_memory`, `traction` and `steady_deflection` besides what a law
    without memory gives.
    """

    sticks: ClassVar[bool] = False
    unit: ClassVar[str] = "m"
    """Unit of the deflection."""
    meaning: ClassVar[str] = "deflection of the contact"

    @abstractmethod
    def rates_of_memory(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """Time derivatives of the deflection, per second."""

    @abstractmethod
    def traction(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """Friction force over normal force."""

    @abstractmethod
    def steady_deflection(self, speed: float) -> float:
        """Return the deflection after a long slip at a constant speed.

        Parameters
        ----------
        speed
            Slip speed in m/s.
        """

    def memory(self, dimensions: int) -> tuple[State, ...]:
        """Return the states ``z``, or ``zx`` and ``zy``."""
        if dimensions == 1:
            return (State("z", self.unit, self.meaning, "$z$"),)
        return tuple(
            State(f"z{axis}", self.unit, f"{self.meaning} along {axis}", f"$z_{axis}$")
            for axis in "xy"
        )

    def steady_memory(self, slip: Sequence[float]) -> tuple[float, ...]:
        """Return the deflection after a long slip at a constant velocity."""
        speed = float(np.linalg.norm(slip))
        return tuple(self.steady_deflection(speed) * float(part) / speed for part in slip)
