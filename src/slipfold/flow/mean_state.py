"""The equilibrium under the mean of a forcing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.flow import Constants, Flow
from slipfold.models.damped_newton import damped_newton

__all__ = ["PHASES", "mean_state"]

Array = NDArray[np.float64]

PHASES = np.arange(32) / 32
"""Phases that average the forcing: exact for up to 31 harmonics."""

BESIDE = 1e-3
"""Rest itself may be a singular point of a model: the search then starts so far beside it."""


def mean_state(flow: Flow, constants: Constants, scales: Array, start: Array) -> Array:
    """Return the equilibrium under the forcing's mean, shape (n_states,).

    Shapes: scales, start (n_states,).
    """

    def repeated(state: Array) -> Array:
        return np.tile(state, (len(PHASES), 1))

    for beside in (0.0, BESIDE):
        found = damped_newton(
            lambda state: flow.rates(repeated(state), PHASES, constants).mean(axis=0),
            lambda state: flow.jacobians(repeated(state), PHASES, constants).mean(axis=0),
            start + beside * scales,
            scales,
        )
        if found is not None:
            return found
    return np.full(flow.dimension, np.nan)
