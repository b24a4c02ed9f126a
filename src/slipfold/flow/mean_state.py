"""The equilibrium under the mean of a forcing."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.models.equilibria import damped_newton

PHASES = np.arange(32) / 32
"""Phases that average the forcing: exact for up to 31 harmonics."""

BESIDE = 1e-3
"""Rest itself may be a singular point of a model: the search then starts so far beside it."""


def mean_state(flow: Flow, constants: Constants, scales: Array, start: Array) -> Array:
    """Return the equilibrium under the forcing's mean, shape (n_states,).

    Shapes: scales, start (n_states,).
    """
    n, count = flow.dimension, len(PHASES)

    def linear(states: Array) -> tuple[Array, Array]:
        at, phases = np.repeat(states, count, axis=0), np.tile(PHASES, len(states))
        rates, jacobians = (of(at, phases, constants) for of in (flow.rates, flow.jacobians))
        return (
            rates.reshape(-1, count, n).mean(axis=1),
            jacobians.reshape(-1, count, n, n).mean(axis=1),
        )

    found = np.full(n, np.nan)
    for beside in (0.0, BESIDE):
        if np.isnan(found).any():
            found = damped_newton(linear, (start + beside * scales)[None], scales)[0]
    return found
