"""By which discretisation orbits are begun: what settings ask for, and what their rates allow."""

from __future__ import annotations

from functools import partial

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.settings import Settings
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model
from slipfold.orbits.collocation import INTERVALS, Collocation
from slipfold.orbits.discretisation import Cut, scheme_for
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.shooting import SEGMENTS, Shooting

STIFF = 200.0
"""Turns of the fastest vibration within a period from which on collocation is quicker: forty masses
in a chain make fifty; beams of three, four and five elements 190, 300 and 500, where shooting takes
half, four times and ten times as long. Fast decay does not count: friction that is steep at rest is
so for moments only."""


def method_for(settings: Settings, jacobian: Array) -> Cut:
    """Return how cycles are to be cut, from the derivatives of the rates a period, shape (n, n)."""
    chosen = settings.discretisation
    if chosen == "collocation" or (chosen == "automatic" and _is_stiff(jacobian)):
        return partial(Collocation, scheme=scheme_for(jacobian[None]))
    return Shooting


def _is_stiff(jacobian: Array) -> bool:
    if not np.isfinite(jacobian).all():
        return False
    turns = float(np.abs(np.linalg.eigvals(jacobian).imag).max()) / (2 * np.pi)
    return turns > STIFF


def forced_orbits(model: Model, vary: str, width: float, settings: Settings) -> ForcedOrbits:
    """Return orbits of the response, cut as they are to be followed.

    However stiff, they begin by shooting where fast vibrations do not decay: multipliers of those
    that a mesh does not resolve stay near the unit circle and feign bifurcations.
    """
    state, constants = model.start[None], flow_of(model).constants_of(model)
    jacobian = flow_of(model).jacobians(state, np.zeros(1), constants)[0]
    scheme = scheme_for(jacobian[None])
    decays = scheme.points.damps and _is_stiff(jacobian)
    chosen = settings.discretisation
    if chosen == "collocation" or (chosen == "automatic" and decays):
        return ForcedOrbits(
            model, {vary: width}, 1, 4 * INTERVALS, partial(Collocation, scheme=scheme)
        )
    return ForcedOrbits(model, {vary: width}, 1, SEGMENTS, Shooting)
