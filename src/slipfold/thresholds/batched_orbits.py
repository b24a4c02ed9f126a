"""Orbits of period 1 and their period doublings, many at once, each with parameters of its own.

Orbits are unknown by their state at phase zero alone (single shooting): what is followed here is
stable or about to lose its stability, so that nothing grows over a period.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Indices
from slipfold.newton import Rule, correct_many, solve_each
from slipfold.orbits.carry_to import hold_parameter
from slipfold.orbits.orbit_batch import EXACTLY, Corrected, OrbitBatch, Part
from slipfold.orbits.spectrum.floquet import floquet_multipliers

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
class Doublings:
    """Period doublings in one parameter."""

    states: Array  # states at phase zero, shape (m, n)
    values: Array  # values of the parameter, shape (m,)
    multipliers: NDArray[np.complex128]  # Floquet multipliers, complex, shape (m, n)
    residuals: Array  # how far each orbit fails to close, in scaled states, shape (m,)
    failures: NDArray[np.str_]  # why there is no solution, shape (m,); empty where there is one
    clear: NDArray[np.bool_]  # whether each stays far from all limits, as far as was looked


def find_orbits(orbits: OrbitBatch, states: Array, values: Array, close: float) -> Corrected:
    """Correct guesses to orbits at values of the parameter, until a correction is below `close`.

    Shapes: states (m, n); values (m,).
    """
    some = np.arange(len(states))
    guesses = orbits.join(some, states[:, None], values)
    rows = np.tile(hold_parameter(orbits.size), (len(states), 1))
    return orbits.correct(some, guesses, rows, close, DIVERGED, ROUGHLY)


def find_doublings(
    orbits: OrbitBatch, states: Array, values: Array, tolerance: float = 1e-10
) -> Doublings:
    r"""Correct guesses to period doublings in one parameter.

    The unknowns are the state x at phase zero and the parameter p, the equations

    .. math:: \phi(x, p) - x = 0, \quad g(x, p) = 0, \qquad
        \begin{pmatrix} M + I & b \\ c^T & 0 \end{pmatrix}
        \begin{pmatrix} q \\ g \end{pmatrix} = \begin{pmatrix} 0 \\ 1 \end{pmatrix}

    with the monodromy matrix M and borders b, c that are its singular vectors at the guess
    (Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, section 4). The
    derivative of g needs that of M along q alone: one more monodromy matrix, beside the orbit.

    Shapes: states (m, n); values (m,).
    """
    everything = np.arange(len(states))
    guesses = orbits.join(everything, states[:, None], values)
    work = _Doubling(orbits, guesses)
    near, failures = guesses, np.full(len(states), "")
    if orbits.steps is not None:
        approached = correct_many(work.approach, guesses, APPROACH)
        near, failures = approached.z, approached.failures
    found = correct_many(work.steps, near, DOUBLING)
    failures = np.where(failures == "", found.failures, failures)
    ends, values = orbits.states(everything, found.z)[:, 0], found.z[:, -1] * orbits.width
    residuals = np.full(len(states), np.inf)
    multipliers = np.full(states.shape, complex(np.nan, np.nan))
    done = np.flatnonzero(found.found)
    if len(done):
        work.renew_matrices(done[found.moved[done] > SAME], found.z)
        residuals[done] = orbits.residuals(done, found.z[done])
        multipliers[done] = floquet_multipliers(work.matrices[done])
    failures[found.found & ~(residuals <= tolerance)] = "the orbit does not close"
    return Doublings(ends, values, multipliers, residuals, failures, work.clear)


class _Doubling:
    """The corrections of `find_doublings`, in scaled variables.

    `matrices` are the monodromy matrices before the last of them, `clear` is what was seen of
    limits.
    """

    def __init__(self, orbits: OrbitBatch, guesses: Array) -> None:
        m, n = len(guesses), orbits.size
        self.orbits = orbits
        self._bounds = np.array([limit.bound for limit in orbits.model.limits])
        self.matrices, self.clear = np.full((m, n, n), np.nan), np.zeros(m, bool)
        self.borders = np.full((m, 2, n), np.nan)
        self.slopes = np.full((m, n + 1), np.nan)
        self.before = guesses.copy()

    def approach(self, some: Indices, z: Array) -> Array:
        """Return Newton's steps of some of them from quick periods."""
        part = self.nearly(some, z)
        self.clear[some] = part.seen.clear(self._bounds)
        return self._corrections(some, z, part, self.nearly)

    def steps(self, some: Indices, z: Array) -> Array:
        """Return Newton's steps of some of them from exact periods."""
        return self._corrections(some, z, self.exactly(some, z), self.exactly)

    def _corrections(
        self,
        some: Indices,
        z: Array,
        part: Part,
        linearise: Callable[[Indices, Array], Part],
    ) -> Array:
        n = self.orbits.size
        matrices = self.matrices[some] = part.blocks[:, 0]
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
            turned = beside.blocks[:, 0] - matrices[renew], beside.along - part.along[renew]
            change = np.concatenate([turned[0], turned[1].swapaxes(1, 2)], axis=2)
            slopes = -np.einsum("ma,mab->mb", w[renew], change) / nudge
            self.slopes[some[renew]] = slopes
        jacobian = np.zeros((len(some), n + 1, n + 1))
        jacobian[:, :n, :n] = matrices - np.eye(n)
        jacobian[:, :n, n] = part.along[:, 0]
        jacobian[:, n] = self.slopes[some]
        return solve_each(jacobian, -np.column_stack([part.missed[:, 0], g]))

    def renew_matrices(self, some: Indices, z: Array) -> None:
        """Take the monodromy matrices of some of them at solutions, shape (m, n + 1)."""
        if len(some):
            self.matrices[some] = self.exactly(some, z[some]).blocks[:, 0]

    def exactly(self, some: Indices, z: Array) -> Part:
        """Return one period of some of them by the flow."""
        return self.orbits.linearise(some, z, EXACTLY)

    def nearly(self, some: Indices, z: Array) -> Part:
        """Return one period of some of them in steps of a larger error."""
        return self.orbits.linearise(some, z, NEARLY)


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
