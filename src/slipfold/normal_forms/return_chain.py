"""Normal form of a cycle's PD or NS from section to section, where growth takes all digits."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.normal_forms.jet_map import polarised
from slipfold.normal_forms.return_map import ReturnMap
from slipfold.orbits.orbit_curve import Orbits

Vector = NDArray[Any]

LARGEST = 1500
"""Unknowns up to which equations around the cycle are solved densely: a second or two."""

SINGULAR = 1e-3
"""Smallest singular value at which the equations around the cycle have the critical vector."""


class ReturnChain(ReturnMap):
    r"""The return map as a chain of maps from one section across the flow to the next.

    A product of the maps' matrices loses a critical multiplier beside one of :math:`10^5`. The
    vectors that the normal form needs are found for all sections at once instead, from
    :math:`A_j q_j = q_{j+1}` with :math:`q_m = \mu q_0`, and so are the adjoint ones and those of
    second order: nothing is multiplied up. With :math:`w_j` the left null vector,

    .. math:: c = \frac{1}{6} \sum_j w_j^* \bigl(C_j(q_j, q_j, q_j) + 3 B_j(q_j, h_j)\bigr), \quad
              h_{j+1} - A_j h_j = B_j(q_j, q_j)

    for a period doubling, and in the same way for a torus.
    """

    def __init__(self, orbits: Orbits, z: Array, scales: Array) -> None:
        super().__init__(orbits, z, scales)
        count, n = self._nodes.shape
        if count * (n - 1) > LARGEST:
            raise np.linalg.LinAlgError("the cycle has too many sections")
        begin, end = self._edges()
        flows = orbits.flow.rates(self._nodes, begin, self._constants) / self._scales
        self._flows = np.concatenate([flows, flows[:1]])
        bases = np.linalg.qr(flows[:, :, None], mode="complete")[0][:, :, 1:]
        self._bases = np.concatenate([bases, bases[:1]])
        self._whole = self._blocks(begin, end)[1]
        self._matrices = np.swapaxes(self._bases[1:], 1, 2) @ self._whole @ self._bases[:-1]

    def form(self, kind: str, multiplier: complex, ratios: Array) -> tuple[float, float]:
        """Return the coefficient and the mean length of the critical vector round the cycle.

        Shapes: ratios (n,).
        """
        factor = -1.0 if kind == "PD" else multiplier / abs(multiplier)
        left, values, right = np.linalg.svd(self._around(factor))
        if not values[-1] < SINGULAR:
            raise np.linalg.LinAlgError(f"the chain has lost the multiplier of its {kind}")
        shape = len(self._matrices), -1
        q, w = right[-1].conj().reshape(shape), left[:, -1].reshape(shape)
        w = w / np.vdot(w[-1], q[0]).conjugate()
        coefficient = self._doubling(q, w) if kind == "PD" else self._torus(q, w, factor)
        return coefficient, self._mean(q, factor, ratios)

    def _around(self, factor: complex) -> Vector:
        """Return the matrix of ``A_j q_j - q_(j+1)``, the last ``q_m`` the first times a factor."""
        count, n, _ = self._matrices.shape
        matrix = np.zeros((count, n, count, n), dtype=np.result_type(factor, float))
        for j, block in enumerate(self._matrices):
            matrix[j, :, j] += block
            matrix[j, :, (j + 1) % count] -= np.eye(n) * (factor if j == count - 1 else 1.0)
        return matrix.reshape(count * n, count * n)

    def _solved(self, factor: complex, right: Vector) -> Vector:
        """Solve ``h_(j+1) - A_j h_j = b_j``. Shapes: right (m, n - 1)."""
        return np.linalg.solve(self._around(factor), -right.ravel()).reshape(right.shape)

    def _doubling(self, q: Array, w: Array) -> float:
        squares, cubes = self._each(q[:, None])
        bent = self._solved(1.0, squares[:, 0])
        mixed = self._mixed([(q.astype(complex), bent.astype(complex))]).real
        return float(np.vdot(w, cubes[:, 0] + 3 * mixed) / 6)

    def _torus(self, q: Vector, w: Vector, factor: complex) -> float:
        a, b = q.real, q.imag
        squares, cubes = self._each(np.stack([a, b, a + b, a - b], axis=1))
        aa, bb = squares[:, 0], squares[:, 1]
        ab = (squares[:, 2] - squares[:, 3]) / 4
        aaa, bbb = cubes[:, 0], cubes[:, 1]
        aab = (cubes[:, 2] - cubes[:, 3]) / 6 - bbb / 3
        abb = (cubes[:, 2] + cubes[:, 3]) / 6 - aaa / 3
        still = self._solved(1.0, aa + bb).astype(complex)
        double = self._solved(factor**2, aa - bb + 2j * ab)
        mixed = self._mixed([(q, 2 * still), (q.conj(), double)])
        inner = np.vdot(w, aaa + abb + 1j * (aab + bbb) + mixed)
        return float(0.5 * (np.conj(factor) * inner).real)

    def _each(self, directions: Array) -> tuple[Array, Array]:
        """Return B_j(v, v) and C_j(v, v, v) of each map. Shapes: directions (m, r, n - 1)."""
        found = [self._powers_of(j, each) for j, each in enumerate(directions)]
        second, third = zip(*found, strict=True)
        return np.array(second), np.array(third)

    def _mixed(self, pairs: list[tuple[Vector, Vector]]) -> Vector:
        """Return the sum of B_j(u_j, v_j) over pairs. Shapes: (m, n - 1)."""

        def squares(j: int, directions: Array) -> Array:
            return self._powers_of(j, directions)[0]

        found = [
            polarised(partial(squares, j), [(u[j], v[j]) for u, v in pairs])
            for j in range(len(self._matrices))
        ]
        return np.sum(found, axis=1)

    def _powers_of(self, j: int, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) of one map. Shapes: directions (r, n - 1)."""
        begin, end = (float(edges[j]) for edges in self._edges())
        jets = self._orbits.flow.jet_in_time(
            self._nodes[j : j + 1],
            begin,
            end,
            self._constants,
            directions @ self._bases[j].T * self._scales,
        )
        return self.across(jets, self._flows[j + 1], self._bases[j + 1])

    def _mean(self, q: Vector, factor: complex, ratios: Array) -> float:
        """Return the root mean square of the flow's own vector that lies over q."""
        starts = np.einsum("jab,jb->ja", self._bases[:-1], q)
        ends = np.einsum("jab,jb->ja", self._whole, starts)
        flows = self._flows[1:]
        gained = np.sum(ends * flows, axis=1) / np.sum(flows**2, axis=1)
        before = np.concatenate([[0.0], np.cumsum(gained)])
        along = before[:-1] + before[-1] / (factor - 1)
        return self.mean_length(starts + along[:, None] * self._flows[:-1], ratios)
