"""How far an orbit through stick and slip is from what other steps and its equations say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.checks.elsewhere import elsewhere
from slipfold.checks.held_legs import FORCES, hold_legs
from slipfold.checks.orbit_difference import ALLOWED, Difference
from slipfold.flow.flow import flow_of
from slipfold.flow.switched.mode import Mode
from slipfold.flow.switched.sampled import dense_legs
from slipfold.flow.switched.switched_flow import switched_flow_of
from slipfold.models.turns import without_turns
from slipfold.orbits.multipliers import multiplier_difference
from slipfold.orbits.periodic_orbit import StickSlipOrbit

STEP = 1e-6
"""Perturbation of scaled states: smaller ones leave fewer digits, larger ones are not small."""

COARSE = 1e-6
"""Difference of multipliers from those of perturbed motions that is allowed: differences have no
more digits, and in the plane nor has the linearisation."""


UNTOLD = 0.1
"""Share of an extrapolation's change that it may be wrong by."""


def switched_difference(orbit: StickSlipOrbit) -> Difference:
    """Return the largest difference in units of what is allowed: of states and of multipliers.

    The orbit is carried round with steps that fall elsewhere and held against equations and
    friction; so are motions beside it. Where these change in another order, as beside a graze, no
    multipliers are compared.
    """
    flow, model = switched_flow_of(orbit.model), orbit.model
    constants, scales = flow_of(model).constants_of(model), model.state_scales()
    weights, end = flow.weights(orbit.state, constants), float(orbit.period)

    def carried(state: Array) -> tuple[Array, list[Mode]]:
        start = flow.held(orbit.first_mode, state, 0.0, constants)
        return elsewhere(flow, orbit.first_mode, start, end, constants, weights)

    arrived, order = carried(orbit.state)
    passed = dense_legs(model, orbit.state, orbit.first_mode, end)
    held = hold_legs(flow, passed, orbit.state, constants, weights)
    apart = without_turns(arrived - orbit.state, model.whole_turns) / scales
    states = max(float(np.abs(apart).max()), held.drift, held.forces * ALLOWED / FORCES)
    place = Difference(float(states) if np.isfinite(states) else np.inf, ALLOWED)

    def differenced(step: float) -> Array | None:
        columns = []
        for one in np.eye(len(scales)):
            (more, first), (less, second) = (
                carried(orbit.state + sign * step * one * scales) for sign in (1, -1)
            )
            if not order == first == second:
                return None
            columns.append((more - less) / scales / (2 * step))
        return np.transpose(columns)

    matrix = differenced(STEP)
    if matrix is None:
        return place
    multipliers = _judged(orbit, matrix)
    if multipliers.excess > 1:
        # Beside a touch, after stick that lasts d, third derivatives go as d^-3.
        finer = differenced(STEP / 2)
        multipliers = multipliers if finer is None else _extrapolated(orbit, matrix, finer)
    return max(place, multipliers, key=lambda difference: difference.excess)


def _judged(orbit: StickSlipOrbit, matrix: Array) -> Difference:
    """Hold multipliers against those of a matrix of differences."""
    size = max(1.0, float(np.abs(orbit.multipliers).max()))
    value = multiplier_difference(orbit.multipliers, _values(matrix)) / size
    return Difference(value, COARSE, what="multipliers")


def _extrapolated(orbit: StickSlipOrbit, matrix: Array, finer: Array) -> Difference:
    """Hold them against differences of two steps, whose error of second order is left out.

    What extrapolation does not tell is as uncertain as a tenth of what it changes.
    """
    better = (4 * finer - matrix) / 3
    size = max(1.0, float(np.abs(orbit.multipliers).max()))
    changed = multiplier_difference(_values(better), _values(finer)) / size
    found = _judged(orbit, better)
    return replace(found, allowed=max(COARSE, UNTOLD * changed))


def _values(matrix: Array) -> NDArray[np.complex128]:
    return np.linalg.eigvals(matrix).astype(complex)
