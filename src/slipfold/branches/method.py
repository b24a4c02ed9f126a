"""By which discretisation orbits are begun: what settings ask for, and what their rates allow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.settings import Settings
from slipfold.models.model import Model
from slipfold.orbits.by_collocation import FIRST
from slipfold.orbits.discretisations.collocation import Collocation
from slipfold.orbits.discretisations.segments import Cut
from slipfold.orbits.discretisations.shooting import SEGMENTS, Shooting
from slipfold.orbits.forced_orbits import ForcedOrbits

__all__ = ["forced_orbits", "method_for"]

Array = NDArray[np.float64]

STIFF = 500.0
"""Turns of the fastest vibration within a period for which an explicit integrator takes thousands
of steps: forty masses in a chain make fifty, a beam of three elements a thousand. Fast decay does
not count: friction that is steep at rest is so for moments only."""


def method_for(settings: Settings, jacobian: Array) -> Cut:
    """Return how cycles are to be cut, from the derivatives of the rates a period, shape (n, n)."""
    stiff = bool(np.isfinite(jacobian).all()) and _turns(jacobian) > STIFF
    chosen = settings.discretisation
    return Collocation if chosen == "collocation" or (stiff and chosen != "shooting") else Shooting


def _turns(jacobian: Array) -> float:
    return float(np.abs(np.linalg.eigvals(jacobian).imag).max()) / (2 * np.pi)


def forced_orbits(model: Model, vary: str, width: float, settings: Settings) -> ForcedOrbits:
    """Return orbits of the response, cut as they are to be followed.

    They begin by shooting however stiff they are: multipliers of vibrations that a mesh does not
    resolve stay near the unit circle and feign bifurcations.
    """
    if settings.discretisation == "collocation":
        return ForcedOrbits(model, {vary: width}, 1, FIRST, Collocation)
    return ForcedOrbits(model, {vary: width}, 1, SEGMENTS, Shooting)
