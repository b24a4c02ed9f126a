"""The first guess of a periodic orbit: the mean state and the linear response about it."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.flow.mean_state import PHASES, mean_state

HARMONICS = 8


def linear_response(
    flow: Flow, constants: Constants, scales: Array, segments: int, start: Array
) -> Array:
    """Return the steady linear response about the mean state at equidistant phases.

    Shapes: scales, start (n_states,); returns (m, n_states).
    """
    n = flow.dimension
    centre = mean_state(flow, constants, scales, start)
    states = np.tile(centre, (len(PHASES), 1))
    forcing = np.fft.fft(flow.rates(states, PHASES, constants), axis=0) / len(PHASES)
    jacobian = flow.jacobians(states, PHASES, constants).mean(axis=0)
    nodes = np.tile(centre, (segments, 1))
    phases = np.arange(segments) / segments
    for harmonic in range(1, HARMONICS + 1):
        stiffness = (2j * np.pi * harmonic * np.eye(n) - jacobian) * scales
        if np.isfinite(stiffness).all():
            # Rows of one size: else slow modes are nothing but rounding beside fast ones.
            sizes = np.abs(stiffness).max(axis=1)
            # Without damping a harmonic may meet a resonance: what does not force it is left out.
            found = np.linalg.lstsq(stiffness / sizes[:, None], forcing[harmonic] / sizes)[0]
            amplitude = scales * found
            nodes += 2 * (np.exp(2j * np.pi * harmonic * phases)[:, None] * amplitude).real
    return nodes
