"""Forced orbits of one period, one of each of k cases: their equations, solved side by side.

Unknowns mean what they mean in `ForcedOrbits`: the scaled states at the nodes, then the parameter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.newton import Rule, correct_many, solve_each
from slipfold.flow import flow_of, precision
from slipfold.flow.scaled import power_of_two
from slipfold.flow.strobes.linearised_steps import TOLERANCE, LinearisedSteps
from slipfold.models.model import Model
from slipfold.orbits.discretisations.shooting import SEGMENTS
from slipfold.orbits.limits import margins_each
from slipfold.orbits.spectrum.floquet import floquet_multipliers
from slipfold.orbits.spectrum.test_functions import evaluate_each

__all__ = ["ITERATIONS", "TESTS", "Corrected", "OrbitsOfCases", "Settled"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TESTS = ("PD", "fold", "NS", "LP")
"""Test functions of an orbit, in their order; the last is the tangent along the parameter."""

ITERATIONS = 6

EXACTLY = precision.TOLERANCE
"""Error that a step may make where orbits are told: that of the flow."""

GROWTH = 2.0
"""A correction this many times the one before means divergence."""


@dataclass(frozen=True, eq=False)
class Corrected:
    """What Newton's method came to in each of k cases; NaN where it failed."""

    z: Array  # shape (k, u)
    tangents: Array  # unit vectors along the rows of the hyperplanes, shape (k, u)
    blocks: Array  # transition matrices in scaled states, shape (k, m, n, n)
    multipliers: NDArray[np.complex128]  # shape (k, n)
    tests: Array  # shape (k, len(TESTS))
    signs: Array  # of the bordered determinant but for a factor common to all, shape (k,)
    stiffness: Array  # largest entry of the inverse of what is left of the equations, shape (k,)
    lowest: Array  # least value seen of what the limits watch, shape (k, n_limits)
    above: Array  # a bound from below of what it may be, shape (k, n_limits)
    moved: Array  # length of the last correction, infinite where there was none, shape (k,)

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether each was found, shape (k,)."""
        return np.asarray(np.isfinite(self.tests).all(axis=1))


@dataclass(frozen=True, eq=False)
class Settled:
    """Orbits as they are told."""

    z: Array  # shape (k, u)
    tangents: Array  # unit vectors along the rows of the hyperplanes, shape (k, u)
    monodromies: Array  # in scaled states, shape (k, n, n)
    residuals: Array  # by how much orbits fail to close, in scaled states, shape (k,)

    def of(self, some: slice) -> Settled:
        """Return some of them."""
        parts = self.z, self.tangents, self.monodromies, self.residuals
        return Settled(*(part[some] for part in parts))


class OrbitsOfCases:
    """Orbits of a period of k models of one kind, in one parameter."""

    def __init__(
        self, models: Sequence[Model], steps: LinearisedSteps, vary: str, width: float, period: int
    ) -> None:
        self.models, self.vary, self.width, self.period = models, vary, width, period
        self._flow, self._steps = flow_of(models[0]), steps
        self._index = models[0].parameter_index(vary)
        self._parameters = np.array([model.vector for model in models])
        self.scales = np.array([model.state_scales() for model in models])
        n = self.scales.shape[1]
        self.nodes = SEGMENTS
        self.size = n * SEGMENTS
        self._node_scales = np.tile(self.scales, SEGMENTS) * np.sqrt(SEGMENTS)
        self._length = period / SEGMENTS
        self._start = np.arange(SEGMENTS) * self._length

    def of_period(self, period: int) -> OrbitsOfCases:
        """Return the same for orbits of another period."""
        return OrbitsOfCases(self.models, self._steps, self.vary, self.width, period)

    def join(self, some: Indices, nodes: Array, values: Array) -> Array:
        """Scale nodes and values of the parameter into unknowns. Shapes: nodes (k, m, n)."""
        scaled = nodes.reshape(len(nodes), -1) / self._node_scales[some]
        return np.column_stack([scaled, values / self.width])

    def correct(
        self,
        some: Indices,
        guesses: Array,
        rows: Array,
        close: float,
        longest: float,
        tolerance: float = TOLERANCE,
    ) -> Corrected:
        """Find the orbits nearest guesses, each in the hyperplane through it.

        Derivatives are those at the last step but one: they are of the orbit once that is shorter
        than `close`. What is farther than `longest` is another orbit. A step in time may make an
        error of the tolerance.

        Shapes: guesses, rows (k, u).
        """
        k, n, u = len(some), self.scales.shape[1], guesses.shape[1]
        tangents, blocks = np.full((k, u), np.nan), np.full((k, self.nodes, n, n), np.nan)
        condensed = np.full((k, n + 1, n + 1), np.nan)
        lowest, above = np.full((2, k, self._steps.limits), np.nan)
        moved = np.full(k, np.inf)

        def steps(here: Indices, z: Array) -> Array:
            part = self._linearise(some[here], z, tolerance)
            right = np.einsum("ka,ka->k", rows[here], guesses[here] - z)
            step, tangents[here], condensed[here] = self._solve(part, rows[here], right)
            blocks[here], lowest[here], above[here] = part.blocks, part.lowest, part.above
            moved[here] = np.sqrt((step * step).sum(axis=1))
            return step

        rule = Rule(close, longest, GROWTH, iterations=ITERATIONS)
        solved = correct_many(steps, guesses, rule)
        monodromies = condensed[:, :n, :n] + np.eye(n)
        found = solved.found & np.isfinite(monodromies).all(axis=(1, 2))
        signs, stiffness = np.zeros(k), np.zeros(k)
        tests = np.full((k, len(TESTS)), np.nan)
        multipliers = np.full((k, n), complex(np.nan, np.nan))
        if found.any():
            signs[found] = np.linalg.slogdet(condensed[found])[0]
            inverse = solve_each(condensed[found], np.tile(np.eye(n + 1), (found.sum(), 1, 1)))
            stiffness[found] = np.abs(inverse).max(axis=(1, 2))
            multipliers[found] = floquet_multipliers(monodromies[found])
            tests[found, :-1] = evaluate_each(multipliers[found], TESTS[:-1])
            tests[found, -1] = tangents[found, -1]
        for item in (tangents, blocks, lowest, above):
            item[~found] = np.nan
        moved[np.isnan(moved)] = np.inf
        told = tangents, blocks, multipliers, tests, signs, stiffness, lowest, above, moved
        return Corrected(solved.z, *told)

    def margins(self, some: Indices, z: Array) -> Array:
        """Return by how much orbits keep each limit, NaN where one is not known.

        Shapes: z (k, u); returns (k, n_limits).
        """
        limits = self.models[0].limits
        found = np.full((len(some), len(limits)), np.nan)
        known = np.flatnonzero(np.isfinite(z).all(axis=1))
        if limits and len(known):
            some, z = some[known], z[known]
            scales = power_of_two(self.scales[some])
            constants = self._flow.constants(self._values(some, z), scales)
            found[known] = margins_each(
                self._flow, constants, limits, self._nodes(some, z), self.period
            )
        return found

    def settled(self, some: Indices, z: Array, rows: Array, tolerance: float) -> Settled:
        """Correct orbits that are nearly met until they fail by a tenth of what they may.

        Shapes: z, rows (k, u).
        """
        (k, u), n = z.shape, self.scales.shape[1]
        found = Settled(z.copy(), np.full((k, u), np.nan), np.full((k, n, n), np.nan), np.zeros(k))
        going = np.arange(k)
        for count in range(ITERATIONS):
            exactly = EXACTLY if count else TOLERANCE  # what follows a correction decides
            part = self._linearise(some[going], found.z[going], exactly)
            step, tangents, condensed = self._solve(part, rows[going], np.zeros(len(going)))
            missed = np.abs(part.missed).max(axis=(1, 2)) * np.sqrt(self.nodes)
            found.tangents[going], found.residuals[going] = tangents, missed
            found.monodromies[going] = condensed[:, :n, :n] + np.eye(n)
            far = (missed > 0.1 * tolerance) | (count == 0)
            going = going[far]
            if not len(going):
                break
            found.z[going] += step[far]
        found.residuals[going] = np.inf  # of the orbit before its last correction
        return found

    def _values(self, some: Indices, z: Array) -> Array:
        """Return all parameters of each, shape (k, n_p)."""
        parameters = self._parameters[some]
        parameters[:, self._index] = z[:, -1] * self.width
        return parameters

    def _nodes(self, some: Indices, z: Array) -> Array:
        """Return the states at the nodes of each, shape (k, m, n)."""
        nodes = z[:, :-1] * self._node_scales[some]
        return np.asarray(nodes.reshape(len(some), self.nodes, -1))

    def _linearise(self, some: Indices, z: Array, tolerance: float = TOLERANCE) -> _Part:
        """Return by how much nodes are missed, with derivatives, all in scaled variables."""
        k, m, n = len(some), self.nodes, self.scales.shape[1]
        constants = self._flow.constants(self._values(some, z))
        nodes, scales = self._nodes(some, z), self.scales[some]
        carried = self._steps.carry(
            nodes.reshape(k * m, n),
            np.tile(self._start, k),
            self._length,
            np.repeat(constants.values, m, axis=0),
            np.repeat(scales, m, axis=0),
            np.repeat(constants.rates[:, :, self._index], m, axis=0),
            tolerance,
        )
        wide, root = scales[:, None, :], np.sqrt(m)
        missed = (carried.ends.reshape(k, m, n) - np.roll(nodes, -1, axis=1)) / wide / root
        blocks = carried.matrices.reshape(k, m, n, n) * (wide[..., None, :] / wide[..., :, None])
        along = carried.vectors.reshape(k, m, n) * (self.width / root) / wide
        watched = (k, m, self._steps.limits)
        return _Part(
            missed,
            blocks,
            along,
            carried.lowest.reshape(watched).min(axis=1),
            carried.above.reshape(watched).min(axis=1),
        )

    def _solve(self, part: _Part, rows: Array, right: Array) -> tuple[Array, Array, Array]:
        """Return Newton's steps, unit tangents, and the equations for the first node alone.

        The other nodes are eliminated one after the other.
        """
        k, m, n = part.missed.shape
        by_first, alone = np.zeros((k, m + 1, n, n + 1)), np.zeros((k, m + 1, n))
        by_first[:, 0, :, :n] = np.eye(n)
        for j in range(m):
            block = part.blocks[:, j]
            by_first[:, j + 1] = block @ by_first[:, j]
            by_first[:, j + 1, :, n] += part.along[:, j]
            alone[:, j + 1] = (block @ alone[:, j, :, None])[..., 0] + part.missed[:, j]
        by_nodes = by_first[:, :m].reshape(k, m * n, n + 1)
        still = alone[:, :m].reshape(k, m * n)
        condensed = np.empty((k, n + 1, n + 1))
        condensed[:, :n] = by_first[:, m]
        condensed[:, :n, :n] -= np.eye(n)
        condensed[:, n] = (rows[:, None, :-1] @ by_nodes)[:, 0]
        condensed[:, n, n] += rows[:, -1]
        sides = np.zeros((k, n + 1, 2))
        sides[:, :n, 0] = -alone[:, m]
        sides[:, n, 0] = right - (rows[:, None, :-1] @ still[:, :, None])[:, 0, 0]
        sides[:, n, 1] = 1.0
        first = solve_each(condensed, sides)
        carried = by_nodes @ first
        step = np.column_stack([carried[:, :, 0] + still, first[:, n, 0]])
        tangent = np.column_stack([carried[:, :, 1], first[:, n, 1]])
        tangent /= np.sqrt((tangent * tangent).sum(axis=1))[:, None]
        return step, tangent, condensed


@dataclass(frozen=True, eq=False)
class _Part:
    """Mismatches with their derivatives, in scaled variables, and what the limits watch."""

    missed: Array  # over the square root of m, shape (k, m, n)
    blocks: Array  # shape (k, m, n, n)
    along: Array  # shape (k, m, n)
    lowest: Array
    above: Array
