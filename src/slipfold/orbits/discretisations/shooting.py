"""Multiple shooting: orbits cut into segments that are integrated side by side."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.models.model import Model
from slipfold.models.turns import without_turns
from slipfold.orbits.discretisations.segments import Segments

SEGMENTS = 8
"""Segments an orbit is split into: one SIMD batch, and growth of 500 a period becomes 2.2 each."""

PHASES = 32
"""Places in each segment that are looked at first for where one cycle lies nearest another."""

CORRECTIONS = 4
"""Newton steps from the nearest of them: each doubles the digits."""


class Shooting(Segments):
    """The flow over m segments of a period: each has to end where the next begins.

    `offset` is the phase of the first node, in segments.
    """

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int = 1,
        segments: int = SEGMENTS,
        offset: float = 0.0,
    ) -> None:
        edges: Array = (np.arange(segments + 1, dtype=float) + offset) * (period / segments)
        super().__init__(model, free, period, edges)

    def with_period(self, period: int) -> Shooting:
        """Return the same for orbits of another period."""
        return Shooting(self.model, self.free, period, self.segments)

    def shifted(
        self, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[Shooting, Array, Array]:
        """Return the same half a segment later: the integrator's steps fall elsewhere."""
        other = Shooting(self.model, self.free, self.period, self.segments, 0.5)
        ends, matrices, vectors = self.carried(nodes, constants, other.start)
        return other, ends, np.einsum("jab,jb->ja", matrices, along) + vectors @ rates

    def mismatch(self, nodes: Array, constants: Constants) -> Array:
        """Return by how much segments end beside the next node, in scaled states, shape (m, n)."""
        ends = self.flow.advance(nodes, self.start, self.end, constants)
        return without_turns((ends - nodes[self._following]) / self.scales, self.turns)

    def transitions(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the mismatch and the derivatives of the segments' ends, all in scaled states."""
        ends, matrices, vectors = self.carried(nodes, constants, self.end)
        mismatch = without_turns((ends - nodes[self._following]) / self.scales, self.turns)
        units = self.units / np.sqrt(self.segments)
        return mismatch, matrices * self.ratios, vectors * (units / self.scales[:, None])

    def carried(
        self, nodes: Array, constants: Constants, phases: Array
    ) -> tuple[Array, Array, Array]:
        """Return the states at later phases with their derivatives, nothing scaled.

        Shapes: nodes (m, n); phases (m,); returns states (m, n), matrices (m, n, n), vectors
        (m, n, k).
        """
        along = constants.rates[:, self.indices]
        return self.flow.linearise(nodes, self.start, phases, constants, along)

    def advanced(self, nodes: Array, constants: Constants, turns: float) -> Array:
        """Return the states some forcing periods later, shape (m, n)."""
        return self.flow.advance(nodes, self.start, self.start + turns, constants)

    def carried_to(
        self, nodes: Array, constants: Constants, phases: Array
    ) -> tuple[NDArray[np.intp], Array, Array, Array]:
        """Return the states at any phases, from which node each is reached, and derivatives."""
        which, within = self.before(phases)
        along = constants.rates[:, self.indices]
        return which, *self.flow.linearise(
            nodes[which], self.start[which], within, constants, along
        )

    def states(self, nodes: Array, constants: Constants, phases: Array) -> Array:
        """Return the states at any phases, shape (q, n)."""
        which, within = self.before(phases)
        return self.flow.advance(nodes[which], self.start[which], within, constants)

    def evenly(self, nodes: Array, constants: Constants, count: int = 0) -> Array:
        """Return the states at equidistant phases from that of the first node, shape (M, n)."""
        each = -(-count // self.segments)
        if each < 2:
            return nodes
        samples = self.flow.sample(nodes, self.start, self.end, each, constants)
        return samples.reshape(each * self.segments, -1)

    def begun_near(self, nodes: Array, constants: Constants, wanted: Array) -> Array:
        """Return the nodes of an orbit begun where these lie nearest to others."""
        m, start = self.segments, self.start
        samples = self.flow.sample(nodes, start, self.end, PHASES, constants)
        samples = samples.reshape(m * PHASES, -1)
        rolled = [np.roll(samples, -shift, axis=0)[::PHASES] for shift in range(m * PHASES)]
        aside = [self.apart(item / self.scales, wanted / self.scales) for item in rolled]
        nodes = wanted + min(aside, key=lambda gap: float(np.linalg.norm(gap))) * self.scales
        apart = self.period / (m * PHASES)
        for _ in range(CORRECTIONS):
            rates = self.flow.rates(nodes, start, constants) / self.scales
            gap = (wanted - nodes) / self.scales
            later = float((rates * gap).sum() / (rates * rates).sum())
            later = min(max(later, -apart), apart)  # beside an equilibrium all phases are as near
            nodes = self.flow.advance(nodes, start, start + later, constants)
        return nodes

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
