"""Orbits of period 1 and their period doublings, many at once, each with parameters of its own.

Orbits are unknown by their state at phase zero alone (single shooting): what is followed here is
stable or about to lose its stability, so that nothing grows over a period.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.newton import Rule, correct_many, solve_each
from slipfold.flow import Flow
from slipfold.orbits.correct_orbits import transitions
from slipfold.orbits.spectrum.floquet import floquet_multipliers

__all__ = ["Doublings", "Orbits", "find_doublings", "find_orbits"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

NUDGE = 1e-5
"""Distance in scaled states over which monodromy matrices are differenced. The error of the Newton
matrix, 1e-5 relative, costs less than an iteration; the residual has none."""

RENEW = 1e-4
"""After a correction longer than this the test function is differentiated anew."""

DIVERGED = 1.0
"""A correction this long, in scaled states and spans, leads nowhere that is wanted."""

DOUBLING = Rule(close=1e-6, longest=DIVERGED, growth=2.0, remaining=1e-12)
"""The last correction is short, lest the estimate of what remains rest on chance."""


@dataclass(frozen=True, eq=False)
class Orbits:
    """Orbits at given parameters."""

    states: Array  # states at phase zero, shape (m, n); NaN where Newton's method failed
    # Floquet multipliers, complex, shape (m, n), of the orbit before its last correction
    multipliers: NDArray[np.complex128]
    moved: Array  # length of the last correction in scaled states, shape (m,)


@dataclass(frozen=True, eq=False)
class Doublings:
    """Period doublings in one parameter."""

    states: Array  # states at phase zero, shape (m, n)
    values: Array  # values of the parameter, shape (m,)
    multipliers: NDArray[np.complex128]  # Floquet multipliers, complex, shape (m, n)
    residuals: Array  # how far each orbit fails to close, in scaled states, shape (m,)
    failures: NDArray[np.str_]  # why there is no solution, shape (m,); empty where there is one


def find_orbits(
    flow: Flow, states: Array, parameters: Array, scales: Array, close: float
) -> Orbits:
    """Correct guesses to orbits of period 1, until a correction is shorter than `close`.

    Shapes: states (m, n); parameters (m, n_p); scales (m, n).
    """
    monodromies = np.full((*states.shape, states.shape[1]), np.nan)

    def steps(some: Indices, x: Array) -> Array:
        mismatch, matrices, _ = _over_one_period(flow, x, parameters[some], scales[some])
        monodromies[some] = matrices
        return solve_each(matrices - np.eye(x.shape[1]), -mismatch)

    found = correct_many(steps, states / scales, Rule(close, DIVERGED))
    multipliers = np.full(states.shape, complex(np.nan, np.nan))
    multipliers[found.found] = floquet_multipliers(monodromies[found.found])
    return Orbits(found.z * scales, multipliers, found.moved)


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
    guesses = np.column_stack([states / scales, parameters[:, index] / width])
    work = _Doubling(flow, guesses, parameters, index, scales, width)
    found = correct_many(work.steps, guesses, DOUBLING)
    values = found.z[:, -1] * width
    residuals = np.full(len(states), np.inf)
    multipliers = np.full(states.shape, complex(np.nan, np.nan))
    failures, done = found.failures, np.flatnonzero(found.found)
    mismatch, matrices, _ = work.linearise(done, found.z[done])
    residuals[done] = np.abs(mismatch).max(axis=1)
    failures[done[~(residuals[done] <= tolerance)]] = "the orbit does not close"
    closed = failures[done] == ""
    multipliers[done[closed]] = floquet_multipliers(matrices[closed])
    return Doublings(found.z[:, :-1] * scales, values, multipliers, residuals, failures)


class _Doubling:
    """The corrections of `find_doublings`, in scaled variables."""

    def __init__(
        self, flow: Flow, guesses: Array, parameters: Array, index: int, scales: Array, width: float
    ) -> None:
        m, n = scales.shape
        self.flow, self.index, self.scales, self.width = flow, index, scales, width
        self.parameters = parameters
        self.borders = np.full((m, 2, n), np.nan)
        self.slopes = np.full((m, n + 1), np.nan)
        self.before = guesses.copy()

    def steps(self, some: Indices, z: Array) -> Array:
        """Return Newton's steps of some of them."""
        n = self.scales.shape[1]
        mismatch, matrices, along = self.linearise(some, z)
        fresh = np.isnan(self.borders[some, 0, 0])
        self.borders[some[fresh]] = _singular_vectors(matrices[fresh] + np.eye(n))
        q, w, g = _null_vectors(matrices + np.eye(n), self.borders[some])
        moved = np.linalg.norm(z - self.before[some], axis=1)
        self.before[some] = z
        renew = np.flatnonzero(fresh | (moved > RENEW))
        if len(renew):
            nudged = z[renew]
            nudge = NUDGE / np.linalg.norm(q[renew], axis=1)[:, None]
            nudged[:, :n] += nudge * q[renew]
            _, others, beside = self.linearise(some[renew], nudged)
            change = np.concatenate([others - matrices[renew], beside - along[renew]], axis=2)
            slopes = -np.einsum("ma,mab->mb", w[renew], change) / nudge
            self.slopes[some[renew]] = slopes
        jacobian = np.zeros((len(some), n + 1, n + 1))
        jacobian[:, :n, :n] = matrices - np.eye(n)
        jacobian[:, :n, n:] = along
        jacobian[:, n] = self.slopes[some]
        return solve_each(jacobian, -np.column_stack([mismatch, g]))

    def linearise(self, some: Indices, z: Array) -> tuple[Array, Array, Array]:
        """Return mismatch, monodromy matrices and derivatives along the parameter."""
        parameters = self.parameters[some]
        parameters[:, self.index] = z[:, -1] * self.width
        scales, width = self.scales[some], np.array([self.width])
        return _over_one_period(self.flow, z[:, :-1], parameters, scales, [self.index], width)


def _over_one_period(
    flow: Flow,
    x: Array,
    parameters: Array,
    scales: Array,
    free: list[int] | None = None,
    units: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Return how far orbits fail to close, monodromy matrices and derivatives along parameters."""
    nodes = (x * scales)[:, None]
    units = np.empty(0) if units is None else units
    parts = transitions(flow, nodes, parameters, scales, free or [], units)
    mismatch, matrices, along = (part[:, 0] for part in parts)
    return mismatch, matrices, along


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
    right = solve_each(bordered, unit)
    left = solve_each(bordered.swapaxes(1, 2), unit)
    return right[:, :n], left[:, :n], right[:, n]
