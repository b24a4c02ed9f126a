"""Multiple shooting: orbits cut into segments that are integrated in one batch."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from itertools import accumulate
from typing import Self

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.continuation.newton import SINGULAR
from slipfold.flow.equations import Constants
from slipfold.models.angles import wrap_angles
from slipfold.models.model import Model
from slipfold.orbits.discretization import Discretization
from slipfold.orbits.meshes import INTERVALS, MeshDiscretization, even_mesh, repeated

SEGMENTS = 8
"""Segments an orbit is split into: one SIMD batch, and growth of 500 a period becomes 2.2 each."""

RESOLVED = 1e7
"""Growth of perturbations within a period with which multipliers near the unit circle are still
known to five digits."""

SEGMENT_GROWTH = 1e4
"""Maximum growth in a segment of a mesh; a mesh is made for its fourth root."""


class Shooting(Discretization):
    """The flow over m segments of a period: each has to end where the next begins.

    `phase` is that of the first node.
    """

    undefined = f"{SINGULAR}, or perturbations outgrow all numbers"

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int = 1,
        segments: int = SEGMENTS,
        phase: float = 0.0,
        *,
        edges: Array | None = None,
    ) -> None:
        if edges is None:
            edges = phase + np.arange(segments + 1, dtype=float) * (period / segments)
        super().__init__(model, free, period, edges)

    def with_period(self, period: int) -> Self:
        """Return the same for orbits of another period."""
        return type(self)(self.model, self.free, period, self.segments, self.phase)

    def with_other_errors(self, nodes: Array, constants: Constants) -> Self:
        """Return the same with segments that begin in the middle of these.

        The integrator's steps fall elsewhere.
        """
        other, middles = copy(self), (self.start + self.end) / 2
        other._cut(np.append(middles, middles[0] + self.period))
        return other

    def better(
        self, nodes: Array, constants: Constants, blocks: Array | None = None
    ) -> Shooting | None:
        """Return the same over a mesh where perturbations grow too much for equal segments."""
        grows = blocks is not None and growth_within(blocks) > RESOLVED
        return MeshShooting.with_scales_of(self) if grows else None

    def ends(self, nodes: Array, begin: Array, end: Array, constants: Constants) -> Array:
        """Return where states lead, each from one phase to another, shape (q, n).

        Shapes: nodes (q, n); begin, end (q,).
        """
        return self.flow.advance(nodes, begin, end, constants)

    def propagate(
        self, nodes: Array, begin: Array, end: Array, constants: Constants
    ) -> tuple[Array, Array, Array]:
        """Return the same with the derivatives, nothing scaled.

        Shapes: nodes (q, n); begin, end (q,); returns states (q, n), matrices (q, n, n), vectors
        (q, n, k).
        """
        along = constants.rates[:, self.indices]
        return self.flow.linearize(nodes, begin, end, constants, along)

    def mismatch(self, nodes: Array, constants: Constants) -> Array:
        """Return by how much segments miss the next node, in scaled states, shape (m, n)."""
        return self._gaps(nodes, self.ends(nodes, self.start, self.end, constants))

    def _gaps(self, nodes: Array, ends: Array) -> Array:
        """Return by how much the ends of segments miss the next node, in scaled states."""
        gaps = (ends - nodes[self._following]) / self.scales
        return wrap_angles(gaps, self.angle_periods) if self.revolves else gaps

    def transitions(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the mismatch and the derivatives of the segments' ends, all in scaled states."""
        ends, matrices, vectors = self.propagate(nodes, self.start, self.end, constants)
        units = self.parameter_units / np.sqrt(self.segments)
        return self._gaps(nodes, ends), matrices * self.ratios, vectors * units

    def propagate_to(
        self, nodes: Array, constants: Constants, phases: Array
    ) -> tuple[Indices, Array, Array, Array]:
        """Return the states at any phases, from which node each is reached, and derivatives."""
        which, within = self.before(phases)
        return which, *self.propagate(nodes[which], self.start[which], within, constants)

    def states(self, nodes: Array, constants: Constants, phases: Array) -> Array:
        """Return the states at any phases, shape (q, n)."""
        which, within = self.before(phases)
        return self.ends(nodes[which], self.start[which], within, constants)

    def evenly(self, nodes: Array, constants: Constants, count: int = 0) -> Array:
        """Return the states at equidistant phases from that of the first node, shape (M, n)."""
        each = -(-count // self.segments)
        if each < 2:
            return nodes
        samples = self.flow.sample(nodes, self.start, self.end, each, constants)
        return samples.reshape(each * self.segments, -1)

    def curvatures(self, nodes: Array, constants: Constants, vectors: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``blocks @ vectors``, all in scaled states."""
        r, m, n = vectors.shape
        matrices, by_parameters = self.flow.curve(
            np.tile(nodes, (r, 1)),
            np.tile(self.start, r),
            np.tile(self.end, r),
            constants,
            constants.rates[:, self.indices],
            (vectors * self.scales).reshape(-1, n),
        )
        bent = (matrices * self.ratios).reshape(r, m, n, n)
        by_parameters = (by_parameters * self.parameter_units).reshape(r, m, n, -1)
        return bent, by_parameters

    def cubes(self, nodes: Array, constants: Constants, vectors: Array) -> Array:
        """Return the third derivatives of the segments' ends along vectors, in scaled states."""
        r, m, n = vectors.shape
        jets = self.flow.jet(
            np.tile(nodes, (r, 1)),
            np.tile(self.start, r),
            np.tile(self.end, r),
            constants,
            (vectors * self.scales).reshape(-1, n),
        )
        return (jets[:, 2] / self.scales).reshape(r, m, n)


class MeshShooting(MeshDiscretization, Shooting):
    """Shooting over segments in which perturbations grow little, however much in a whole period.

    Errors are those of the integrator: multipliers keep their digits beside any larger ones.
    `edges`, shape (m + 1,), are a mesh over the whole period; without them it is uniform, of at
    least as many `segments`.
    """

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int = 1,
        segments: int = 0,
        *,
        edges: Array | None = None,
    ) -> None:
        edges = even_mesh(model, period, segments) if edges is None else edges
        super().__init__(model, free, period, edges=edges)

    @classmethod
    def with_scales_of(cls, by: Discretization, edges: Array | None = None) -> Self:
        """Return shooting over a mesh in the scales of another discretization."""
        period = by.period if edges is None else round(edges[-1] - edges[0])
        other = cls(by.model, by.free, period, edges=edges)
        other.measure_in(by.scales)
        return other

    def on(self, edges: Array) -> Self:
        """Return the same on another mesh over the whole period."""
        return self.with_scales_of(self, edges)

    def better(
        self, nodes: Array, constants: Constants, blocks: Array | None = None
    ) -> Self | None:
        """Return the same on a mesh that fits an orbit better, None if its own serves."""
        if blocks is None:
            return None
        growth = np.log(np.maximum(np.linalg.norm(blocks, 2, axis=(1, 2)), 1.0)) / np.log(
            SEGMENT_GROWTH
        )
        if growth.max() <= 1:
            return None
        growth = growth.reshape(self.copies, -1).max(axis=0)
        counts = np.where(growth > 1, np.ceil(4 * growth), 1).astype(int)
        lengths = np.repeat((self.end - self.start)[: len(growth)] / counts, counts)
        pattern = _joined(lengths, np.repeat(growth / counts, counts))
        return self.on(repeated(pattern, self.copies))


def _joined(lengths: Array, growth: Array) -> Array:
    """Join neighbors as long as growth stays below a quarter; return the edges."""
    ends = np.cumsum(lengths)
    edges, own, longest = [0.0], 0.0, ends[-1] / INTERVALS
    for start, end, grown in zip(ends - lengths, ends, growth, strict=True):
        if start > edges[-1] and (own + grown > 0.25 or end - edges[-1] > 1.001 * longest):
            edges.append(start)
            own = 0.0
        own += grown
    return np.append(edges, ends[-1])


def growth_within(blocks: Array) -> float:
    """Return by how much perturbations grow at most from the first node to any other."""
    if np.linalg.norm(blocks, axis=(1, 2)).prod() <= RESOLVED:
        return 1.0
    propagated = accumulate(blocks, lambda before, block: block @ before)
    return max(float(np.abs(each).max()) for each in propagated)
