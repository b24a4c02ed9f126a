"""The fifth-order coefficient at a generalised period doubling, from orbits of finite amplitude."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.normal_form import critical_vectors
from slipfold.orbits.orbit_point import OrbitPoint
from slipfold.orbits.shooting import Shooting

__all__ = ["quintic_coefficient"]

Array = NDArray[np.float64]

AMPLITUDES = tuple(0.05 / 2**k for k in range(6))
"""Largest amplitudes of successive evaluations, in scaled states: the higher powers fade, until
rounding takes over."""

AGREEMENT = 1e-2
"""Share by which the two that agree best may differ."""

ITERATIONS = 12

CONVERGED = 1e-12


def quintic_coefficient(problem: Shooting, point: OrbitPoint, scales: Array) -> float | None:
    r"""Return e of the normal form :math:`\eta \to -\eta + b \eta^3 + e \eta^5` where b is zero.

    An orbit of twice the period with the amplitude a along the critical vector q exists if the map
    is shifted by :math:`\tau q` in one period and by :math:`-\tau q` in the next, with
    :math:`\tau = -(b a^3 + e a^5 + ...)` (the reduction of Lyapunov and Schmidt).
    """
    found = [_from_amplitudes(problem, point, scales, largest) for largest in AMPLITUDES]
    pairs = [(a, b) for a, b in pairwise(found) if a is not None and b is not None and b]
    best = min(pairs, key=lambda pair: abs(pair[0] / pair[1] - 1), default=None)
    if best is None or abs(best[0] / best[1] - 1) > AGREEMENT:
        return None
    return best[1]


def _from_amplitudes(
    problem: Shooting, point: OrbitPoint, scales: Array, largest: float
) -> float | None:
    amplitudes = largest * np.array([0.55, 0.7, 0.85, 1.0])
    shifts = []
    for amplitude in amplitudes:
        shift = _shift(problem, point, scales, float(amplitude))
        if shift is None:
            return None
        shifts.append(shift)
    # tau / a^3 = -(b + e a^2 + ...): b is what was left over of it.
    powers = amplitudes[:, None] ** np.array([0, 2, 4, 6])
    return float(-np.linalg.solve(powers, np.array(shifts) / amplitudes**3)[1])


def _shift(problem: Shooting, point: OrbitPoint, scales: Array, amplitude: float) -> float | None:
    """Newton's method for both states and the shift at a given amplitude."""
    n = len(scales)
    constants = problem.constants(point.z)
    matrix = point.monodromy * (problem.scales / scales)[:, None] / (problem.scales / scales)
    right, left, _ = critical_vectors(matrix, lambda values: np.abs(values + 1))
    q, p = right.real, left.real
    centre = problem.nodes(point.z)[0] / scales
    unknown = np.concatenate([centre + amplitude * q, centre - amplitude * q, [0.0]])
    start = np.full(2, problem.phase)
    no_parameter = np.zeros((len(constants.values), 0))
    for _ in range(ITERATIONS):
        states = unknown[:-1].reshape(2, n)
        ends, blocks, _ = problem.flow.linearise(
            states * scales, start, start + problem.period, constants, no_parameter
        )
        if not np.isfinite(ends).all():
            return None
        images, slopes = ends / scales, blocks * scales / scales[:, None]
        shift = unknown[-1]
        residual = np.concatenate(
            [
                images[0] - states[1] + shift * q,
                images[1] - states[0] - shift * q,
                [p @ (states[0] - states[1]) / 2 - amplitude],
            ]
        )
        jacobian = np.zeros((2 * n + 1, 2 * n + 1))
        jacobian[:n, :n], jacobian[:n, n : 2 * n] = slopes[0], -np.eye(n)
        jacobian[n : 2 * n, :n], jacobian[n : 2 * n, n : 2 * n] = -np.eye(n), slopes[1]
        jacobian[:n, -1], jacobian[n : 2 * n, -1] = q, -q
        jacobian[-1, :n], jacobian[-1, n : 2 * n] = p / 2, -p / 2
        step = np.linalg.solve(jacobian, -residual)
        unknown = unknown + step
        if np.abs(step).max() < CONVERGED:
            return float(unknown[-1])
    return None
