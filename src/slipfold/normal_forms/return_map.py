"""A cycle's return map to a section across the flow, with its derivatives from Taylor jets."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.normal_forms.jet_map import polarised
from slipfold.orbits.multipliers import motion_bases
from slipfold.orbits.orbit_curve import Orbits

Vector = NDArray[Any]

SAMPLES = 8
"""Samples of a segment over which the length of a vector carried along is averaged."""

OFF_ONE = 1e-3
"""A multiplier this far from one has an eigenvector of its own beside the flow's direction."""


class ReturnMap:
    r"""Where motions near a cycle cross a section the next time, in scaled states.

    The section is the plane through the first node orthogonal to the flow there. The flow over the
    cycle's duration leads beside it; the time that is missing follows order by order from

    .. math:: f^T (\phi(x_0 + s v, T + \tau(s)) - x_0) = 0

    with the derivatives of the flow along v and in time. Vectors are coordinates in the section.
    """

    def __init__(self, orbits: Orbits, z: Array, scales: Array) -> None:
        self._orbits, self._z = orbits, z
        self._constants = orbits.constants(z)
        self._scales = scales
        self._rescaling = orbits.scales / scales
        self._nodes = orbits.evenly(z)
        rates = orbits.flow.rates(self._nodes[:1], np.array([orbits.phase]), self._constants)[0]
        self._flow = rates / scales
        self._basis = motion_bases(self._flow[None])[0][:, 1:]

    def rescaled(self, monodromy: Array) -> Array:
        """Return the map's matrix, shape (n - 1, n - 1). Shapes: monodromy (n, n)."""
        return np.asarray(self._basis.T @ self._in_scales(monodromy) @ self._basis)

    def carried(self, vector: Array) -> Array:
        """Return a displacement of the flow's end as one of the map, shape (n - 1,).

        Shapes: vector (n,).
        """
        return np.asarray(self._basis.T @ (vector * self._rescaling))

    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions.

        Shapes: directions (r, n - 1); returns second, third (r, n - 1).
        """
        orbits = self._orbits
        jets = orbits.flow.jet_in_time(
            self._nodes,
            orbits.phase,
            orbits.phase + orbits.period,
            self._constants,
            directions @ self._basis.T * self._scales,
        )
        return self.across(jets, self._flow, self._basis)

    def across(self, jets: Array, flow: Array, basis: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) in the section across the flow where jets end.

        Shapes: jets (r, 4, 4, n); flow (n,); basis (n, n - 1).
        """
        y = np.moveaxis(jets / self._scales, 0, 2)  # order in s, order in time, direction, state
        across = flow / (flow @ flow)

        def late(displacement: Array) -> Array:
            """Time that brings a displacement back into the section."""
            return -(displacement @ across)[:, None]

        a = late(y[1, 0])
        second = y[2, 0] + 2 * a * y[1, 1] + a**2 * y[0, 2]
        b = late(second)
        third = y[3, 0] + 3 * a * y[2, 1] + 3 * a**2 * y[1, 2] + a**3 * y[0, 3]
        third = third + 3 * b * y[1, 1] + 3 * a * b * y[0, 2]
        return second @ basis, third @ basis

    def second(self, pairs: list[tuple[Vector, Vector]]) -> list[Vector]:
        """Return B(u, v) for complex vectors, by polarisation. Shapes: pairs (n - 1,)."""
        return polarised(lambda directions: self.powers(directions)[0], pairs)

    def length(self, q: Vector, multiplier: complex, monodromy: Array, ratios: Array) -> float:
        """Return the root mean square, round the cycle, of an eigenvector of the map.

        It does not depend on where the cycle is begun, and so do coefficients by it. The vector is
        the flow's eigenvector that belongs to it; at a fold, where there is none, the part across
        the flow.

        Shapes: q (n - 1,); monodromy (n, n); ratios (n,).
        """
        f = self._flow
        vector = self._basis @ q
        if abs(multiplier - 1) > OFF_ONE:
            along = f @ (self._in_scales(monodromy) @ vector) / (f @ f)
            vector = vector + f * along / (multiplier - 1)
        starts = [vector]
        for block in self._blocks(*self._edges())[1][:-1]:
            starts.append(block @ starts[-1])
        return self.mean_length(np.array(starts), ratios, at_one=abs(multiplier - 1) <= OFF_ONE)

    def mean_length(self, starts: Vector, ratios: Array, *, at_one: bool = False) -> float:
        """Return the root mean square, round the cycle, of a vector that is known at its nodes.

        Shapes: starts (m, n); ratios (n,).
        """
        orbits, nodes, total = self._orbits, self._nodes, 0.0
        begin, end = self._edges()
        for k in range(SAMPLES):
            ends = begin + (end - begin) * k / SAMPLES
            states, matrices = (nodes, None) if k == 0 else self._blocks(begin, ends)
            moved = starts
            if matrices is not None:
                moved = np.einsum("jab,jb->ja", matrices, moved)
            moved = moved * ratios
            if at_one:
                rates = orbits.flow.rates(states, ends, self._constants) / self._scales * ratios
                share = np.sum(moved * rates, axis=1) / np.sum(rates**2, axis=1)
                moved = moved - share[:, None] * rates
            total += float(np.mean(np.sum(np.abs(moved) ** 2, axis=1)))
        return float(np.sqrt(total / SAMPLES))

    def _edges(self) -> tuple[Array, Array]:
        """Phases at which the segments begin and end."""
        orbits = self._orbits
        edges = np.linspace(orbits.phase, orbits.phase + orbits.period, len(self._nodes) + 1)
        return edges[:-1], edges[1:]

    def _in_scales(self, matrix: Array) -> Array:
        return matrix * self._rescaling[:, None] / self._rescaling

    def _blocks(self, start: Array, end: Array) -> tuple[Array, Array]:
        """Return where segments end and their transition matrices."""
        orbits = self._orbits
        along = self._constants.rates[:, orbits.indices]  # as compiled for the branch
        ends, matrices, _ = orbits.flow.linearise(self._nodes, start, end, self._constants, along)
        return ends, matrices * self._scales[None, :] / self._scales[:, None]
