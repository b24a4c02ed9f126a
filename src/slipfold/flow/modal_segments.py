"""Trajectories of modes with nonlinear forces, all intervals solved together."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.linalg import solve
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.modal_answers import Some
from slipfold.flow.modal_equations import ForcedIntervals, propagate, times

TINY = 1e-30
"""Imaginary step of dampings: its square is nothing beside one, so that derivatives are exact."""


class SWEEP:
    """When motions at the points are found."""

    close: float = 1e-9  # last change over the size of motions: the next is of its square
    near: float = 1e-7  # the same where nobody asks for derivatives
    early: float = 1e-5  # the same of an orbit that is corrected again
    stalled: float = 1e-6  # change that may be rounding, if it no longer halves
    same: float = 1e-12  # change up to which the linearized equations are those at its end
    iterations: int = 10  # of a guess that is near; afterwards one interval follows another
    within: int = 50  # iterations in an interval
    halvings: int = 8  # of a step in an interval that does not reduce the residual


@dataclass(frozen=True, eq=False)
class ModalSegments:
    """Trajectories over q segments of L intervals, and how they depend on all that is given.

    Interval l of segment j is number ``l q + j``; m = L q.
    """

    intervals: ForcedIntervals
    constants: Constants
    changes: Array  # of coefficients, along which derivatives are taken, shape (n_c, k)
    nodes: Array  # modal states at the ends of intervals, shape (L + 1, q, n)
    motions: Array  # at the points, shape (m, s, n_y)
    forces: Array  # at the points, shape (m, s, n_f)
    sweep: LinearizedSegments  # the linearized equations at these motions
    rough: bool  # whether they are those before the last change, which was not small

    @property
    def ends(self) -> Array:
        """Modal states at the ends of segments, shape (q, n)."""
        return np.asarray(self.nodes[-1])

    @property
    def starts(self) -> Array:
        """Modal states at the beginnings of intervals, shape (m, n)."""
        return self.nodes[:-1].reshape(len(self.motions), -1)

    # -- derivatives ---------------------------------------------------------------------------

    @cached_property
    def _derived(self) -> tuple[Array, Array]:
        """Nodes and motions by the first states, then along the changes of coefficients.

        Shapes: returns (L + 1, q, n, n + k), (m, s n_y, n + k).
        """
        (_, q, n), k = self.nodes.shape, self.changes.shape[1]
        equations, phases = self.intervals.equations, self.intervals.phases
        pushed = equations.parameter_slopes(self.motions, phases, self.constants, self.changes)
        explicit = self._by_coefficients(self.starts, self.forces)
        first = np.broadcast_to(np.eye(n, n + k), (q, n, n + k))
        return self.sweep.run(first, explicit, self._flat(pushed))

    @property
    def moved(self) -> tuple[Array, Array]:
        """Nodes and motions by the first states, (L + 1, q, n, n) and (m, s n_y, n)."""
        nodes, motions = self._derived
        n = nodes.shape[2]
        return nodes[..., :n], motions[..., :n]

    @property
    def along(self) -> tuple[Array, Array]:
        """Nodes and motions along the changes, the first states held.

        Shapes: (L + 1, q, n, k), (m, s n_y, k).
        """
        nodes, motions = self._derived
        n = nodes.shape[2]
        return nodes[..., n:], motions[..., n:]

    def near(self, first: Array, constants: Constants) -> Array:
        """Return motions from other first states and coefficients, to first order, (m, s, n_y).

        Shapes: first (q, n).
        """
        count, q = len(self.nodes) - 1, len(first)
        values, changes = constants.values - self.constants.values, self.changes
        by = (values @ changes) / np.maximum((changes * changes).sum(axis=0), TINY)
        steps = np.concatenate([first - self.nodes[0], np.broadcast_to(by, (q, len(by)))], axis=1)
        motions = self._derived[1].reshape(count, q, *self._derived[1].shape[1:])
        return np.asarray(self.motions + times(motions, steps).reshape(self.motions.shape))

    def _by_coefficients(self, states: Array, forces: Array) -> tuple[Array, Array]:
        """Differentiate motions and ends of intervals by coefficients, beginnings and forces held.

        Shapes: states (m, n); forces (m, s, n_f); returns (m, s n_y, k), (m, n, k).
        """
        intervals, changes = self.intervals, self.changes
        parts = intervals.by_period(states, forces)
        at_points, ends = (part[..., None] * changes[-1] for part in parts)
        turned = intervals.equations.damping_slopes(changes)
        flat = forces.reshape(len(forces), -1)
        for column in np.flatnonzero(turned.any(axis=0)):
            dampings = intervals.dampings + 1j * TINY * turned[:, column]
            other = intervals.at(intervals.period, dampings)
            seen = times(other.seen, states) + times(other.answered, flat)
            reached = other.propagated(states[..., None])[..., 0] + times(other.driven, flat)
            at_points[..., column] += seen.imag / TINY
            ends[..., column] += reached.imag / TINY
        return at_points, ends

    def bent(self, vectors: Array) -> tuple[Array, Array]:
        """Return the second derivatives of ends along vectors, (q, n, n) and (q, n, k).

        Shapes: vectors (q, n).
        """
        equations, phases = self.intervals.equations, self.intervals.phases
        states, motions = (part[..., 0] for part in self.sweep.run(vectors[..., None]))
        seen = motions.reshape(self.motions.shape)
        given = self.motions, phases, self.constants
        second, mixed = equations.curvatures(*given, seen, self.changes)
        moved, pulled = self.moved[1], self.along[1]
        by_nodes = self._pushed(second, moved)
        by_changes = self._pushed(second, pulled) + mixed
        forces = np.zeros(self.forces.shape)
        forces[..., : equations.moved] = times(self.sweep.slopes, seen)
        starts = states[:-1].reshape(len(self.motions), -1)
        explicit = self._by_coefficients(starts, forces)
        bent = self.sweep.run(None, None, self._flat(by_nodes))[0][-1]
        return bent, self.sweep.run(None, explicit, self._flat(by_changes))[0][-1]

    def cubes(self, vectors: Array) -> Array:
        """Return the third derivatives of ends along vectors, shape (q, n)."""
        equations, given = self.intervals.equations, (self.intervals.phases, self.constants)
        unchanged, shape = np.zeros((len(self.constants.values), 1)), self.motions.shape
        first = self.sweep.run(vectors[..., None])[1]
        seen = first.reshape(shape)
        second = equations.curvatures(self.motions, *given, seen, unchanged)[0]
        turned = self.sweep.run(None, None, self._flat(self._pushed(second, first)))[1]
        pushed = 3 * self._pushed(second, turned)
        pushed += equations.cubes(self.motions, *given, seen)[..., None]
        return np.asarray(self.sweep.run(None, None, self._flat(pushed))[0][-1, ..., 0])

    def _pushed(self, second: Array, motions: Array) -> Array:
        """Second derivatives of forces times motions. Shapes: (m, s n_y, k) to (m, s, n_l, k)."""
        m, s, count = self.motions.shape
        return np.asarray(second @ motions.reshape(m, s, count, motions.shape[-1]))

    def _flat(self, forces: Array) -> Array:
        """Forces of which some may be left out, at all points, (m, s, n, k) to (m, s n_f, k)."""
        m, s, count, k = forces.shape
        result = np.zeros((m, s, self.forces.shape[2], k))
        result[:, :, :count] = forces
        return result.reshape(m, -1, k)


class LinearizedSegments:
    """Intervals with linearized forces, from the first of each segment to the last.

    `slopes` are those of the forces that depend on motions, shape (m, s, n_l, n_y).
    """

    def __init__(self, intervals: ForcedIntervals, slopes: Array, count: int) -> None:
        self.intervals, self.slopes, self._count = intervals, slopes, count
        coupled = self._by_motions(intervals.answered)
        self._driven = self._by_motions(intervals.driven)
        size, seen = coupled.shape[1], np.real(intervals.seen)
        system = np.eye(size) - coupled
        # Inverted, unless there are many motions: one matrix serves each run
        few = size <= seen.shape[2]
        self._solved = partial(np.matmul, np.linalg.inv(system)) if few else partial(solve, system)
        self._seen = self._solved(seen)

    def _by_motions(self, answers: Some) -> Array:
        """Return answers to forces as those to motions, (m, a, s n_f) to (m, a, s n_y)."""
        (m, s, live, seen), size = self.slopes.shape, answers.shape[1]
        by_point = answers.reshape(m, size, s, self.intervals.equations.forces)[..., :live]
        if live == seen == 1:
            return np.asarray(by_point[..., 0] * self.slopes[:, None, :, 0, 0])
        found = (by_point.swapaxes(1, 2) @ self.slopes).swapaxes(1, 2)
        return np.asarray(found.reshape(m, size, s * seen))

    def run(
        self,
        first: Array | None,
        explicit: tuple[Array, Array] | None = None,
        forces: Array | None = None,
    ) -> tuple[Array, Array]:
        """Return nodes and motions from first states, what is added to intervals, and forces.

        Forces may be fewer columns than first states: they belong to the last.

        Shapes: first (q, n, k); explicit (m, s n_y, f) and (m, n, f); forces (m, s n_f, f);
        returns (L + 1, q, n, k), (m, s n_y, k).
        """
        count, intervals = self._count, self.intervals
        m, size, n = intervals.seen.shape
        q, width = m // count, 0 if forces is None else forces.shape[2]
        at_points: Some = np.zeros((m, size, width))
        ends: Some = np.zeros((m, n, width))
        if forces is not None:
            at_points, ends = intervals.answered @ forces, intervals.driven @ forces
        if explicit is not None:
            at_points, ends = at_points + explicit[0], ends + explicit[1]
        at_points = self._solved(np.real(at_points))
        added = (ends + self._driven @ at_points).reshape(count, q, n, width)
        if first is None:
            first = np.zeros((q, n, width))
        columns = first.shape[-1]
        nodes, motions = np.empty((count + 1, q, n, columns)), np.empty((count, q, size, columns))
        nodes[0] = first
        seen, driven = (
            part.reshape(count, q, *part.shape[1:]) for part in (self._seen, self._driven)
        )
        for step, free in enumerate(intervals.steps(count)):
            np.matmul(seen[step], nodes[step], out=motions[step])
            following = propagate(free, nodes[step])
            following += driven[step] @ motions[step]
            following[..., columns - width :] += added[step]
            nodes[step + 1] = following
        found = motions.reshape(m, size, columns)
        found[..., columns - width :] += at_points
        return nodes, found


def solve_segments(
    intervals: ForcedIntervals,
    constants: Constants,
    changes: Array,
    first: Array,
    motions: Array,
    sizes: Array,
    close: float = SWEEP.close,
) -> ModalSegments | None:
    """Return the trajectories from first states, from a guess of motions; None if none is found.

    A guess that is too far, as over a contact that turns from slip to slip within a short time,
    is replaced by motions found in one interval after another.

    Shapes: changes (n_c, k); first (q, n); motions (m, s, n_y); typical sizes of motions (n_y,).
    """
    given = intervals, constants, changes, first
    found = _swept(given, motions, sizes, close)
    if found is None:
        motions = _marched(intervals, constants, first, sizes)
        found = _swept(given, motions, sizes, close)
    return found


def _swept(
    given: tuple[ForcedIntervals, Constants, Array, Array],
    motions: Array,
    sizes: Array,
    close: float,
) -> ModalSegments | None:
    """Solve all intervals at once: forces are linearized, and one sweep gives the motions."""
    intervals, constants, _, first = given
    equations, phases = intervals.equations, intervals.phases
    count, before = len(phases) // len(first), np.inf
    for _ in range(SWEEP.iterations):
        forces = equations.at(motions, phases, constants)
        slopes = equations.slopes(motions, phases, constants)
        if not (np.isfinite(forces).all() and np.isfinite(slopes).all()):
            return None
        constant = forces.copy()
        constant[..., : equations.moved] -= np.real(times(slopes, motions))
        flat = constant.reshape(len(constant), constant.shape[1] * constant.shape[2], 1)
        try:
            sweep = LinearizedSegments(intervals, slopes, count)
            nodes, found = sweep.run(first[..., None], None, flat)
        except np.linalg.LinAlgError:
            return None
        step = found.reshape(motions.shape) - motions
        change = np.abs(step).max(axis=(0, 1), initial=0.0)
        length = float((change / sizes).max(initial=0.0))
        if not np.isfinite(length):
            return None
        if length < close or (length < SWEEP.stalled and length > 0.5 * before):
            forces[..., : equations.moved] += np.real(times(slopes, step))
            motions = motions + step
            may_be_rough = close > SWEEP.close  # then a change that is not small may be the last
            rough = may_be_rough and length > SWEEP.close
            if length > SWEEP.same and not rough:
                slopes = equations.slopes(motions, phases, constants)
                sweep = LinearizedSegments(intervals, slopes, count)
            return ModalSegments(*given[:3], nodes[..., 0], motions, forces, sweep, rough)
        motions = motions + step
        before = length
    return None


def _marched(intervals: ForcedIntervals, constants: Constants, first: Array, sizes: Array) -> Array:
    """Return motions found in one interval of all segments after another, shape (m, s, n_y)."""
    states, motions = first, np.empty((*intervals.phases.shape, len(sizes)))
    for begin in range(0, len(motions), len(first)):
        some = slice(begin, begin + len(first))
        part = intervals.part(some)
        motions[some] = _within(part, constants, states, sizes)
        forces = part.equations.at(motions[some], part.phases, constants)
        pushed = times(part.driven, forces.reshape(len(states), -1))
        states = np.real(part.propagated(states[..., None])[..., 0] + pushed)
    return motions


def _within(part: ForcedIntervals, constants: Constants, states: Array, sizes: Array) -> Array:
    """Return motions in q intervals by Newton's method, each step reducing the residuals.

    Shapes: states (q, n); returns (q, s, n_y).
    """
    equations, phases, (q, s) = part.equations, part.phases, part.phases.shape
    live = equations.moved
    answered = part.answered.reshape(q, -1, s, equations.forces)[..., :live]
    free = np.real(times(part.seen, states))

    def missed(motions: Array, some: NDArray[np.intp]) -> tuple[Array, Array]:
        forces = equations.at(motions, phases[some], constants).reshape(len(motions), -1)
        found = free[some] + np.real(times(part.answered[some], forces))
        gap = found.reshape(motions.shape) - motions
        return gap, np.sqrt(((gap / sizes) ** 2).sum(axis=(1, 2)))

    motions = np.repeat((states @ equations.rows.T)[:, None], s, axis=1)
    gap, residual = missed(motions, np.arange(q))
    for _ in range(SWEEP.within):
        some = np.flatnonzero(residual > SWEEP.close)
        if not len(some):
            break
        slopes = equations.slopes(motions[some], phases[some], constants)
        coupled = np.einsum("mpsl,msly->mpsy", answered[some], slopes)
        matrices = np.eye(free.shape[1]) - coupled.reshape(len(some), free.shape[1], -1)
        steps = times(np.linalg.pinv(matrices), gap[some].reshape(len(some), -1))
        steps = steps.reshape(len(some), s, -1)
        for halving in range(SWEEP.halvings):
            tried = motions[some] + steps * 0.5**halving
            missing, left = missed(tried, some)
            better = left < (1 - 0.5 ** (halving + 2)) * residual[some]
            at = some[better]
            motions[at], gap[at], residual[at] = tried[better], missing[better], left[better]
            some, steps = some[~better], steps[~better]
            if not len(some):
                break
        else:
            break  # rounding is all that is left
    return motions


def joined(edges: Array, segments: int) -> tuple[Array, Array]:
    """Return beginnings and lengths of intervals in the order of sweeps. Shapes: edges (m + 1,)."""
    order = np.arange(len(edges) - 1).reshape(segments, -1).T.ravel()
    return edges[:-1][order], np.diff(edges)[order]


def in_time(values: Array, segments: int) -> Array:
    """Return values of intervals in the order of time. Shapes: values (m, ...)."""
    shape = values.shape
    apart = values.reshape(len(values) // segments, segments, *shape[1:])
    return np.swapaxes(apart, 0, 1).reshape(shape)
