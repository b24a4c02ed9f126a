"""A motion known at every instant, as Taylor polynomials from step to step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["DenseMotion"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DenseMotion:
    """A motion of an autonomous model over some steps of the integrator."""

    phases: Array  # where the steps begin and end, from zero on, shape (m,)
    polynomials: Any  # maps phases to states in units of the scales
    scales: Array  # units of the states

    @property
    def end(self) -> float:
        """The last phase."""
        return float(self.phases[-1])

    def at(self, phases: Array) -> Array:
        """Return the states at some phases, as exact as the integration, shape (m, n).

        Shapes: phases (m,).
        """
        return np.array(self.polynomials(phases)) * self.scales
