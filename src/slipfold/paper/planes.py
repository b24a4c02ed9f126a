"""Bifurcation sets to compute and to draw beyond what the source paper shows."""

from __future__ import annotations

from dataclasses import dataclass

from slipfold.loci.window import Window
from slipfold.models.sliding_oscillator import SlidingOscillator


@dataclass(frozen=True)
class Plane:
    """One bifurcation set."""

    model: SlidingOscillator  # the model; its values of `vary` play no part
    vary: tuple[str, str]  # names of the two parameters
    window: Window  # least and largest value of each

    @property
    def key(self) -> str:
        """Name for files."""
        return f"plane_{self.vary[0]}_{self.vary[1]}"


@dataclass(frozen=True)
class PlaneFigure:
    """The figure of a bifurcation set: its whole window and a part of it, magnified."""

    plane: Plane  # the bifurcation set
    title: str  # what the first parameter is
    detail: Window  # the part of the window that is drawn once more
    wide: bool = False  # whether the detail lies below instead of beside

    @property
    def key(self) -> str:
        """Name for files."""
        return f"bifurcation_set_{self.plane.vary[0]}_{self.plane.vary[1]}"

    @property
    def needs(self) -> tuple[Plane, ...]:
        """All that must be computed before it can be drawn."""
        return (self.plane,)
