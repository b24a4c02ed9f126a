"""The stroboscopic map's second and third derivatives, put together from those of the segments."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.orbits.discretisation import Segments
from slipfold.orbits.linearisation import Linearisation
from slipfold.orbits.orbit_curve import Orbits

Vector = NDArray[Any]

SPANNED = 1e-7
"""Share of a direction outside the span of others below which it is a combination of them."""


class SegmentMap:
    r"""Second and third derivatives of the map over one period of an orbit, in scaled states.

    They are put together from those of the segments, integrated side by side: with
    :math:`b_j = B_j(v, v)` and :math:`c_j = C_j(v, v, v)` of the map up to the end of segment j,

    .. math:: b_j = D^2\phi_j[v_j, v_j] + A_j b_{j-1}, \quad
              c_j = D^3\phi_j[v_j, v_j, v_j] + 3 D^2\phi_j[v_j, b_{j-1}] + A_j c_{j-1}

    where v_j is v carried to segment j.

    Directions and results are in the given scales of the states; those of the unknown if None.
    """

    def __init__(
        self,
        orbits: Orbits,
        z: Array,
        constants: Constants,
        linearisation: Linearisation,
        scales: Array | None = None,
    ) -> None:
        assert isinstance(orbits.by, Segments)
        self._by = orbits.by
        self._nodes = orbits.nodes(z)
        self._constants = constants
        self._blocks = linearisation.blocks
        self.rescaling = orbits.scales / (orbits.scales if scales is None else scales)
        known, bent = linearisation.conditions.carried, linearisation.conditions.bent
        self._carried = np.empty((0, *self._nodes.shape)) if known is None else known
        self._bent = np.empty((0, *self._blocks.shape)) if bent is None else bent

    def rescaled(self, monodromy: Array) -> Array:
        """Return a monodromy matrix in the map's scales. Shapes: monodromy (n, n)."""
        return monodromy * self.rescaling[:, None] / self.rescaling

    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions.

        Shapes: directions (r, n); returns second, third (r, n).
        """
        along = directions / self.rescaling
        forward, bent = self._curvatures(along)
        cubes = self._by.cubes(self._nodes, self._constants, forward)
        second = self._summed(np.einsum("rmab,rmb->rma", bent, forward))
        mixed = np.einsum("rmab,rmb->rma", bent, second[:, :-1])
        third = self._summed(cubes + 3 * mixed)
        return second[:, -1] * self.rescaling, third[:, -1] * self.rescaling

    def _summed(self, terms: Vector) -> Vector:
        """Return what the segments' terms come to at each node, carried on from node to node.

        Shapes: terms (r, m, n); returns (r, m + 1, n).
        """
        count, m, n = terms.shape
        sums = np.zeros((count, m + 1, n), dtype=terms.dtype)
        for j, block in enumerate(self._blocks):
            np.matmul(sums[:, j], block.T, out=sums[:, j + 1])
            sums[:, j + 1] += terms[:, j]
        return sums

    def second(self, pairs: list[tuple[Vector, Vector]]) -> list[Vector]:
        """Return B(u, v) for complex vectors. Shapes: pairs (n,)."""
        return [self._bilinear(u.real, v) + 1j * self._bilinear(u.imag, v) for u, v in pairs]

    def _bilinear(self, u: Array, v: Vector) -> Vector:
        """B(u, v) for a real u."""
        if not u.any():
            return np.zeros(len(v), dtype=complex)
        bent = self._curvatures((u / self.rescaling)[None])[1][0]
        carried = [v / self.rescaling]
        for block in self._blocks[:-1]:
            carried.append(block @ carried[-1])
        terms = np.einsum("mab,mb->ma", bent, np.array(carried))
        return np.asarray(self._summed(terms[None])[0, -1] * self.rescaling)

    def _curvatures(self, along: Array) -> tuple[Array, Array]:
        """Directions carried along the orbit, (r, m, n), and D^2 phi_j along each, (r, m, n, n).

        Both are linear in the direction: no more than n of them are ever integrated.
        """
        for direction in along:
            rest = direction - self._shares(direction[None])[0] @ self._carried[:, 0]
            if np.linalg.norm(rest) > SPANNED * np.linalg.norm(direction):
                self._integrate(rest / np.linalg.norm(rest))
        shares = self._shares(along)
        return (
            np.einsum("rk,kmn->rmn", shares, self._carried),
            np.einsum("rk,kmab->rmab", shares, self._bent),
        )

    def _shares(self, along: Array) -> Array:
        """Return directions as sums of those that are known, nearly. Shapes: (r, n) to (r, k)."""
        known = self._carried[:, 0]
        if len(known) == 1:  # as for most; a fifth of the time
            return np.asarray(along @ known.T / (known @ known.T))
        return np.asarray(np.linalg.lstsq(known.T, along.T, rcond=None)[0].T)

    def _integrate(self, direction: Array) -> None:
        """Add a direction to those along which second derivatives are known."""
        forward = [direction]
        for block in self._blocks[:-1]:
            forward.append(block @ forward[-1])
        carried = np.array(forward)[None]
        bent, _ = self._by.curvatures(self._nodes, self._constants, carried)
        self._carried = np.concatenate([self._carried, carried])
        self._bent = np.concatenate([self._bent, bent])
