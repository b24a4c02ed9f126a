"""Multiple shooting: orbits cut into segments that are integrated side by side."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.equations import Constants
from slipfold.models.model import Model
from slipfold.orbits.discretisation import Discretisation
from slipfold.orbits.spectrum.degeneracy import Degeneracy

__all__ = ["SEGMENTS", "Shooting"]

Array = NDArray[np.float64]

SEGMENTS = 8
"""Segments an orbit is split into: one SIMD batch, and growth of 500 a period becomes 2.2 each."""


class Shooting(Discretisation):
    """The flow over m segments of a period: each has to end where the next begins.

    Parameters
    ----------
    model
        The model.
    free
        The free parameters with their scales, in their own units.
    period
        Period in forcing periods.
    segments
        Number of segments m.
    offset
        Phase of the first node, in segments.
    """

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int = 1,
        segments: int = SEGMENTS,
        offset: float = 0.0,
    ) -> None:
        super().__init__(model, free, period, segments)
        edges: Array = (np.arange(segments + 1, dtype=float) + offset) * (period / segments)
        self.start, self.end = edges[:-1], edges[1:]
        self.phase = float(edges[0])
        self._following = (np.arange(segments) + 1) % segments

    def shifted(
        self, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[Shooting, Array, Array]:
        """Return the same with nodes half a segment later: the integrator's steps fall elsewhere.

        Shapes: nodes, along (m, n); rates (k,); returns nodes and direction (m, n).
        """
        other = Shooting(self.model, self.free, self.period, self.segments, 0.5)
        ends, matrices, vectors = self.carried(nodes, constants, other.start)
        return other, ends, np.einsum("jab,jb->ja", matrices, along) + vectors @ rates

    def mismatch(self, nodes: Array, constants: Constants) -> Array:
        """Return by how much segments end beside the next node, in scaled states, shape (m, n).

        Shapes: nodes (m, n).
        """
        ends = self.flow.advance(nodes, self.start, self.end, constants)
        return (ends - nodes[self._following]) / self.scales

    def transitions(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the mismatch and the derivatives of the segments' ends, all in scaled states.

        Shapes: nodes (m, n); returns mismatch (m, n), blocks (m, n, n), along (m, n, k).
        """
        ends, matrices, vectors = self.carried(nodes, constants, self.end)
        mismatch = (ends - nodes[self._following]) / self.scales
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
        """Return the states some forcing periods later, shape (m, n).

        Shapes: nodes (m, n).
        """
        return self.flow.advance(nodes, self.start, self.start + turns, constants)

    def halved(self, nodes: Array, constants: Constants) -> Array:
        """Return the states at twice as many phases, shape (2 m, n).

        Shapes: nodes (m, n).
        """
        samples = self.flow.sample(nodes, self.start, self.end, 2, constants)
        return samples.reshape(2 * len(nodes), -1)

    def rates(self, nodes: Array, constants: Constants) -> Array:
        """Return the rates at the nodes a forcing period, in scaled states, shape (m, n).

        Shapes: nodes (m, n).
        """
        return self.flow.rates(nodes, self.start, constants) / self.scales

    def first_rates(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the rates at the first node with their derivatives, in scaled variables.

        Shapes: nodes (m, n); returns rates (n,), slopes (n, n), pulls (n, k).
        """
        first, at = nodes[:1], self.start[:1]
        rates = self.flow.rates(first, at, constants)[0] / self.scales
        slopes = self.flow.jacobians(first, at, constants)[0] * self.ratios
        pulls = self.flow.pulls(first[0], constants, constants.rates[:, self.indices])
        return rates, slopes, pulls * self.pull_units

    def curvatures(self, nodes: Array, constants: Constants, vectors: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``blocks @ vectors``, all in scaled states.

        Shapes: nodes (m, n); vectors (r, m, n); returns bent (r, m, n, n), pulled (r, m, n, k).
        """
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
        """Return the third derivatives of the segments' ends along vectors, in scaled states.

        Shapes: nodes (m, n); vectors (r, m, n); returns (r, m, n).
        """
        r, m, n = vectors.shape
        jets = self.flow.jet(
            np.tile(nodes, (r, 1)),
            np.tile(self.start, r),
            np.tile(self.end, r),
            constants,
            (vectors * self.scales).reshape(-1, n),
        )
        return (jets[:, 2] / self.scales).reshape(r, m, n)

    def slope(
        self, found: Degeneracy, blocks: Array, nodes: Array, constants: Constants
    ) -> tuple[Array, Array, Array]:
        r"""Differentiate a function of the monodromy matrix with respect to the unknown.

        With :math:`M = A_{m-1} ... A_0` a term :math:`p^T dM q` is the sum over the segments of
        :math:`p_j^T dA_j q_j`, where q is carried forward to segment j and p backward to its end,
        and a change of :math:`A_j q_j` is a second derivative of the flow along q_j.

        Shapes: blocks (m, n, n); nodes (m, n); returns the gradient (m n + k,), q_j (r, m, n) and
        the second derivatives along them (r, m, n, n).
        """
        forward, backward = _carried(blocks, found.left, found.right)
        bent, pulled = self.curvatures(nodes, constants, forward)
        along_nodes = np.einsum("rja,rjab->jb", backward, bent).ravel() * np.sqrt(self.segments)
        along_free = np.einsum("rja,rjak->k", backward, pulled)
        return np.concatenate([along_nodes, along_free]), forward, bent


def _carried(blocks: Array, left: Array, right: Array) -> tuple[Array, Array]:
    """Carry r vectors forward to the start of each segment, r backward to each end: (r, m, n)."""
    forward, backward = [right], [left]
    for block in blocks[:-1]:
        forward.append(forward[-1] @ block.T)
    for block in blocks[:0:-1]:
        backward.append(backward[-1] @ block)
    return np.stack(forward, axis=1), np.stack(backward[::-1], axis=1)
