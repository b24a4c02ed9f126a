"""Orbits of period 1 and their period doublings, many at once, each with parameters of its own.

Orbits are unknown by their state at phase zero alone (single shooting): what is followed here is
stable or about to lose its stability, so that nothing grows over a period.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.newton import Rule, correct_many, solve_each
from slipfold.orbits.spectrum.floquet import floquet_multipliers
from slipfold.thresholds.one_period import OnePeriod, Passed

__all__ = ["Doublings", "Orbits", "find_doublings", "find_orbits"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

ROUGHLY = 1e-8
"""Error of a step where orbits are looked at whether they are stable, and no more."""

NEARLY = 1e-10
"""Error of a step on the way to a doubling. What is left is one correction by the flow itself."""

NUDGE = 1e-5
"""Distance in scaled states over which monodromy matrices are differenced. The error of the Newton
matrix, 1e-4 relative with the errors of steps, costs less than an iteration; the residual has
none."""

RENEW = 1e-4
"""After a correction longer than this the test function is differentiated anew."""

DIVERGED = 1.0
"""A correction this long, in scaled states and spans, leads nowhere that is wanted."""

APPROACH = Rule(close=1e-6, longest=DIVERGED, growth=2.0, remaining=NEARLY)
"""Steps of a larger error lead as near as that error, or ten times it."""

DOUBLING = Rule(close=1e-6, longest=DIVERGED, growth=2.0, remaining=1e-12)
"""The last correction is short, lest the estimate of what remains rest on chance."""

SAME = 1e-9
"""Multipliers before a correction this short are those after it, to 1e-7."""


@dataclass(frozen=True, eq=False)
class Orbits:
    """Orbits at given parameters."""

    states: Array  # states at phase zero, shape (m, n); NaN where Newton's method failed
    # Floquet multipliers, complex, shape (m, n), of the orbit before its last correction
    multipliers: NDArray[np.complex128]
    # Length of the last correction in scaled states, or the error of steps, shape (m,)
    moved: Array
    clear: NDArray[np.bool_]  # whether each stays far from all limits, as far as was looked


@dataclass(frozen=True, eq=False)
class Doublings:
    """Period doublings in one parameter."""

    states: Array  # states at phase zero, shape (m, n)
    values: Array  # values of the parameter, shape (m,)
    multipliers: NDArray[np.complex128]  # Floquet multipliers, complex, shape (m, n)
    residuals: Array  # how far each orbit fails to close, in scaled states, shape (m,)
    failures: NDArray[np.str_]  # why there is no solution, shape (m,); empty where there is one
    clear: NDArray[np.bool_]  # whether each stays far from all limits, as far as was looked


def find_orbits(
    period: OnePeriod, states: Array, parameters: Array, scales: Array, close: float
) -> Orbits:
    """Correct guesses to orbits of period 1, until a correction is shorter than `close`.

    Shapes: states (m, n); parameters (m, n_p); scales (m, n).
    """
    monodromies = np.full((*states.shape, states.shape[1]), np.nan)
    clear = np.zeros(len(states), bool)

    def steps(some: Indices, x: Array) -> Array:
        passed = period.quick(x, parameters[some], scales[some], ROUGHLY)
        monodromies[some], clear[some] = passed.matrices, passed.clear
        return solve_each(passed.matrices - np.eye(x.shape[1]), -passed.mismatch)

    found = correct_many(steps, states / scales, Rule(close, DIVERGED))
    multipliers = np.full(states.shape, complex(np.nan, np.nan))
    multipliers[found.found] = floquet_multipliers(monodromies[found.found])
    moved = np.maximum(found.moved, ROUGHLY)
    return Orbits(found.z * scales, multipliers, moved, clear & found.found)


def find_doublings(
    period: OnePeriod,
    states: Array,
    parameters: Array,
    scales: Array,
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
    values = parameters[:, period.index] / period.width
    guesses = np.column_stack([states / scales, values])
    work = _Doubling(period, guesses, parameters, scales)
    near, failures = guesses, np.full(len(states), "")
    if period.is_quick:
        approached = correct_many(work.approach, guesses, APPROACH)
        near, failures = approached.z, approached.failures
    found = correct_many(work.steps, near, DOUBLING)
    failures = np.where(failures == "", found.failures, failures)
    ends, values = found.z[:, :-1] * scales, found.z[:, -1] * period.width
    residuals = np.full(len(states), np.inf)
    multipliers = np.full(states.shape, complex(np.nan, np.nan))
    done = np.flatnonzero(found.found)
    if len(done):
        work.renew_matrices(done[found.moved[done] > SAME], found.z)
        at_ends = period.at(parameters[done], values[done])
        residuals[done] = period.residuals(ends[done], at_ends, scales[done])
        multipliers[done] = floquet_multipliers(work.matrices[done])
    failures[found.found & ~(residuals <= tolerance)] = "the orbit does not close"
    return Doublings(ends, values, multipliers, residuals, failures, work.clear)


class _Doubling:
    """The corrections of `find_doublings`, in scaled variables.

    `matrices` are the monodromy matrices before the last of them, `clear` is what was seen of
    limits.
    """

    def __init__(self, period: OnePeriod, guesses: Array, parameters: Array, scales: Array) -> None:
        m, n = scales.shape
        self.period, self.scales = period, scales
        self.parameters = parameters
        self.matrices, self.clear = np.full((m, n, n), np.nan), np.zeros(m, bool)
        self.borders = np.full((m, 2, n), np.nan)
        self.slopes = np.full((m, n + 1), np.nan)
        self.before = guesses.copy()

    def approach(self, some: Indices, z: Array) -> Array:
        """Return Newton's steps of some of them from quick periods."""
        passed = self.nearly(some, z)
        self.clear[some] = passed.clear
        return self._corrections(some, z, passed, self.nearly)

    def steps(self, some: Indices, z: Array) -> Array:
        """Return Newton's steps of some of them from exact periods."""
        return self._corrections(some, z, self.exactly(some, z), self.exactly)

    def _corrections(
        self,
        some: Indices,
        z: Array,
        passed: Passed,
        linearise: Callable[[Indices, Array], Passed],
    ) -> Array:
        n = self.scales.shape[1]
        matrices = self.matrices[some] = passed.matrices
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
            beside = linearise(some[renew], nudged)
            turned = beside.matrices - matrices[renew], beside.along - passed.along[renew]
            change = np.concatenate([turned[0], turned[1][:, :, None]], axis=2)
            slopes = -np.einsum("ma,mab->mb", w[renew], change) / nudge
            self.slopes[some[renew]] = slopes
        jacobian = np.zeros((len(some), n + 1, n + 1))
        jacobian[:, :n, :n] = matrices - np.eye(n)
        jacobian[:, :n, n] = passed.along
        jacobian[:, n] = self.slopes[some]
        return solve_each(jacobian, -np.column_stack([passed.mismatch, g]))

    def renew_matrices(self, some: Indices, z: Array) -> None:
        """Take the monodromy matrices of some of them at solutions, shape (m, n + 1)."""
        if len(some):
            self.matrices[some] = self.exactly(some, z[some]).matrices

    def exactly(self, some: Indices, z: Array) -> Passed:
        """Return one period of some of them by the flow."""
        return self.period.exact(z[:, :-1], self._parameters(some, z), self.scales[some])

    def nearly(self, some: Indices, z: Array) -> Passed:
        """Return one period of some of them in steps of a larger error."""
        return self.period.quick(z[:, :-1], self._parameters(some, z), self.scales[some], NEARLY)

    def _parameters(self, some: Indices, z: Array) -> Array:
        return self.period.at(self.parameters[some], z[:, -1] * self.period.width)


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
