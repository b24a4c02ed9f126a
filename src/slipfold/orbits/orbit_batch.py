"""Forced orbits of one period computed together, each with its own parameters.

An unknown is that of `ForcedOrbits`: the scaled states at the nodes, then the parameter. Segments
of all orbits share the lanes of one integration.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Indices
from slipfold.continuation.interpolation import lengths_of
from slipfold.continuation.newton import NEWTON
from slipfold.flow import batches
from slipfold.flow.equations import power_of_two
from slipfold.flow.explicit_steps import EXPLICIT, LinearizedSteps, PropagatedStates
from slipfold.flow.flow import flow_of
from slipfold.models.angles import wrap_angles
from slipfold.models.model import Model
from slipfold.newton import Rule, correct_many, solve_each
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.kinds import ForcedOrbits, orbits_at
from slipfold.orbits.limits import far_above, many_margins
from slipfold.orbits.linearization import Linearization, product_of
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.shooting import SEGMENTS
from slipfold.orbits.test_functions import ORBIT_TESTS, evaluate_each, floquet_multipliers

TESTS = (*ORBIT_TESTS, "LP")
"""Test functions of an orbit, in their order; the last is the tangent along the parameter."""

ITERATIONS = 6

EXACTLY = batches.TOLERANCE
"""Error of a step of the flow itself; a larger one may be made by explicit steps."""

NEARLY = 2 * EXACTLY
"""Error of explicit steps that give derivatives as exactly as the flow, in half the time."""

TOGETHER = 512
"""Orbits whose limits are examined together: enough to hide the cost of a call, few enough for the
processor's cache."""


@dataclass(frozen=True, eq=False)
class Seen:
    """What was seen of the outputs that limits watch, each of shape (k, n_limits)."""

    lowest: Array  # smallest values
    highest: Array  # largest values
    above: Array  # lower bounds of what they may be

    def clear(self, bounds: Array) -> NDArray[np.bool_]:
        """Return whether orbits stay far from all limits, as far as was looked, shape (k,).

        Shapes: bounds (n_limits,).
        """
        with np.errstate(invalid="ignore"):
            far = self.above > far_above(bounds, self.highest - self.lowest)
        return np.asarray(far.all(axis=1))


@dataclass(frozen=True, eq=False)
class Part:
    """Mismatches with their derivatives, in scaled variables, and what was seen of the limits."""

    missed: Array  # over the square root of m, shape (k, m, n)
    blocks: Array  # transition matrices, shape (k, m, n, n)
    along: Array  # derivatives by the parameter, shape (k, m, n)
    seen: Seen

    @staticmethod
    def unknown(k: int, m: int, n: int, limits: int) -> Part:
        """Return what holds those of k orbits, all NaN."""
        states, seen = np.full((2, k, m, n), np.nan), np.full((3, k, limits), np.nan)
        return Part(states[0], np.full((k, m, n, n), np.nan), states[1], Seen(*seen))

    @property
    def arrays(self) -> tuple[Array, ...]:
        """All that is known of them."""
        seen = self.seen.lowest, self.seen.highest, self.seen.above
        return self.missed, self.blocks, self.along, *seen


@dataclass(frozen=True, eq=False)
class Solutions:
    """Orbits with their Floquet multipliers and test functions; NaN of those that are not known."""

    z: Array  # unknowns, shape (k, u)
    tangents: Array  # unit vectors along the rows of the hyperplanes, shape (k, u)
    monodromies: Array  # in scaled states, shape (k, n, n)

    @cached_property
    def found(self) -> NDArray[np.bool_]:
        """Whether each is known, shape (k,)."""
        known = np.isfinite(self.z).all(axis=1)
        return np.asarray(known & np.isfinite(self.monodromies).all(axis=(1, 2)))

    @cached_property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers, shape (k, n)."""
        result = np.full(self.monodromies.shape[:2], complex(np.nan, np.nan))
        result[self.found] = floquet_multipliers(self.monodromies[self.found])
        return result

    @cached_property
    def tests(self) -> Array:
        """Test functions, shape (k, len(TESTS))."""
        result = np.full((len(self.z), len(TESTS)), np.nan)
        result[self.found, :-1] = evaluate_each(self.multipliers[self.found], TESTS[:-1])
        result[self.found, -1] = self.tangents[self.found, -1]
        return result

    def derivatives(self, row: int) -> Linearization | None:
        """Return the derivatives at one of them; None where they are not known."""
        return None

    def point(self, row: int, orbits: Orbits, arclength: float, residual: float) -> OrbitPoint:
        """Return one of them as a point of a branch."""
        place, known = (self.z[row], self.tangents[row], arclength), self.derivatives(row)
        tests = dict(zip(TESTS, self.tests[row].tolist(), strict=True))
        rest = {"monodromy": self.monodromies[row], "multipliers": self.multipliers[row]}
        return OrbitPoint(*place, tests, 0, residual, curve=orbits, linearization=known, **rest)


@dataclass(frozen=True, eq=False)
class Corrected(Solutions):
    """Orbits from Newton's method; NaN where it failed.

    Derivatives are those before the last correction.
    """

    part: Part
    condensed: Array  # equations of first node and parameter alone, shape (k, n + 1, n + 1)
    moved: Array  # length of the last correction, infinite where there was none, shape (k,)

    @property
    def seen(self) -> Seen:
        """What was seen of the limits."""
        return self.part.seen

    def derivatives(self, row: int) -> Linearization:
        """Return the derivatives at one of them."""
        part = self.part
        missed = part.missed[row] * np.sqrt(len(part.missed[row]))
        return Linearization(missed, part.blocks[row], part.along[row, ..., None])

    @cached_property
    def signs(self) -> Array:
        """Signs of the bordered determinants but for a factor common to all, shape (k,)."""
        signs = np.zeros(len(self.z))
        signs[self.found] = np.linalg.slogdet(self.condensed[self.found])[0]
        return signs

    @cached_property
    def stiffness(self) -> Array:
        """Largest entry of the inverse of each condensed matrix, shape (k,)."""
        result = np.zeros(len(self.z))
        matrices = self.condensed[self.found]
        inverse = solve_each(matrices, np.broadcast_to(np.eye(matrices.shape[1]), matrices.shape))
        result[self.found] = np.abs(inverse).max(axis=(1, 2))
        return result


@dataclass(frozen=True, eq=False)
class Converged(Solutions):
    """Orbits that meet their equations by the flow itself."""

    residuals: Array  # by how much orbits fail to close, in scaled states, shape (k,)

    def of(self, some: slice) -> Converged:
        """Return some of them, with what follows from the monodromies of all."""
        parts = self.z, self.tangents, self.monodromies, self.residuals
        result = Converged(*(part[some] for part in parts))
        vars(result).update(multipliers=self.multipliers[some], tests=self.tests[some])
        return result

    def joined(self, others: Converged, before: Indices) -> Converged:
        """Return them with others, each before the orbit of a number."""
        names = "z", "tangents", "monodromies", "residuals"
        pairs = ((getattr(self, name), getattr(others, name)) for name in names)
        return Converged(*(np.insert(own, before, more, axis=0) for own, more in pairs))


class OrbitBatch:
    """Orbits of a period of models of one kind, in one parameter.

    What is done to some of them takes their numbers first: rows of `parameters` and `scales`, each
    as often as there are orbits with it. `steps` are used where they are precise enough; None
    leaves everything to the flow. Of each, `scales` has those of residuals and of steps.

    Shapes: parameters (k, n_p); scales (k, 2, n).
    """

    def __init__(
        self,
        model: Model,
        parameters: Array,
        scales: Array,
        vary: tuple[str, float],
        period: int = 1,
        nodes: int = SEGMENTS,
        steps: LinearizedSteps | None = None,
        phase: float = 0.0,
    ) -> None:
        self.model, self.parameters, self._both = model, parameters, scales
        self.sizes, self.scales = scales[:, 0], scales[:, 1]
        self.vary, self.width = vary
        self.period, self.nodes, self.steps = period, nodes, steps
        self.flow = flow_of(model)
        self._index = model.parameter_index(self.vary)
        self.size = self.scales.shape[1] * nodes
        self._node_scales = np.tile(self.scales, nodes) * np.sqrt(nodes)
        self._length = period / nodes
        self._start = phase + np.arange(nodes) * self._length

    @staticmethod
    def of_branches(branches: Sequence[Orbits]) -> OrbitBatch:
        """Return the orbits of branches that are alike, each with its parameters in a row."""
        first = branches[0]
        parameters = np.array([orbits.model.vector for orbits in branches])
        scales = np.array([[orbits.by.sizes, orbits.scales] for orbits in branches])
        given = first.model, parameters, scales, (first.vary, first.width)
        return OrbitBatch(*given, first.period, first.segments, phase=first.phase)

    def of_period(self, period: int) -> OrbitBatch:
        """Return the same for orbits of another period."""
        given = self.model, self.parameters, self._both, (self.vary, self.width)
        return OrbitBatch(*given, period, self.nodes, self.steps)

    def rows(self, some: Indices) -> OrbitBatch:
        """Return the same for some rows of the parameters alone."""
        given = self.model, self.parameters[some], self._both[some], (self.vary, self.width)
        return OrbitBatch(*given, self.period, self.nodes, self.steps)

    def join(self, some: Indices, nodes: Array, values: Array) -> Array:
        """Scale nodes and values of the parameter into unknowns. Shapes: nodes (k, m, n)."""
        scaled = nodes.reshape(len(nodes), self.size) / self._node_scales[some]
        return np.column_stack([scaled, values / self.width])

    def states(self, some: Indices, z: Array) -> Array:
        """Return the states at the nodes of each, shape (k, m, n). Shapes: z (k, u)."""
        nodes = z[:, :-1] * self._node_scales[some]
        return np.asarray(nodes.reshape(len(some), self.nodes, -1))

    def values(self, some: Indices, z: Array) -> Array:
        """Return all parameters of each, shape (k, n_p). Shapes: z (k, u)."""
        parameters = self.parameters[some]
        parameters[:, self._index] = z[:, -1] * self.width
        return parameters

    def correct(
        self,
        some: Indices,
        guesses: Array,
        rows: Array,
        close: float,
        longest: float,
        tolerance: float = EXPLICIT.tolerance,
    ) -> Corrected:
        """Find the orbits nearest guesses, each in the hyperplane through it.

        Derivatives are those at the last step but one: they are of the orbit once that is shorter
        than `close`. What is farther than `longest` is another orbit. A step in time may make an
        error of the tolerance.

        Shapes: guesses, rows (k, u).
        """
        k, n, u = len(some), self.scales.shape[1], guesses.shape[1]
        tangents, condensed = np.full((k, u), np.nan), np.full((k, n + 1, n + 1), np.nan)
        known, moved = Part.unknown(k, self.nodes, n, self._limits), np.full(k, np.inf)

        def steps(here: Indices, z: Array) -> Array:
            part = self.linearize(some[here], z, tolerance)
            right = np.einsum("ka,ka->k", rows[here], guesses[here] - z)
            step, tangents[here], condensed[here] = self.solve(part, rows[here], right)
            for whole, own in zip(known.arrays, part.arrays, strict=True):
                whole[here] = own
            moved[here] = np.sqrt((step * step).sum(axis=1))
            return step

        rule = Rule(close, longest, growth=2.0, iterations=ITERATIONS)
        z = correct_many(steps, guesses, rule).z
        z[~np.isfinite(condensed).all(axis=(1, 2))] = np.nan
        lost = ~np.isfinite(z).all(axis=1)
        for item in (tangents, *known.arrays):
            item[lost] = np.nan
        moved[np.isnan(moved)] = np.inf
        monodromies = condensed[:, :n, :n] + np.eye(n)
        return Corrected(z, tangents, monodromies, known, condensed, moved)

    def settled(self, some: Indices, z: Array, rows: Array, tolerance: float) -> Converged:
        """Correct orbits that are nearly met until they fail by a tenth of what they may.

        Shapes: z, rows (k, u).
        """
        (k, u), n = z.shape, self.scales.shape[1]
        found = Converged(z.copy(), np.empty((k, u)), np.empty((k, n, n)), np.empty(k))
        going = np.arange(k)
        errors = [EXPLICIT.tolerance, NEARLY, NEARLY] if self.steps is not None else []
        for error in (errors + [EXACTLY] * ITERATIONS)[:ITERATIONS]:
            own, at = some[going], found.z[going]
            part = self.linearize(own, at, error)
            missed = self.misses(own, part.missed)
            close = np.flatnonzero((missed <= 0.1 * tolerance) & (error == NEARLY))
            # The flow itself decides whether orbits close, and by how much those fail that do not.
            part.missed[close] = self.gaps(own[close], at[close])
            missed[close] = self.misses(own[close], part.missed[close])
            step, tangents, condensed = self.solve(part, rows[going], np.zeros(len(going)))
            near = close[~(missed[close] <= 0.1 * tolerance)]
            # Of an orbit that moves so little, derivatives are those before it.
            growth = np.abs(condensed[near, :n, :n]).max(axis=(1, 2))
            near = near[lengths_of(step[near]) * growth <= NEWTON.still]
            at[near] += np.nan_to_num(step[near])
            missed[near], step[near] = self.residuals(own[near], at[near]), 0.0
            found.z[going], found.tangents[going], found.residuals[going] = at, tangents, missed
            found.monodromies[going] = condensed[:, :n, :n] + np.eye(n)
            far = ~(missed <= 0.1 * tolerance) | (error > NEARLY)
            going = going[far]
            if not len(going):
                break
            found.z[going] += np.nan_to_num(step[far])  # where explicit steps do not arrive
        found.residuals[going] = np.inf  # of the orbit before its last correction
        return found

    def shifted(self, z: Array, tangents: Array) -> tuple[OrbitBatch, Array, Array]:
        """Return the same with segments that begin in the middle of these: steps fall elsewhere.

        Also an orbit and a direction of each row. Shapes: z, tangents (k, u).
        """
        some, other, half = np.arange(len(z)), copy(self), self._length / 2
        other._start = self._start + half
        nodes, along = self.states(some, z), self.states(some, tangents)
        values, rates = z[:, -1] * self.width, tangents[:, -1] * self.width
        found = self._propagated(nodes, self.values(some, z), self.sizes, EXACTLY, half)
        moved = (found.matrices @ along.reshape(-1, along.shape[2], 1))[..., 0]
        moved += found.vectors * np.repeat(rates, self.nodes)[:, None]
        rows = self.join(some, moved.reshape(nodes.shape), rates)
        rows /= np.linalg.norm(rows, axis=1)[:, None]
        return other, self.join(some, found.ends.reshape(nodes.shape), values), rows

    def multipliers(self, some: Indices, z: Array) -> NDArray[np.complex128]:
        """Return the Floquet multipliers by the flow, NaN where not known. Shapes: z (k, u)."""
        matrices = product_of(self.linearize(some, z, EXACTLY).blocks)
        return Solutions(z, z, matrices).multipliers

    def margins(self, some: Indices, z: Array) -> Array:
        """Return by how much orbits keep each limit, NaN where one is not known.

        Shapes: z (k, u); returns (k, n_limits).
        """
        limits = self.model.limits
        found = np.full((len(some), len(limits)), np.nan)
        known = np.flatnonzero(np.isfinite(z).all(axis=1))
        for first in range(0, len(known) if limits else 0, TOGETHER):
            rows = known[first : first + TOGETHER]
            own = some[rows]
            scales = power_of_two(self.sizes[own])
            constants = self.flow.constants(self.values(own, z[rows]), scales)
            states = self.states(own, z[rows])
            found[rows] = many_margins(self.flow, constants, limits, states, self.period)[0]
        return found

    def misses(self, some: Indices, missed: Array) -> Array:
        """Return the largest mismatch of each, in the scales of residuals, shape (k,).

        Shapes: missed (k, m, n).
        """
        finer = (self.scales / self.sizes)[some, None] * np.sqrt(self.nodes)
        return np.asarray((np.abs(missed) * finer).max(axis=(1, 2)))

    def residuals(self, some: Indices, z: Array) -> Array:
        """Return by how much orbits fail to close by the flow, in scaled states, shape (k,)."""
        return self.misses(some, self.gaps(some, z))

    def gaps(self, some: Indices, z: Array) -> Array:
        """Return the mismatches by the flow, as in `Part`, shape (k, m, n). Shapes: z (k, u)."""
        if not len(some):
            return np.empty((0, self.nodes, self.scales.shape[1]))
        nodes = self.states(some, z)
        constants = self.flow.constants(self.values(some, z), power_of_two(self.sizes[some]))
        start = np.tile(self._start, len(some))
        flat = nodes.reshape(len(start), -1)
        each = constants.repeated(self.nodes)
        ends = self.flow.advance(flat, start, start + self._length, each).reshape(nodes.shape)
        return self._missed(some, ends, nodes)

    def _missed(self, some: Indices, ends: Array, nodes: Array) -> Array:
        gaps = wrap_angles(ends - np.roll(nodes, -1, axis=1), self.model.angle_periods)
        return np.asarray(gaps / self.scales[some, None] / np.sqrt(self.nodes))

    def linearize(self, some: Indices, z: Array, tolerance: float = EXPLICIT.tolerance) -> Part:
        """Return by how much nodes are missed, with derivatives. Shapes: z (k, u)."""
        k, m, n = len(some), self.nodes, self.scales.shape[1]
        nodes, scales = self.states(some, z), self.scales[some]
        given = nodes, self.values(some, z), self.sizes[some]
        propagated = self._propagated(*given, tolerance, self._length)
        wide, root = scales[:, None, :], np.sqrt(m)
        watched = (k, m, self._limits)
        return Part(
            self._missed(some, propagated.ends.reshape(k, m, n), nodes),
            propagated.matrices.reshape(k, m, n, n) * (wide[..., None, :] / wide[..., :, None]),
            propagated.vectors.reshape(k, m, n) * (self.width / root) / wide,
            Seen(
                propagated.lowest.reshape(watched).min(axis=1),
                propagated.highest.reshape(watched).max(axis=1),
                propagated.above.reshape(watched).min(axis=1),
            ),
        )

    @property
    def _limits(self) -> int:
        return len(self.model.limits)

    def _propagated(
        self, nodes: Array, parameters: Array, scales: Array, tolerance: float, length: float
    ) -> PropagatedStates:
        """Integrate so much of all segments: in explicit steps, or by the flow."""
        (k, m, n), quick = nodes.shape, self.steps is not None and tolerance > EXACTLY
        constants = self.flow.constants(parameters, None if quick else power_of_two(scales))
        # The same segment of all orbits in one batch: lanes take about as many steps each.
        order = np.arange(k * m).reshape(k, m).T.ravel()
        which, back = order // m, order.argsort()
        flat, start = nodes.reshape(k * m, n)[order], self._start[order % m]
        change = constants.rates[which, :, self._index]
        if quick:
            assert self.steps is not None
            given = flat, start, length, constants.values[which], scales[which], change
            found = self.steps.propagate(*given, tolerance)
        else:
            ends, matrices, vectors = self.flow.linearize(
                flat, start, start + length, constants.rows(which), change[..., None]
            )
            unseen = np.full((k * m, self._limits), -np.inf)  # limits are not examined
            found = PropagatedStates(ends, matrices, vectors[..., 0], unseen, -unseen, unseen)
        return PropagatedStates(*(part[back] for part in found))

    def solve(self, part: Part, rows: Array, right: Array) -> tuple[Array, Array, Array]:
        """Return Newton's steps, unit tangents, and the equations for the first node alone.

        The other nodes are eliminated in turn: each is a linear function of the first
        node, the parameter, and one, in columns.

        Shapes: rows (k, u); right (k,).
        """
        k, m, n = part.missed.shape
        nodes = np.zeros((k, m + 1, n, n + 2))
        nodes[:, 0, :, :n] = np.eye(n)
        added = np.stack([part.along, part.missed], axis=-1)
        for j in range(m):
            np.matmul(part.blocks[:, j], nodes[:, j], out=nodes[:, j + 1])
            nodes[:, j + 1, :, n:] += added[:, j]
        inner, last = nodes[:, :m].reshape(k, m * n, n + 2), nodes[:, m]
        bordered = (rows[:, None, :-1] @ inner)[:, 0]
        condensed = np.empty((k, n + 1, n + 1))
        condensed[:, :n] = last[..., : n + 1]
        condensed[:, :n, :n] -= np.eye(n)
        condensed[:, n] = bordered[:, : n + 1]
        condensed[:, n, n] += rows[:, -1]
        sides = np.zeros((k, n + 1, 2))
        sides[:, :n, 0] = -last[..., n + 1]
        sides[:, n, 0] = right - bordered[:, n + 1]
        sides[:, n, 1] = 1.0
        first = solve_each(condensed, sides)
        moved = inner[..., : n + 1] @ first
        step = np.column_stack([moved[..., 0] + inner[..., n + 1], first[:, n, 0]])
        tangent = np.column_stack([moved[..., 1], first[:, n, 1]])
        tangent /= np.sqrt((tangent * tangent).sum(axis=1))[:, None]
        return step, tangent, condensed


def correct_orbits(
    orbits: ForcedOrbits, guesses: Array, rows: Array, close: float = 1e-6
) -> Corrected:
    """Find the orbits of one branch nearest guesses by the flow, each in the hyperplane through it.

    A correction shorter than `close` is the last: Newton's method squares it.
    Shapes: guesses, rows (k, m n + 1).
    """
    some = np.zeros(len(guesses), dtype=np.int64)
    batch = OrbitBatch.of_branches([orbits])
    return batch.correct(some, guesses, rows, close, 0.5)


def orbits_from(model: Model, period: int, states: Array) -> list[Array | None]:
    """Return the nodes of the stable orbits of a period that states nearly repeat on.

    Shapes: states (k, n); returns k times (m, n), None where there is none.
    """
    orbits = orbits_at(model, period)
    assert isinstance(orbits, ForcedOrbits)
    zero = np.zeros(len(states))
    constants = orbits.flow.constants_of(model)
    nodes = orbits.flow.sample(states, zero, zero + period, orbits.segments, constants)
    found: list[Array | None] = [None] * len(states)
    passed = np.flatnonzero(np.isfinite(nodes).all(axis=(1, 2)))
    if not len(passed):
        return found
    guesses = np.array([orbits.unknown(item, model) for item in nodes[passed]])
    rows = np.tile(hold_parameter(orbits.size), (len(passed), 1))
    corrected = correct_orbits(orbits, guesses, rows)
    for i, k in enumerate(passed):
        if corrected.found[i] and np.abs(corrected.multipliers[i]).max() < 1:
            found[k] = orbits.nodes(corrected.z[i])
    return found
