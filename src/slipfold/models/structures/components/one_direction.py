"""What acts along one direction of a structure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from slipfold.models.structures.components.component import Component
from slipfold.models.structures.components.direction import Direction, as_direction


@dataclass(frozen=True)
class OneDirection(Component):
    """A component along one direction.

    Parameters
    ----------
    at
        Degree of freedom, or weights by name.
    """

    at: Any

    def prepare(self) -> None:
        """Read the direction."""
        object.__setattr__(self, "at", as_direction(self.at, f"a {self.title}"))

    @property
    def directions(self) -> tuple[Direction | None, ...]:
        """The one direction."""
        return (self.at,)
