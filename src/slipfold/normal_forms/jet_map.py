"""The stroboscopic map's second and third derivatives from Taylor jets along directions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.orbits.orbit_curve import Orbits

Vector = NDArray[Any]


class JetMap:
    """Derivatives of the stroboscopic map from Taylor jets over the whole period, in scaled states.

    Jets along directions need no more than a plain flow to be compiled: for the few special points
    of a branch that is what costs most.

    The scales are those of the unknown if None.
    """

    def __init__(
        self, orbits: Orbits, z: Array, constants: Constants, scales: Array | None = None
    ) -> None:
        self._flow = orbits.flow
        self._nodes = orbits.evenly(z)
        self._constants = constants
        self._scales = orbits.scales if scales is None else scales
        self.rescaling = orbits.scales / self._scales
        self._start = orbits.phase
        self._end = orbits.phase + orbits.period

    def rescaled(self, monodromy: Array) -> Array:
        """Return a monodromy matrix in the map's scales. Shapes: monodromy (n, n)."""
        return monodromy * self.rescaling[:, None] / self.rescaling

    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions.

        Shapes: directions (m, n); returns second, third (m, n).
        """
        jets = self._flow.jet(
            self._nodes[0],
            self._start,
            self._end,
            self._constants,
            directions * self._scales,
            self._nodes[1:],
        )
        return jets[:, 1] / self._scales, jets[:, 2] / self._scales

    def second(self, pairs: list[tuple[Vector, Vector]]) -> list[Vector]:
        """Return B(u, v) for complex vectors, by polarisation. Shapes: pairs (n,)."""
        return polarised(lambda directions: self.powers(directions)[0], pairs)

    def carried(self, vector: Array) -> Array:
        """Return a displacement of the flow's end in the map's scales. Shapes: vector (n,)."""
        return vector * self.rescaling


def polarised(
    squares: Callable[[Array], Array], pairs: list[tuple[Vector, Vector]]
) -> list[Vector]:
    """Return B(u, v) for complex vectors from the squares B(w, w) of real ones.

    Shapes: squares (r, n); pairs (n,).
    """
    parts = [
        (place, factor, left, right)
        for place, (u, v) in enumerate(pairs)
        for factor, left, right in (
            (1, u.real, v.real),
            (-1, u.imag, v.imag),
            (1j, u.real, v.imag),
            (1j, u.imag, v.real),
        )
        if np.linalg.norm(left) > 0 and np.linalg.norm(right) > 0  # squares may underflow
    ]
    result: list[Vector] = [np.zeros(len(u), dtype=complex) for u, _ in pairs]
    if not parts:  # a symmetric orbit has no quadratic terms
        return result
    sizes = [(np.linalg.norm(left), np.linalg.norm(right)) for _, _, left, right in parts]
    sums = [
        left / a + sign * right / b
        for (_, _, left, right), (a, b) in zip(parts, sizes, strict=True)
        for sign in (1, -1)
    ]
    values = squares(np.array(sums))
    for i, ((place, factor, _, _), (a, b)) in enumerate(zip(parts, sizes, strict=True)):
        result[place] += factor * a * b / 4 * (values[2 * i] - values[2 * i + 1])
    return result
