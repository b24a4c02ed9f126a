"""Which points intervals have, and how many there are at least: what fast vibrations ask for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.collocation_points import CollocationPoints, gauss_points, radau_points

STAGES = 6
"""Points an interval: errors at its ends fall with the 12th power of its length, of Radau points
with the 11th."""

RESOLVED = 6.0
"""Radians that a vibration turns in an interval at most for polynomials to carry it: at Radau
points they lose 0.4 percent of it there, at 4 radians 0.005 percent."""

FAST = 64 * RESOLVED
"""Radians a unit of phase beyond which vibrations are not resolved if they decay."""

DECAYS = 3.0
"""Decay in a unit of phase, as an exponent, beyond which a vibration is stable for certain."""

DENSEST = 400.0
"""Intervals a unit of phase up to which what decays more slowly is resolved for its own sake."""


@dataclass(frozen=True, eq=False)
class Scheme:
    """How intervals are solved."""

    points: CollocationPoints  # where the equations are met
    density: float = 0.0  # intervals a unit of phase at least


GAUSS = Scheme(gauss_points(STAGES))


def scheme_for(jacobians: Array, stages: int = STAGES) -> Scheme:
    """Return how intervals are solved, from derivatives of the rates a unit of phase.

    Gauss points carry on what they do not resolve as if nothing damped it: nothing is lost where
    nothing is damped, but multipliers of stiff modes come near one, and orbits resonate with them.
    Radau points damp it. They are taken where there are, at all places, fast vibrations that decay;
    those that do not are resolved.

    Shapes: jacobians (q, n, n).
    """
    if not np.isfinite(jacobians).all():
        return Scheme(gauss_points(stages))
    values = np.linalg.eigvals(jacobians)
    turning, decays = np.abs(values.imag), -values.real > DECAYS
    density = float(turning[~decays].max(initial=0.0)) / RESOLVED
    if density > DENSEST or not (decays & (turning > FAST)).any(axis=1).all():
        return Scheme(gauss_points(stages))
    return Scheme(radau_points(stages), density)
