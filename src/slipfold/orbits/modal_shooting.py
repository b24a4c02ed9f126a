"""Shooting for modes with a few nonlinear forces: what is linear is exact."""

from __future__ import annotations

import math
from collections.abc import Mapping
from copy import copy
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.collocation_points import gauss_points
from slipfold.flow.equations import Constants
from slipfold.flow.modal_equations import ForcedIntervals, modal_equations_of, modes_serve, times
from slipfold.flow.modal_segments import SWEEP, ModalSegments, in_time, joined, solve_segments
from slipfold.models.model import Model
from slipfold.orbits.discretization import Cut
from slipfold.orbits.meshes import FLOOR, MeshDiscretization, repeated, spread, steepness
from slipfold.orbits.shooting import SEGMENTS, Shooting

Places = NDArray[np.intp]


class SHOTS:
    """What meshes of modal shooting are made for."""

    stages: int = 8  # points an interval, at which forces are met
    first: int = 4  # intervals a segment before an orbit is known
    # Errors inside an interval; less at nodes in smooth motion
    error: float = 1e-8  # of what forces do to scaled states
    slopes: float = 1e-6  # of what their slopes do, over their sum: they make multipliers
    near: float = 1e-8  # distance in modal states of an orbit that needs the same mesh
    certain: float = 1e-8  # mismatch from which Newton's method takes another step in any case
    alike: float = 1e-9  # distance of scaled states from symmetric ones: first order suffices
    grid: float = 1e-13  # difference of lengths of intervals that are images
    slack: float = 1.0  # errors up to which a mesh serves
    spare: float = 1.15  # intervals over those that the error needs
    wasteful: float = 2.0  # the same, from which a mesh is made coarser
    parts: int = 12  # segments of a period of many images: beyond, equations of nodes are sparse
    most: int = 400  # intervals a segment: an orbit that needs more is refused
    finer: float = 1.3  # intervals of a second mesh over those of the first
    attempts: int = 8  # meshes until one fits an orbit: each finds what the last was too coarse for
    # Perturbations of forces by fast modes are polynomials as well
    turn: float = 10.0  # radians of a mode in an interval: its multiplier is right to 1e-7
    gone: float = 0.03  # what is left of a mode after a period that needs not be resolved


class ModalShooting(MeshDiscretization, Shooting):
    """Shooting in which modes are exact and forces are polynomials on the intervals of a mesh.

    Each segment has as many intervals. In an interval the forces of contacts and springs meet the
    motions at Gauss points, where modes answer the polynomials in closed form: fast modes need no
    short intervals, and the operations grow with modes and contacts, not with the states' square.

    Of a wave that travels around a cyclic structure only the first part of a period is solved: a
    matrix maps it to the others, which are its `images`.

    `mesh`, shape (m L + 1,), has the edges of all intervals of the period.
    """

    growing, chords, adapts = False, False, True
    undefined = "the motions at contacts were not found on a mesh made for another orbit"

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int = 1,
        segments: int = SEGMENTS,
        *,
        mesh: Array | None = None,
    ) -> None:
        equations = modal_equations_of(model)
        assert equations is not None
        self.equations, self.points = equations, gauss_points(SHOTS.stages)
        if mesh is None:
            each = _repeating(SHOTS.first, segments, period)
            mesh = np.linspace(0.0, period, each * segments + 1)
        self._mesh, own = mesh.copy(), (len(mesh) - 1) // segments
        self._mesh[::own] = np.linspace(0.0, period, segments + 1)
        self.images = self._images(period, segments)
        super().__init__(model, free, period, edges=self._mesh[::own])
        self._intervals: ForcedIntervals | None = None

    def _images(self, period: int, segments: int) -> int:
        """Return the number of parts of a period that are images of the first."""
        symmetry = self.equations.symmetry
        count = 1 if symmetry is None or period > 1 else math.gcd(symmetry[0], segments)
        lengths = np.diff(self._mesh).reshape(count, -1)
        alike = count > 1 and np.ptp(lengths, axis=0).max() < SHOTS.grid
        return count if alike and self.equations.order(self._turn(count)) else 1

    def _turn(self, count: int) -> Array:
        """Return the map of modal motions to those a part of a period later, shape (r, r)."""
        assert self.equations.symmetry is not None
        several, turn = self.equations.symmetry
        return np.linalg.matrix_power(turn, several // count)

    @property
    def mesh(self) -> Array:
        """Edges of the intervals."""
        return self._mesh

    def measure_in(self, scales: Array) -> None:
        """Take scales of the states, shape (n,)."""
        super().measure_in(scales)
        self._latest: ModalSegments | None = None  # of other free parameters, perhaps
        self._part: Self | None = None
        both = np.eye(2)
        # Modal states from scaled ones, and back, shape (n, n)
        self._into = np.kron(both, self.equations.into) * scales
        self._out = np.kron(both, self.equations.shapes) / scales[:, None]
        self._sizes = np.abs(self.equations.rows @ self._into).max(axis=1)

    @property
    def copies(self) -> int:
        """Number of times that the mesh repeats itself in the period."""
        return super().copies * self.images

    def on(self, edges: Array) -> Self:
        """Return the same on another mesh over the whole period. Shapes: edges (m L + 1,)."""
        other = type(self)(self.model, self.free, self.period, self.segments, mesh=edges)
        other.measure_in(self.scales)
        return other

    def with_period(self, period: int) -> Self:
        """Return the same for orbits of another period: the mesh is repeated, or a part taken."""
        segments, rest = divmod(self.segments * period, self.period)
        own = self._mesh[: (len(self._mesh) - 1) // self.period + 1]
        segments, edges = (SEGMENTS * period, None) if rest else (segments, repeated(own, period))
        other = type(self)(self.model, self.free, period, segments, mesh=edges)
        other.measure_in(self.scales)
        return other

    # -- trajectories --------------------------------------------------------------------------

    def _solved(
        self, nodes: Array, constants: Constants, within: float = 0.0, close: float = SWEEP.close
    ) -> ModalSegments | None:
        """Return the trajectories from nodes, or the last ones from nodes as near in each state.

        With a larger `close` they may be rough.

        Shapes: nodes (m, n).
        """
        first, latest = nodes / self.scales @ self._into.T, self._latest
        may_be_rough = close > SWEEP.close  # derivatives of rough ones lag by one change
        if latest is not None and (may_be_rough or not latest.rough):
            values, known = constants.values, latest.constants.values
            apart = np.abs(first - latest.nodes[0]).max()
            if apart <= within and (np.abs(known - values) <= within * np.abs(values)).all():
                return latest
        intervals, changes = self._forced(constants), constants.rates[:, self.indices]
        guesses = [] if latest is None else [latest.near(first, constants)]
        for guess in (*guesses, None):
            motions = self._interpolated(first, intervals.phases) if guess is None else guess
            given = intervals, constants, changes, first, motions, self._sizes
            solved = solve_segments(*given, SWEEP.close if guess is None else close)
            if solved is not None:
                self._latest = solved
                return solved
        return None

    def _forced(self, constants: Constants) -> ForcedIntervals:
        """Return the intervals, those of the last period and dampings if they are the same."""
        period, dampings = constants.period, self.equations.dampings(constants)
        known = self._intervals
        if known is None:
            known = self._between(*joined(self._mesh, self.segments), constants)
        elif known.period != period or not np.array_equal(known.dampings, dampings):
            known = known.at(period, dampings)
        self._intervals = known
        return known

    def _between(self, start: Array, lengths: Array, constants: Constants) -> ForcedIntervals:
        period, dampings = constants.period, self.equations.dampings(constants)
        return ForcedIntervals(self.equations, self.points, start, lengths, period, dampings)

    def _interpolated(self, first: Array, phases: Array) -> Array:
        """Return motions at phases from those at the nodes. Shapes: first (m, n), (q, s)."""
        known = first @ self.equations.rows.T
        closed = np.concatenate([known, known[:1]])
        within = self.phase + (phases - self.phase) % self.period
        found = [np.interp(within, self.edges, column) for column in closed.T]
        return np.stack(found, axis=-1) if found else np.empty((*phases.shape, 0))

    def mismatch(self, nodes: Array, constants: Constants) -> Array:
        """Return by how much segments miss the next node, in scaled states, shape (m, n)."""
        if self._first_of(nodes) is not None:
            return self.transitions(nodes, constants)[0]
        solved = self._solved(nodes, constants)
        return np.full(nodes.shape, np.nan) if solved is None else self._missed(solved, nodes)

    def _missed(self, solved: ModalSegments, nodes: Array) -> Array:
        return np.asarray(solved.ends @ self._out.T - (nodes / self.scales)[self._following])

    def transitions(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the mismatch and the derivatives of the segments' ends, all in scaled states."""
        first = self._first_of(nodes)
        by, (m, n) = self if first is None else first[0], nodes.shape
        close = SWEEP.early if first is None else SWEEP.close
        solved = by._solved(nodes[: by.segments], constants, close=close)
        if solved and solved.rough and np.abs(self._missed(solved, nodes)).max() < SHOTS.certain:
            solved = self._solved(nodes, constants)
        if solved is None:
            nothing = np.full((m, n, n + len(self.units)), np.nan)
            return nothing[..., 0], nothing[..., :n], nothing[..., n:]
        blocks = self._out @ solved.moved[0][-1] @ self._into
        along = self._out @ solved.along[0][-1] * (self.units / np.sqrt(self.segments))
        if first is None:
            return self._missed(solved, nodes), blocks, along
        turns, apart = first[1][:, None], first[2]
        backward = turns[-np.arange(len(turns)) % len(turns)]
        blocks = (turns @ blocks @ backward).reshape(m, n, n)
        ends = times(turns, solved.ends @ self._out.T).reshape(m, n)
        ends += times(blocks, apart)
        mismatch = ends - (nodes / self.scales)[self._following]
        return mismatch, blocks, (turns @ along).reshape(m, n, -1)

    # -- symmetry ------------------------------------------------------------------------------

    def _first_of(self, nodes: Array) -> tuple[Self, Array, Array] | None:
        """Return the first part, the maps to its images, and the distance of nodes from these.

        None of orbits without the symmetry, as beyond a symmetry-breaking bifurcation. Shapes:
        nodes (m, n); returns maps (images, n, n) and distance (m, n), of scaled states.
        """
        if self.images == 1:
            return None
        if self._part is None:
            part, each = copy(self), (len(self._mesh) - 1) // self.segments
            part.images, part._intervals, part._latest = 1, None, None
            part._mesh = self._mesh[: (len(self._mesh) - 1) // self.images + 1]
            part._cut(part._mesh[::each])
            turn = np.kron(np.eye(2), self._turn(self.images))
            powers = [np.linalg.matrix_power(turn, k) for k in range(self.images)]
            self._part, self._turns = part, self._out @ np.array(powers) @ self._into
        scaled = (nodes / self.scales).reshape(self.images, -1, nodes.shape[1])
        apart = scaled - times(self._turns[:, None], scaled[:1])
        if np.abs(apart).max() > SHOTS.alike * max(1.0, np.abs(scaled).max()):
            return None
        return self._part, self._turns, apart.reshape(nodes.shape)

    def curvatures(self, nodes: Array, constants: Constants, vectors: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``blocks @ vectors``, all in scaled states."""
        solved = self._solved(nodes, constants)
        (r, m, n), k = vectors.shape, len(self.units)
        if solved is None:
            return np.full((r, m, n, n), np.nan), np.full((r, m, n, k), np.nan)
        found = [solved.bent(vector @ self._into.T) for vector in vectors]
        bent = [self._out @ by_nodes @ self._into for by_nodes, _ in found]
        return np.array(bent), np.array([self._out @ part for _, part in found]) * self.units

    def cubes(self, nodes: Array, constants: Constants, vectors: Array) -> Array:
        """Return the third derivatives of the segments' ends along vectors, in scaled states."""
        solved = self._solved(nodes, constants)
        if solved is None:
            return np.full(vectors.shape, np.nan)
        return np.array([solved.cubes(one @ self._into.T) @ self._out.T for one in vectors])

    # -- states elsewhere ----------------------------------------------------------------------

    def _ended(
        self, solved: ModalSegments, constants: Constants, phases: Array, close: float = SWEEP.close
    ) -> tuple[Places, Places, ModalSegments | None]:
        """Trajectories from the mesh points before phases: segments, their intervals, and these."""
        within = self.phase + (phases - self.phase) % self.period
        last = len(self._mesh) - 2
        at = np.clip(np.searchsorted(self._mesh, within, "right") - 1, 0, last)
        segment, step = np.divmod(at, (last + 1) // self.segments)
        start, row = self._mesh[at], step * self.segments + segment
        beyond = within - start
        intervals = self._between(start, beyond, constants)
        # Motions at the points, from the polynomials through those of the whole intervals
        places = (beyond / np.diff(self._mesh)[at])[:, None] * self.points.points
        weights = np.polynomial.legendre.legvander(2 * places - 1, SHOTS.stages - 1)
        motions = weights @ self.points.transform @ solved.motions[row]
        first, given = solved.nodes[step, segment], (constants, solved.changes)
        part = solve_segments(intervals, *given, first, motions, self._sizes, close)
        return segment, step, part

    def propagate_to(
        self, nodes: Array, constants: Constants, phases: Array
    ) -> tuple[Places, Array, Array, Array]:
        """Return the states at any phases, from which node each is reached, and derivatives.

        The flow gives them where a mesh is too coarse for these nodes: nobody looks for NaN here.
        """
        solved = self._solved(nodes, constants)
        if solved is None:
            return super().propagate_to(nodes, constants, phases)
        segment, step, part = self._ended(solved, constants, phases)
        if part is None:
            return super().propagate_to(nodes, constants, phases)
        moved, own = part.moved[0][-1], part.along[0][-1]
        before = solved.moved[0][step, segment], solved.along[0][step, segment]
        out, into = self._out * self.scales[:, None], self._into / self.scales
        return (
            segment,
            part.ends @ out.T,
            out @ (moved @ before[0]) @ into,
            out @ (moved @ before[1] + own),
        )

    def states(self, nodes: Array, constants: Constants, phases: Array) -> Array:
        """Return the states at any phases, shape (q, n), if need be by the flow."""
        if np.array_equal(phases, self.start):
            return nodes
        if (first := self._first_of(nodes)) is not None:
            by, turns, _ = first
            which, own = np.divmod((phases - self.phase) % self.period, by.end[-1])
            once, at = np.unique(np.round(own / SHOTS.grid) * SHOTS.grid, return_inverse=True)
            known = by.states(nodes[: by.segments], constants, once)[at] / self.scales
            return times(turns[which.astype(np.intp) % len(turns)], known) * self.scales
        solved = self._solved(nodes, constants)
        part = solved and self._ended(solved, constants, phases, SWEEP.near)[2]
        if part is None:
            return super().states(nodes, constants, phases)
        return np.asarray(part.ends @ self._out.T * self.scales)

    def stage_states(self, nodes: Array, constants: Constants) -> tuple[Array, Array] | None:
        """Return the states at the mesh points, and their phases."""
        if (first := self._first_of(nodes)) is not None:
            found = first[0].stage_states(nodes[: first[0].segments], constants)
            if found is None:
                return None
            turned = times(first[1][:, None], found[0] / self.scales) * self.scales
            return turned.reshape(-1, nodes.shape[1]), self._mesh[:-1]
        solved = self._solved(nodes, constants)
        if solved is None:
            return None
        states = in_time(solved.starts, self.segments) @ self._out.T * self.scales
        return states, self._mesh[:-1]

    def with_other_errors(self, nodes: Array, constants: Constants) -> Self:
        """Return the same on another, finer mesh."""
        count = len(self._mesh) - 1
        each = int(np.ceil(SHOTS.finer * count / self.segments))
        each = _repeating(each, self.segments, self.copies)
        places = np.linspace(0.0, count, each * self.segments + 1)
        return self.on(np.interp(places, np.arange(count + 1), self._mesh))

    # -- the mesh ------------------------------------------------------------------------------

    def better(
        self,
        nodes: Array,
        constants: Constants,
        blocks: Array | None = None,
        tries: int = SHOTS.attempts,
    ) -> Self | None:
        """Return the same on a mesh that fits an orbit better, None if its own serves."""
        first = self._first_of(nodes)
        by = self if first is None else first[0]
        solved = by._solved(nodes[: by.segments], constants, SHOTS.near)
        if solved is None or not tries:
            return None
        order, lengths = SHOTS.stages + 1, np.diff(self._mesh)
        density = np.zeros(len(lengths))
        for rates, error in self._resolved(solved):
            if not rates.size:  # a linear model
                continue
            found = steepness(self._mesh, rates, self.points)
            density = np.maximum(density, found * (self.points.error / error) ** (1 / order))
        errors, turning = (density * lengths) ** order, self._turning(constants)
        pattern, density = self.pattern(density)
        density = np.maximum(density, turning)
        # Nodes stay where they are, so that an unknown means the same on all meshes
        parts = self.segments // math.gcd(self.segments, self.copies)
        needed = (density * np.diff(pattern)).reshape(parts, -1).sum(axis=1)
        most = float(needed.max() + FLOOR * needed.mean()) * self.copies * parts / self.segments
        each = int(np.ceil(min(max(2, SHOTS.spare * most), SHOTS.most)))
        each = _repeating(each, self.segments, self.copies)
        own = len(lengths) // self.segments
        fits = errors.max() <= SHOTS.slack and turning * lengths.max() <= SHOTS.finer
        if fits and own <= SHOTS.wasteful * each:
            return None
        edges = spread(pattern, density, each * self.segments // self.copies, parts)
        other = self.on(repeated(edges, self.copies))
        tries = tries - 1 if own < SHOTS.most else 0
        return other.better(nodes, constants, blocks, tries) or other

    def _turning(self, constants: Constants) -> float:
        """Return how many intervals a unit of phase the modes need that do not decay."""
        left = -self.equations.dampings(constants) * constants.period * self.period / 2
        lasting = self.equations.squares[left > math.log(SHOTS.gone)]
        return float(np.sqrt(lasting.max(initial=0.0))) * constants.period / SHOTS.turn

    def _resolved(self, solved: ModalSegments) -> list[tuple[Array, float]]:
        """Return what meshes resolve, rates of scaled states (M, s, ...), and to what error.

        Forces make the orbit. Their slopes, which are steeper, make multipliers.
        """
        r, moved = len(self.equations.squares), self.equations.moved
        period = solved.constants.period
        pushed = np.abs(self._out[:, r:] @ self.equations.inputs * period).max(axis=0)
        q = len(solved.nodes[0])
        forces, slopes = (in_time(part, q) for part in (solved.forces, solved.sweep.slopes))
        if q < self.segments:  # the others are images of these
            order = self.equations.order(self._turn(self.images))
            assert order is not None
            motions, sources = (np.arange(len(part)) for part in order)
            parts = []
            for _ in range(self.images):
                live = sources[:moved]
                parts.append((forces[..., sources], slopes[..., live[:, None], motions]))
                motions, sources = order[0][motions], order[1][sources]
            forces, slopes = map(np.concatenate, zip(*parts, strict=True))
        slopes = slopes.reshape(*slopes.shape[:2], -1)
        sizes = np.abs(slopes).mean(axis=1).T @ np.diff(self._mesh)
        slopes = slopes / np.where(sizes > 0, sizes, 1.0)
        return [(forces * pushed, SHOTS.error), (slopes, SHOTS.slopes)]


def _repeating(each: int, segments: int, copies: int) -> int:
    """Return at least so many intervals a segment that a mesh may repeat itself."""
    unit = copies // math.gcd(copies, segments)
    return -(-each // unit) * unit


def segments_for(model: Model) -> int:
    """Return the number of segments of an orbit, such that they can be images of each other."""
    equations = modal_equations_of(model)
    if equations is None or equations.symmetry is None:
        return SEGMENTS
    count = max(k for k in range(1, SHOTS.parts + 1) if equations.symmetry[0] % k == 0)
    several = count * -(-SEGMENTS // count)
    return several if several <= SHOTS.parts else count


def shooting_for(model: Model) -> Cut:
    """Return how orbits in slip are cut into segments."""
    return ModalShooting if modes_serve(model) else Shooting
