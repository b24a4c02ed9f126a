"""The fifth-order coefficient at a generalised period doubling, from orbits of finite amplitude."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.newton import Rule, correct_many, solve_each
from slipfold.normal_forms.normal_form import critical_vectors
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits

AMPLITUDES = 0.05 / 2.0 ** np.arange(6)
"""Largest amplitudes of successive evaluations, in scaled states: the higher powers fade, until
rounding takes over."""

SHARES = np.array([0.55, 0.7, 0.85, 1.0])
"""Amplitudes of one evaluation, over the largest."""

AGREEMENT = 1e-2
"""Share by which the two that agree best may differ."""

RULE = Rule(close=1e-12, iterations=12)


def quintic_coefficient(orbits: Orbits, point: OrbitPoint, scales: Array) -> float | None:
    r"""Return e of the normal form :math:`\eta \to -\eta + b \eta^3 + e \eta^5` where b is zero.

    An orbit of twice the period with the amplitude a along the critical vector q exists if the map
    is shifted by :math:`\tau q` in one period and by :math:`-\tau q` in the next, with
    :math:`\tau = -(b a^3 + e a^5 + ...)` (the reduction of Lyapunov and Schmidt).
    """
    amplitudes = np.multiply.outer(AMPLITUDES, SHARES)
    shifts = _shifts(orbits, point, scales, amplitudes.ravel()).reshape(amplitudes.shape)
    # tau / a^3 = -(b + e a^2 + ...): b is what was left over of it.
    powers = amplitudes[:, :, None] ** np.array([0, 2, 4, 6])
    found = -solve_each(powers, shifts / amplitudes**3)[:, 1]
    pairs = [(a, b) for a, b in pairwise(found.tolist()) if b and not np.isnan(a / b)]
    best = min(pairs, key=lambda pair: abs(pair[0] / pair[1] - 1), default=None)
    if best is None or abs(best[0] / best[1] - 1) > AGREEMENT:
        return None
    return best[1]


def _shifts(orbits: Orbits, point: OrbitPoint, scales: Array, amplitudes: Array) -> Array:
    """Newton's method for both states and the shift at given amplitudes, shape (k,)."""
    n, constants = len(scales), orbits.constants(point.z)
    matrix = point.monodromy * (orbits.scales / scales)[:, None] / (orbits.scales / scales)
    right, left, _ = critical_vectors(matrix, lambda values: np.abs(values + 1))
    q, p = right.real, left.real
    centre = orbits.nodes(point.z)[0] / scales
    away = amplitudes[:, None] * q
    no_parameter = np.zeros((len(constants.values), 0))
    jacobian = np.zeros((2 * n + 1, 2 * n + 1))
    jacobian[:n, n : 2 * n] = jacobian[n : 2 * n, :n] = -np.eye(n)
    jacobian[:n, -1], jacobian[n : 2 * n, -1] = q, -q
    jacobian[-1, :n], jacobian[-1, n : 2 * n] = p / 2, -p / 2

    def steps(some: NDArray[np.int64], unknown: Array) -> Array:
        states, shifts = unknown[:, :-1].reshape(-1, 2, n), unknown[:, -1:]
        start = np.full(2 * len(some), orbits.phase)
        ends, blocks, _ = orbits.flow.linearise(
            (states * scales).reshape(-1, n), start, start + orbits.period, constants, no_parameter
        )
        images = ends.reshape(-1, 2, n) / scales
        slopes = (blocks * scales / scales[:, None]).reshape(-1, 2, n, n)
        matrices = np.tile(jacobian, (len(some), 1, 1))
        matrices[:, :n, :n], matrices[:, n : 2 * n, n : 2 * n] = slopes[:, 0], slopes[:, 1]
        residual = [
            images[:, 0] - states[:, 1] + shifts * q,
            images[:, 1] - states[:, 0] - shifts * q,
            ((states[:, 0] - states[:, 1]) @ p / 2 - amplitudes[some])[:, None],
        ]
        return solve_each(matrices, -np.concatenate(residual, axis=1))

    guesses = np.column_stack([centre + away, centre - away, np.zeros(len(amplitudes))])
    return correct_many(steps, guesses, RULE).z[:, -1]
