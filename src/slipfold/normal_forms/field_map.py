"""A vector field's second and third derivatives at an equilibrium."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.orbits.orbit_curve import Orbits

Vector = NDArray[Any]


class FieldMap:
    """Jacobian A and multilinear forms B and C of a vector field, in scaled states and per second.

    The scales are those of the unknown if None.
    """

    def __init__(self, orbits: Orbits, z: Array, scales: Array | None = None) -> None:
        self._flow = orbits.flow
        self._state = orbits.nodes(z)[0]
        self._constants = orbits.constants(z)
        self._scales = orbits.scales if scales is None else scales
        self._time = self._constants.period
        self._along = self._constants.rates[:, orbits.indices[-1:]]
        self.rescaling = orbits.scales / self._scales

    @property
    def jacobian(self) -> Array:
        """Derivative of the rates, shape (n, n)."""
        found = self._flow.jacobians(self._state[None], np.zeros(1), self._constants)[0]
        return found * self._scales / self._scales[:, None] / self._time

    @property
    def pull(self) -> Array:
        """Derivative of the rates with respect to the last free parameter, shape (n,)."""
        states = self._state[None]
        found = self._flow.pulls(states, np.zeros(1), self._constants, self._along)[0, :, 0]
        return np.asarray(found / self._scales / self._time)

    def rescaled(self, monodromy: Array) -> Array:
        """Return a matrix in these scales. Shapes: monodromy (n, n)."""
        return monodromy * self.rescaling[:, None] / self.rescaling

    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions.

        Shapes: directions (r, n); returns second, third (r, n).
        """
        units = self._scales * self._time
        states, phases = np.tile(self._state, (len(directions), 1)), np.zeros(len(directions))
        along = directions * self._scales
        found = self._flow.powers(states, phases, self._constants, along)
        return found[0] / units, found[1] / units

    def second(self, pairs: list[tuple[Vector, Vector]]) -> list[Vector]:
        """Return B(u, v) for complex vectors. Shapes: pairs (n,)."""
        parts = np.array([part for u, _ in pairs for part in (u.real, u.imag)])
        none = np.zeros((len(self._constants.values), 1))
        states, phases = np.tile(self._state, (len(parts), 1)), np.zeros(len(parts))
        along = parts * self._scales
        bent = self._flow.curvatures(states, phases, self._constants, along, none)[0]
        bent = bent * self._scales / self._scales[:, None] / self._time
        return [
            (bent[2 * i] + 1j * bent[2 * i + 1]) @ v.astype(complex)
            for i, (_, v) in enumerate(pairs)
        ]
