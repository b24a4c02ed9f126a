"""Newton's method for many orbits of period 1 at once, each with parameters of its own.

Orbits are unknown by their state at phase zero alone (single shooting): what is followed here is
stable or about to lose its stability, so that nothing grows over a period.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.flow import Flow
from slipfold.flow.scaled import power_of_two

__all__ = ["Doublings", "Orbits", "correct_orbits", "find_doublings", "multipliers_of"]

Array = NDArray[np.float64]

ITERATIONS = 8

NUDGE = 1e-5
"""Distance in scaled states over which monodromy matrices are differenced. The error of the Newton
matrix, 1e-5 relative, costs less than an iteration; the residual has none."""

RENEW = 1e-4
"""After a correction longer than this the test function is differentiated anew."""

REMAINING = 1e-12
"""Estimated distance to the solution, in scaled states and spans, at which iteration ends."""

LAST = 1e-6
"""The last correction is shorter than this, lest that estimate rest on chance."""

BEND = 100.0
"""Curvature, in scaled variables, that the estimate reckons with after the first correction."""

DIVERGED = 1.0
"""A correction this long, in scaled states and spans, leads nowhere that is wanted."""


@dataclass(frozen=True, eq=False)
class Orbits:
    """Orbits at given parameters.

    Parameters
    ----------
    states
        States at phase zero, shape (m, n); NaN where Newton's method failed.
    multipliers
        Floquet multipliers, complex, shape (m, n), of the orbit before its last correction.
    moved
        Length of the last correction in scaled states, shape (m,).
    """

    states: Array
    multipliers: NDArray[np.complex128]
    moved: Array


@dataclass(frozen=True, eq=False)
class Doublings:
    """Period doublings in one parameter.

    Parameters
    ----------
    states
        States at phase zero, shape (m, n).
    values
        Values of the parameter, shape (m,).
    multipliers
        Floquet multipliers, complex, shape (m, n).
    residuals
        How far each orbit fails to close, in scaled states, shape (m,).
    failures
        Why there is no solution, shape (m,); empty where there is one.
    """

    states: Array
    values: Array
    multipliers: NDArray[np.complex128]
    residuals: Array
    failures: NDArray[np.str_]


def multipliers_of(monodromies: Array) -> NDArray[np.complex128]:
    """Return the eigenvalues of matrices, largest modulus first; NaN where a matrix is not finite.

    Shapes: monodromies (m, n, n).
    """
    finite = np.isfinite(monodromies).all(axis=(1, 2))
    values = np.full(monodromies.shape[:2], np.nan, complex)
    if finite.any():
        found = np.linalg.eigvals(monodromies[finite]).astype(complex)
        modulus = np.round(np.abs(found), 12)  # those of a pair differ by rounding
        order = np.lexsort((-found.imag, -found.real, -modulus), axis=-1)
        values[finite] = np.take_along_axis(found, order, axis=1)
    return values


def correct_orbits(
    flow: Flow, states: Array, parameters: Array, scales: Array, close: float
) -> Orbits:
    """Correct guesses to orbits of period 1.

    Shapes: states (m, n); parameters (m, n_p); scales (m, n).
    """
    m, n = states.shape
    result = states.copy()
    multipliers = np.full((m, n), np.nan, complex)
    moved = np.full(m, np.inf)
    active = np.arange(m)
    for _ in range(ITERATIONS):
        if not len(active):
            break
        x, scale = result[active], scales[active]
        ends, matrices = _over_one_period(flow, x, parameters[active], scale)
        step = _solve(matrices - np.eye(n), x - ends)
        length = np.linalg.norm(step / scale, axis=1)
        lost = ~(length < DIVERGED)
        result[active] = np.where(lost[:, None], np.nan, x + step)
        moved[active] = np.where(lost, np.inf, length)
        last = length < close
        multipliers[active[last]] = multipliers_of(matrices[last])
        active = active[~last & ~lost]
    result[active] = np.nan
    moved[active] = np.inf
    return Orbits(result, multipliers, moved)


def find_doublings(
    flow: Flow,
    states: Array,
    parameters: Array,
    index: int,
    scales: Array,
    width: float,
    tolerance: float = 1e-10,
) -> Doublings:
    r"""Correct guesses to period doublings in one parameter.

    The unknowns are the state x at phase zero and the parameter p, the equations

    .. math:: \phi(x, p) - x = 0, \quad g(x, p) = 0, \qquad
        \begin{pmatrix} M + I & b \\ c^T & 0 \end{pmatrix}
        \begin{pmatrix} q \\ g \end{pmatrix} = \begin{pmatrix} 0 \\ 1 \end{pmatrix}

    with the monodromy matrix M and borders b, c that are its singular vectors at the guess
    (Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, section 4). The
    derivative of g needs that of M along q alone: one more monodromy matrix, beside the orbit.

    Shapes: states (m, n); parameters (m, n_p); scales (m, n).
    """
    work = _Doubling(flow, states, parameters, index, scales, width)
    for _ in range(ITERATIONS):
        active = np.flatnonzero(work.active)
        if not len(active):
            break
        work.iterate(active)
    return work.result(tolerance)


class _Doubling:
    """The iteration of `find_doublings`, in scaled variables."""

    def __init__(
        self, flow: Flow, states: Array, parameters: Array, index: int, scales: Array, width: float
    ) -> None:
        m, n = states.shape
        self.flow, self.index, self.scales, self.width = flow, index, scales, width
        self.unknown = np.column_stack([states / scales, parameters[:, index] / width])
        self.parameters = parameters.copy()
        self.borders = np.full((m, 2, n), np.nan)
        self.slopes = np.full((m, n + 1), np.nan)
        self.moved = np.full(m, np.inf)
        self.active = np.asarray(np.isfinite(self.unknown).all(axis=1), dtype=bool)
        self.failures = np.where(self.active, "Newton's method did not converge", "no guess")

    def iterate(self, active: NDArray[np.int64]) -> None:
        n = self.scales.shape[1]
        unknown, before = self.unknown[active], self.moved[active]
        residual, matrices, along = self.linearise(active, unknown)
        fresh = np.isnan(self.borders[active, 0, 0])
        self.borders[active[fresh]] = _singular_vectors(matrices[fresh] + np.eye(n))
        q, w, g = _null_vectors(matrices + np.eye(n), self.borders[active])
        renew = np.flatnonzero(before > RENEW)
        if len(renew):
            nudged = unknown[renew].copy()
            nudge = NUDGE * np.linalg.norm(q[renew], axis=1)[:, None] ** -1
            nudged[:, :n] += nudge * q[renew]
            _, others, beside = self.linearise(active[renew], nudged)
            change = np.concatenate([others - matrices[renew], beside - along[renew]], axis=2)
            slopes = -np.einsum("ma,mab->mb", w[renew], change) / nudge
            self.slopes[active[renew]] = slopes
        jacobian = np.zeros((len(active), n + 1, n + 1))
        jacobian[:, :n, :n] = matrices - np.eye(n)
        jacobian[:, :n, n:] = along
        jacobian[:, n] = self.slopes[active]
        step = _solve(jacobian, -np.column_stack([residual, g]))
        self.advance(active, step)

    def advance(self, active: NDArray[np.int64], step: Array) -> None:
        length: Array = np.linalg.norm(step, axis=1)
        before = self.moved[active]
        lost: NDArray[np.bool_] = ~((length < DIVERGED) & (length < 2 * before))
        self.unknown[active] += np.where(lost[:, None], np.nan, step)
        self.moved[active] = length
        self.failures[active[lost]] = "Newton's method diverged"
        # The iteration contracts at least as it did last time; at first, as Newton's method does.
        rate = np.where(np.isinf(before), BEND * length, length / before)
        done: NDArray[np.bool_] = ~lost & (length < LAST) & (length * rate < REMAINING)
        self.failures[active[done]] = ""
        self.active[active[done]] = self.active[active[lost]] = False

    def linearise(self, which: NDArray[np.int64], unknown: Array) -> tuple[Array, Array, Array]:
        """Return mismatch, monodromy matrices and derivatives along the parameter, scaled."""
        scales = self.scales[which]
        parameters = self.parameters[which]
        parameters[:, self.index] = unknown[:, -1] * self.width
        constants = self.flow.constants(parameters, power_of_two(scales))
        zero = np.zeros(len(which))
        ends, matrices, vectors = self.flow.linearise(
            unknown[:, :-1] * scales, zero, zero + 1, constants, constants.rates[:, :, [self.index]]
        )
        ratios = scales[:, None, :] / scales[:, :, None]
        return (
            ends / scales - unknown[:, :-1],
            matrices * ratios,
            vectors * (self.width / scales[:, :, None]),
        )

    def result(self, tolerance: float) -> Doublings:
        m, n = self.scales.shape
        states, values = self.unknown[:, :-1] * self.scales, self.unknown[:, -1] * self.width
        residuals, multipliers = np.full(m, np.inf), np.full((m, n), np.nan, complex)
        done = np.flatnonzero(self.failures == "")
        if len(done):
            parameters = self.parameters[done]
            parameters[:, self.index] = values[done]
            scales = self.scales[done]
            ends, matrices = _over_one_period(self.flow, states[done], parameters, scales)
            residuals[done] = np.abs((ends - states[done]) / scales).max(axis=1)
            multipliers[done] = multipliers_of(matrices)
        self.failures[done[~(residuals[done] <= tolerance)]] = "the orbit does not close"
        return Doublings(states, values, multipliers, residuals, self.failures)


def _over_one_period(
    flow: Flow, states: Array, parameters: Array, scales: Array
) -> tuple[Array, Array]:
    """Return the states a period later, shape (m, n), and the monodromy matrices."""
    constants = flow.constants(parameters, power_of_two(scales))
    zero = np.zeros(len(states))
    nowhere = np.empty((constants.values.shape[1], 0))
    return flow.linearise(states, zero, zero + 1, constants, nowhere)[:2]


def _singular_vectors(matrices: Array) -> Array:
    """Left and right vectors of the smallest singular values, shape (m, 2, n)."""
    result = np.full((len(matrices), 2, matrices.shape[1]), np.nan)
    finite = np.isfinite(matrices).all(axis=(1, 2))
    if finite.any():
        left, _, right = np.linalg.svd(matrices[finite])
        result[finite] = np.stack([left[:, :, -1], right[:, -1]], axis=1)
    return result


def _null_vectors(matrices: Array, borders: Array) -> tuple[Array, Array, Array]:
    """Solve the bordered systems: right and left vectors, shape (m, n), and g, shape (m,)."""
    m, n, _ = matrices.shape
    bordered = np.zeros((m, n + 1, n + 1))
    bordered[:, :n, :n] = matrices
    bordered[:, :n, n] = borders[:, 0]
    bordered[:, n, :n] = borders[:, 1]
    unit = np.zeros((m, n + 1))
    unit[:, n] = 1.0
    right = _solve(bordered, unit)
    left = _solve(bordered.swapaxes(1, 2), unit)
    return right[:, :n], left[:, :n], right[:, n]


def _solve(matrices: Array, right: Array) -> Array:
    """Solve linear systems, shapes (m, n, n) and (m, n); NaN where one has no solution."""
    try:
        return np.asarray(np.linalg.solve(matrices, right[:, :, None])[:, :, 0], dtype=float)
    except np.linalg.LinAlgError:
        # One singular matrix makes all of them fail: find out which.
        if len(matrices) == 1:
            return np.full_like(right, np.nan)
        half = len(matrices) // 2
        parts = [_solve(matrices[part], right[part]) for part in (slice(half), slice(half, None))]
        return np.concatenate(parts)
