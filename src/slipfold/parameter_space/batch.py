"""Thresholds of many parameter sets, with a proof that responses are stable below them.

The unknown of an orbit is its state at phase zero. Single shooting suffices: orbits are stable up
to the threshold, so perturbations do not grow over a period.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from slipfold.arrays import Array, Complex, Indices, Mask
from slipfold.bifurcations.branches.batched_walk import BATCH
from slipfold.continuation.interpolation import polynomial_weights
from slipfold.continuation.locate import ZERO
from slipfold.flow.explicit_steps import linearized_steps_along
from slipfold.models.model import Model
from slipfold.newton import Rule, correct_many, solve_each
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.orbit_batch import EXACTLY, Corrected, OrbitBatch
from slipfold.orbits.test_functions import floquet_multipliers


class CORRECTION:
    """Accuracies of thresholds that are computed in batches."""

    # Upper bound of the errors of multipliers over the error of the orbit
    margin: float = 100.0
    # Error of a time step during the approach to a doubling. The flow corrects the result
    nearly: float = 1e-10
    # Distance in scaled states of the finite differences of monodromy matrices. The relative error
    # of the Newton matrix, 1e-4, costs less than an iteration; the residual has no such error
    perturbation: float = 1e-5
    # Length of a correction that changes multipliers by less than 1e-7
    same: float = 1e-9
    # Distance of an orbit from its guess, in scaled states and spans, beyond which it may belong to
    # another branch
    another_branch: float = 0.1


FRACTIONS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Fractions of a path at which the response is known; the last is its end."""


@dataclass(frozen=True, eq=False)
class Paths:
    """Responses from the first value of a parameter to the end of their stable part."""

    ends: Array  # values of the parameter at the end, shape (m,)
    states: Array  # states at phase zero at `FRACTIONS` of the path, shape (m, len(FRACTIONS), n)
    # Whether a path ends at a period doubling, shape (m,); otherwise it ends at the end of the span
    doubles: Mask

    def rows(self, rows: Indices) -> Paths:
        """Return a subset of the paths."""
        return Paths(self.ends[rows], self.states[rows], self.doubles[rows])

    @classmethod
    def joined(cls, parts: Sequence[Paths]) -> Paths:
        """Join several sets of paths."""
        return cls(
            np.concatenate([part.ends for part in parts]),
            np.concatenate([part.states for part in parts]),
            np.concatenate([part.doubles for part in parts]),
        )


def are_stable(multipliers: Complex, moved: Array, doubles: Mask) -> Mask:
    r"""Return which responses are certainly stable before their ends.

    All multipliers must be inside the unit circle, except the one at -1 where a response ends at
    its period doubling. The test functions

    .. math:: \prod (1 + \mu_i), \quad \prod (1 - \mu_i), \quad \prod_{i<j} (1 - \mu_i \mu_j)

    are interpolated between the known orbits. A minimum near zero indicates two zeros. The first
    function vanishes at a period doubling; it is divided by the distance from the end.

    Shapes: multipliers (m, len(FRACTIONS), n); moved (m, len(FRACTIONS)), infinite of orbits that
    were not found; doubles (m,).
    """
    first, second = np.triu_indices(multipliers.shape[2], k=1)
    with np.errstate(invalid="ignore"):
        products = 1 - multipliers[:, :, first] * multipliers[:, :, second]
        flip = (1 + multipliers).prod(axis=2).real
        dips = _dips((1 - multipliers).prod(axis=2).real) | _dips(products.prod(axis=2).real)
        before_end = flip[:, :-1] / (1 - np.array(FRACTIONS[:-1]))
        dips |= np.where(doubles, _dips(before_end), _dips(flip))
        modulus = np.abs(multipliers)
        critical = np.abs(multipliers[doubles, -1] + 1).argmin(axis=1)
        modulus[np.flatnonzero(doubles), -1, critical] = 0.0
        inside = (modulus.max(axis=2) < 1 - CORRECTION.margin * moved).all(axis=1)
    return np.asarray(inside & ~dips)


def _dips(values: Array) -> Mask:
    """Return where polynomials through the values have a minimum near zero, (m, k) to (m,)."""
    known, grid = np.array(FRACTIONS[: values.shape[1]]), np.linspace(0.0, 1.0, 41)
    curve = values @ polynomial_weights(known, grid).T
    return np.asarray(curve.min(axis=1) < ZERO.dip * values[:, [0, -1]].min(axis=1))


APPROACH = Rule(close=1e-6, longest=1.0, growth=2.0, remaining=CORRECTION.nearly)
"""Newton's method with less accurate time steps: it ends within about ten times their error."""

DOUBLING = Rule(close=1e-6, longest=1.0, growth=2.0, remaining=1e-12)
"""Newton's method with the flow. The last correction is short, which makes its error estimate
reliable."""


@dataclass(frozen=True, eq=False)
class StableParts:
    """Stable parts of responses, one row each."""

    # Whether a response is proved to be stable up to the end of its path, shape (m,). Where it is
    # not, the other values have no meaning.
    proved: Mask
    paths: Paths
    multipliers: Complex  # Floquet multipliers at the end, shape (m, n)
    residuals: Array  # how far the orbit there fails to close, in scaled states, shape (m,)


class BatchedThresholds:
    """Thresholds of one parameter, for many sets of the others."""

    def __init__(self, model: Model, vary: str, span: tuple[float, float]) -> None:
        self.model, self.span = model, span
        self._vary = vary, abs(span[1] - span[0])
        self._steps = linearized_steps_along(vary)(model)
        self._bounds = np.array([limit.bound for limit in model.limits])

    def orbits(self, parameters: Array, scales: Array) -> OrbitBatch:
        """Return the orbits of period 1. Shapes: parameters (m, n_p); scales (m, n)."""
        both = np.stack([scales, scales], axis=1)
        return OrbitBatch(self.model, parameters, both, self._vary, nodes=1, steps=self._steps)

    def find(self, parameters: Array, scales: Array, guess: Paths) -> StableParts:
        """Find the stable parts of responses from guesses, and prove their stability.

        A response whose doubling lies beyond the span is stable up to the end of the span.
        Shapes: parameters (m, n_p); scales (m, n).
        """
        orbits, doubles = self.orbits(parameters, scales), guess.doubles.copy()
        ends, states = guess.ends.copy(), guess.states.copy()
        multipliers = np.full(scales.shape, complex(np.nan, np.nan))
        residuals, clear = np.full(len(scales), np.inf), np.zeros(len(scales), bool)
        moved = np.full(len(scales), np.inf)
        rows = np.flatnonzero(doubles)
        if len(rows):
            located = _Doubling(orbits.rows(rows), states[rows, -1], ends[rows])
            fraction = (located.values - self.span[0]) / (self.span[1] - self.span[0])
            with np.errstate(invalid="ignore"):
                off = np.abs(located.values - ends[rows]) / orbits.width
                near = (
                    (located.distance < CORRECTION.another_branch)
                    & (off < CORRECTION.another_branch)
                    & (fraction > 0)
                )
                beyond = near & (fraction > 1)
            ends[rows], moved[rows] = located.values, np.where(near, 0.0, np.inf)
            states[rows, -1], clear[rows] = located.states, located.clear
            multipliers[rows], residuals[rows] = located.multipliers, located.residuals
            later = rows[beyond]
            doubles[later], ends[later] = False, self.span[1]
            fractions = np.array(FRACTIONS) / fraction[beyond, None]
            weights = polynomial_weights(np.array(FRACTIONS), fractions.ravel())
            states[later] = weights.reshape(-1, *weights.shape[1:] * 2) @ guess.states[later]
        rows = np.flatnonzero(~doubles)
        if len(rows):
            batch, every = orbits.rows(rows), np.arange(len(rows))
            result = find_orbits(batch, states[rows, -1], ends[rows])
            states[rows, -1] = batch.states(every, result.z)[:, 0]
            multipliers[rows] = result.multipliers
            moved[rows] = np.maximum(result.moved, BATCH.roughly)
            residuals[rows], clear[rows] = batch.residuals(every, result.z), self._clear(result)
        paths = Paths(ends, states, doubles)
        proved = self._prove(orbits, paths, multipliers, moved, clear)
        return StableParts(proved, paths, multipliers, residuals)

    def _clear(self, result: Corrected) -> Mask:
        return result.found & result.seen.clear(self._bounds)

    def _prove(
        self, orbits: OrbitBatch, paths: Paths, at_end: Array, moved_last: Array, clear_last: Mask
    ) -> Mask:
        """Correct the states at the fractions in place; return which responses are stable there."""
        m, n = orbits.scales.shape
        inner = np.array(FRACTIONS[:-1])
        values = self.span[0] + np.multiply.outer(inner, paths.ends - self.span[0])
        guesses = paths.states[:, :-1].swapaxes(0, 1).reshape(-1, n)
        # Orbits at the same fraction are neighbors, so that all lanes take about as many steps.
        batch = orbits.rows(np.tile(np.arange(m), len(inner)))
        result = find_orbits(batch, guesses, values.ravel())
        states = batch.states(np.arange(len(guesses)), result.z)[:, 0]
        distance = np.linalg.norm((states - guesses) / batch.scales, axis=1)
        with np.errstate(invalid="ignore"):
            states[~(distance < CORRECTION.another_branch)] = np.nan
        shape = (len(inner), m)
        paths.states[:, :-1] = states.reshape(*shape, n).swapaxes(0, 1)
        multipliers = result.multipliers.reshape(*shape, n).swapaxes(0, 1)
        multipliers = np.concatenate([multipliers, at_end[:, None]], axis=1)
        moved = np.maximum(result.moved, BATCH.roughly).reshape(shape).T
        moved = np.column_stack([moved, moved_last])
        moved[~np.isfinite(paths.states).all(axis=2)] = np.inf
        proved = are_stable(multipliers, moved, paths.doubles)
        clear = np.column_stack([self._clear(result).reshape(shape).T, clear_last])
        case, column = np.nonzero(~clear & proved[:, None])
        values = self.span[0] + np.array(FRACTIONS)[column] * (paths.ends[case] - self.span[0])
        z = orbits.join(case, paths.states[case, column][:, None], values)
        proved[case[~(orbits.margins(case, z) > 0).all(axis=1)]] = False
        return proved


def find_orbits(orbits: OrbitBatch, states: Array, values: Array) -> Corrected:
    """Correct guesses to orbits at values of the parameter. Shapes: states (m, n); values (m,)."""
    every = np.arange(len(states))
    normals = np.tile(hold_parameter(orbits.size), (len(states), 1))
    guesses = orbits.join(every, states[:, None], values)
    return orbits.correct(every, guesses, normals, BATCH.close, APPROACH.longest, BATCH.roughly)


class _Doubling:
    r"""Period doublings in one parameter, from guesses.

    The unknowns are the state x at phase zero and the parameter p. The equations are

    .. math:: \phi(x, p) - x = 0, \quad g(x, p) = 0

    where g is the smallest singular value of M + I, with the sign of its determinant, and M is the
    monodromy matrix (Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria,
    section 4). With the singular vectors q and w the derivative of g is that of :math:`w^T M q`. It
    takes one more monodromy matrix, at a state perturbed along q.
    """

    def __init__(self, orbits: OrbitBatch, states: Array, values: Array) -> None:
        (m, n), every = states.shape, np.arange(len(states))
        self._orbits, self._gradients = orbits, np.full((m, n + 1), np.nan)
        self._bounds = np.array([limit.bound for limit in orbits.model.limits])
        self._matrices, self.clear = np.full((m, n, n), np.nan), np.zeros(m, bool)
        near = self._before = orbits.join(every, states[:, None], values)
        if orbits.steps is not None:
            near = correct_many(partial(self._steps, CORRECTION.nearly), near, APPROACH).z
        found = correct_many(partial(self._steps, EXACTLY), near, DOUBLING)
        self.states = orbits.states(every, found.z)[:, 0]
        self.values = found.z[:, -1] * orbits.width
        self.multipliers = np.full(states.shape, complex(np.nan, np.nan))
        self.residuals = np.full(m, np.inf)
        done = np.flatnonzero(found.found)
        if len(done):
            far = done[found.moved[done] > CORRECTION.same]
            if len(far):
                self._matrices[far] = orbits.linearize(far, found.z[far], EXACTLY).blocks[:, 0]
            self.residuals[done] = orbits.residuals(done, found.z[done])
            self.multipliers[done] = floquet_multipliers(self._matrices[done])
        self.distance = np.linalg.norm((self.states - states) / orbits.scales, axis=1)
        self.distance[~(self.residuals <= CORRECTION.nearly)] = np.inf

    def _steps(self, tolerance: float, rows: Indices, z: Array) -> Array:
        """Return the steps of Newton's method."""
        n, part = self._orbits.size, self._orbits.linearize(rows, z, tolerance)
        if tolerance > EXACTLY:  # limits are examined
            self.clear[rows] = part.seen.clear(self._bounds)
        matrices = self._matrices[rows] = part.blocks[:, 0]
        left, values, right = _smallest_singular(matrices + np.eye(n))
        moved = np.linalg.norm(z - self._before[rows], axis=1)
        self._before[rows] = z
        renew = np.flatnonzero(np.isnan(self._gradients[rows, 0]) | (moved > 10 * BATCH.close))
        if len(renew):
            perturbed = z[renew]
            perturbed[:, :n] += CORRECTION.perturbation * right[renew]
            other = self._orbits.linearize(rows[renew], perturbed, tolerance)
            by_states = other.blocks[:, 0] - matrices[renew]
            change = np.concatenate(
                [by_states, (other.along - part.along[renew]).swapaxes(1, 2)], axis=2
            )
            gradients = np.einsum("ma,mab->mb", left[renew], change) / CORRECTION.perturbation
            self._gradients[rows[renew]] = gradients
        jacobian = np.zeros((len(rows), n + 1, n + 1))
        jacobian[:, :n, :n] = matrices - np.eye(n)
        jacobian[:, :n, n] = part.along[:, 0]
        jacobian[:, n] = self._gradients[rows]
        return solve_each(jacobian, -np.column_stack([part.missed[:, 0], values]))


def _smallest_singular(matrices: Array) -> tuple[Array, Array, Array]:
    """Return left singular vectors, smallest singular values and right singular vectors.

    Signs are such that a value has the sign of its determinant. NaN where a matrix is not finite.
    """
    m, n, _ = matrices.shape
    result = np.full((m, n), np.nan), np.full(m, np.nan), np.full((m, n), np.nan)
    finite = np.isfinite(matrices).all(axis=(1, 2))
    if finite.any():
        left, values, right = np.linalg.svd(matrices[finite])
        signs = np.sign(np.linalg.det(left) * np.linalg.det(right))
        result[0][finite] = signs[:, None] * left[:, :, -1]
        result[1][finite], result[2][finite] = signs * values[:, -1], right[:, -1]
    return result
