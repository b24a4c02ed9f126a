"""Where the first branch of a response begins, if that is given."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipfold.orbits.periodic_orbit import PeriodicOrbit

__all__ = ["Begin"]


@dataclass(frozen=True, eq=False)
class Begin:
    """A value of the parameter, and what is there.

    Parameters
    ----------
    value
        The value; inside the span the branch is followed from it in both directions.
    orbit
        An orbit at that value, or None for an equilibrium of an autonomous model.
    state
        State near that equilibrium, shape (n,); None with an orbit.
    """

    value: float
    orbit: PeriodicOrbit | None = None
    state: NDArray[np.float64] | None = None

    def measured_in(self, sizes: NDArray[np.float64] | None) -> Begin:
        """Return the same in other typical sizes of the states.

        Shapes: sizes (n,).
        """
        if self.orbit is None:
            return self
        model = self.orbit.model.measured_in(sizes)
        return replace(self, orbit=replace(self.orbit, model=model))
