"""The equilibrium under the mean of a forcing, and the linear response about it."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.models.equilibria import damped_newton

PHASES = np.arange(32) / 32
"""Phases that average the forcing: exact for up to 31 harmonics."""


def mean_states(flow: Flow, constants: Constants, scales: Array, starts: Array) -> Array:
    """Return the equilibrium under the forcing's mean from each start, shape (k, n_states).

    Coefficients may differ from row to row. Shapes: scales (n_states,) or (k, n_states); starts
    (k, n_states).
    """
    averaged = PHASES if flow.equations.forced else PHASES[:1]
    n, count = flow.dimension, len(averaged)

    def linear(states: Array, rows: Indices) -> tuple[Array, Array]:
        at, phases = np.repeat(states, count, axis=0), np.tile(averaged, len(states))
        own = constants.rows(rows.repeat(count))
        rates, jacobians = (of(at, phases, own) for of in (flow.rates, flow.jacobians))
        rates, jacobians = rates.reshape(-1, count, n), jacobians.reshape(-1, count, n, n)
        return rates.mean(axis=1), jacobians.mean(axis=1)

    result = damped_newton(linear, starts, scales)
    lost = np.flatnonzero(np.isnan(result).any(axis=1))
    if len(lost):  # the state of rest may be singular
        near, wide = starts + 1e-3 * scales, np.broadcast_to(scales, starts.shape)
        result[lost] = damped_newton(
            lambda states, rows: linear(states, lost[rows]), near[lost], wide[lost]
        )
    return result


def linear_response(
    flow: Flow, constants: Constants, scales: Array, segments: int, start: Array
) -> Array:
    """Return the steady linear response about the mean state at equidistant phases.

    Shapes: scales, start (n_states,); returns (m, n_states).
    """
    return linear_responses(flow, constants, scales, segments, start[None])[0]


def linear_responses(
    flow: Flow, constants: Constants, scales: Array, segments: int, starts: Array
) -> Array:
    """Return those from several starts, the coefficients of which may differ.

    Shapes: scales (n_states,) or (k, n_states); starts (k, n_states); returns (k, m, n_states).
    """
    k, n, count = *starts.shape, len(PHASES)
    centers = mean_states(flow, constants, scales, starts)
    states, phases = np.repeat(centers, count, axis=0), np.tile(PHASES, k)
    own = constants.rows(np.arange(k).repeat(count))
    rates, jacobians = (of(states, phases, own) for of in (flow.rates, flow.jacobians))
    forcing = np.fft.fft(rates.reshape(k, count, n), axis=1) / count
    jacobians = jacobians.reshape(k, count, n, n).mean(axis=1)
    nodes = np.repeat(centers[:, None], segments, axis=1)
    for row, wide in enumerate(np.broadcast_to(scales, starts.shape)):
        nodes[row] += _vibration(forcing[row], jacobians[row], wide, np.arange(segments) / segments)
    return nodes


def _vibration(forcing: Array, jacobian: Array, scales: Array, phases: Array) -> Array:
    """Return the linear answer to harmonics of a forcing, shape (m, n).

    Shapes: forcing (32, n); jacobian (n, n); scales (n,); phases (m,).
    """
    n, result = len(scales), np.zeros((len(phases), len(scales)))
    forced = np.abs(forcing / scales).max(axis=1)
    for harmonic in 1 + np.flatnonzero(forced[1:9] > np.finfo(float).eps * forced.max()):
        stiffness = (2j * np.pi * harmonic * np.eye(n) - jacobian) * scales
        if np.isfinite(stiffness).all():
            # Rows are normalized: else slow modes would be rounding errors of fast ones.
            sizes = np.abs(stiffness).max(axis=1)
            # Without damping a harmonic may be resonant: least squares leaves out unforced modes.
            answer = np.linalg.lstsq(stiffness / sizes[:, None], forcing[harmonic] / sizes)[0]
            turns = np.exp(2j * np.pi * harmonic * phases)[:, None]
            result += 2 * (turns * (scales * answer)).real
    return result
