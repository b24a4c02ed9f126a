"""Which orbits a model has."""

from __future__ import annotations

from collections.abc import Mapping

from slipfold.models.model import Model
from slipfold.orbits.cycles import Cycles
from slipfold.orbits.discretisations.segments import Cut
from slipfold.orbits.discretisations.shooting import Shooting
from slipfold.orbits.equilibria import Equilibria
from slipfold.orbits.forced_orbits import ForcedOrbits
from slipfold.orbits.orbit_curve import Orbits


def orbits_of(
    model: Model,
    vary: Mapping[str, float],
    period: int,
    segments: int,
    *,
    resting: bool = False,
    by: Cut = Shooting,
) -> Orbits:
    """Return forced orbits of a forced model, of an autonomous one cycles, or what rests."""
    if model.forced:
        return ForcedOrbits(model, vary, period, segments, by)
    return Equilibria(model, vary) if resting else Cycles(model, vary, period, segments, by)
