"""Multiple shooting: orbits cut into segments that are integrated in one batch."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.models.angles import wrap_angles
from slipfold.models.model import Model
from slipfold.orbits.discretization import Discretization

SEGMENTS = 8
"""Segments an orbit is split into: one SIMD batch, and growth of 500 a period becomes 2.2 each."""


class Shooting(Discretization):
    """The flow over m segments of a period: each has to end where the next begins.

    `phase` is that of the first node.
    """

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int = 1,
        segments: int = SEGMENTS,
        phase: float = 0.0,
    ) -> None:
        edges: Array = phase + np.arange(segments + 1, dtype=float) * (period / segments)
        super().__init__(model, free, period, edges)

    def with_period(self, period: int) -> Self:
        """Return the same for orbits of another period."""
        return type(self)(self.model, self.free, period, self.segments, self.phase)

    def shifted(
        self, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[Self, Array, Array]:
        """Return the same half a segment later: the integrator's steps fall elsewhere."""
        half = 0.5 * self.period / self.segments
        other = type(self)(self.model, self.free, self.period, self.segments, half)
        ends, matrices, vectors = self.propagate(nodes, self.start, other.start, constants)
        return other, ends, np.einsum("jab,jb->ja", matrices, along) + vectors @ rates

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
        ends = self.ends(nodes, self.start, self.end, constants)
        return wrap_angles((ends - nodes[self._following]) / self.scales, self.turns)

    def transitions(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the mismatch and the derivatives of the segments' ends, all in scaled states."""
        ends, matrices, vectors = self.propagate(nodes, self.start, self.end, constants)
        mismatch = wrap_angles((ends - nodes[self._following]) / self.scales, self.turns)
        units = self.units / np.sqrt(self.segments)
        return mismatch, matrices * self.ratios, vectors * (units / self.scales[:, None])

    def propagate_to(
        self, nodes: Array, constants: Constants, phases: Array
    ) -> tuple[NDArray[np.intp], Array, Array, Array]:
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
        matrices, pulls = self.flow.curve(
            np.tile(nodes, (r, 1)),
            np.tile(self.start, r),
            np.tile(self.end, r),
            constants,
            constants.rates[:, self.indices],
            (vectors * self.scales).reshape(-1, n),
        )
        bent = (matrices * self.ratios).reshape(r, m, n, n)
        pulled = (pulls * self.pull_units).reshape(r, m, n, -1)
        return bent, pulled

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
