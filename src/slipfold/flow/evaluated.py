"""Equations evaluated at states and phases: rates, their derivatives, outputs."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.compiled_code import CompiledCode
from slipfold.flow.equations import Constants


class Evaluated:
    """What equations say at a state and a phase, nothing integrated."""

    def __init__(self, code: CompiledCode, dimension: int) -> None:
        self._code = code
        self.dimension = dimension

    def rates(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate dq/dphase. Shapes: states (m, n); phases (m,); returns (m, n)."""
        return self._evaluate(self._code.rates, states, phases, constants)

    def jacobians(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate the Jacobian of dq/dphase with respect to the states.

        Shapes: states (m, n); phases (m,); returns (m, n, n).
        """
        n = self.dimension
        return self._evaluate(self._code.jacobian, states, phases, constants).reshape(-1, n, n)

    def changing_jacobians(
        self, states: Array, phases: Array, constants: Constants
    ) -> tuple[Array, NDArray[np.intp], Array]:
        """Evaluate the first Jacobian, and of all those columns that states or phase change.

        Shapes: states (m, n); phases (m,); returns (n, n), places (c,), columns (m, n, c).
        """
        first = self.jacobians(states[:1], phases[:1], constants)[0]
        changing, places = self._code.changing_slopes
        rows, where = np.divmod(places, self.dimension)
        columns, own = np.unique(where, return_inverse=True)
        found = np.empty((len(states), self.dimension, len(columns)))
        found[:] = first[:, columns]
        if changing is not None:
            found[:, rows, own] = self._evaluate(changing, states, phases, constants)
        return first, columns, found

    def outputs(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate all outputs, the states first.

        Shapes: states (m, n); phases (m,); returns (m, n_outputs).
        """
        return self._evaluate(self._code.outputs, states, phases, constants)

    def curvatures(
        self,
        states: Array,
        phases: Array,
        constants: Constants,
        vectors: Array,
        directions: Array,
    ) -> tuple[Array, Array]:
        """Differentiate the slopes of the rates along vectors, each at a state of its own.

        Shapes: states, vectors (m, n); phases (m,); directions (n_c, k); returns second (m, n, n),
        mixed (m, n, k).
        """
        m, n, k = len(states), self.dimension, directions.shape[1]
        more = np.concatenate([np.repeat(vectors, k, axis=0), np.tile(directions.T, (m, 1))], 1)
        rows, at = np.repeat(states, k, axis=0), np.repeat(phases, k)
        found = self._evaluate(self._code.curvature, rows, at, constants, more)
        found = found.reshape(m, k, n * n + n)
        mixed = np.swapaxes(found[:, :, n * n :], 1, 2)
        return found[:, 0, : n * n].reshape(m, n, n), mixed

    def pulls(self, states: Array, phases: Array, constants: Constants, directions: Array) -> Array:
        """Return the derivatives of the rates along changes of the coefficients.

        Shapes: states (m, n); phases (m,); directions (n_c, k); returns (m, n, k).
        """
        m, k = len(states), directions.shape[1]
        rows, at = np.repeat(states, k, axis=0), np.repeat(phases, k)
        along = np.tile(directions.T, (m, 1))
        found = self._evaluate(self._code.pull, rows, at, constants, along)
        return found.reshape(m, k, -1).transpose(0, 2, 1)

    def powers(
        self, states: Array, phases: Array, constants: Constants, vectors: Array
    ) -> tuple[Array, Array]:
        """Return second and third derivatives of the rates along vectors.

        Shapes: states, vectors (m, n); phases (m,); returns second, third (m, n).
        """
        found = self._evaluate(self._code.powers, states, phases, constants, vectors)
        return found[:, : self.dimension], found[:, self.dimension :]

    def _evaluate(
        self, function: Any, states: Array, phases: Array, c: Constants, more: Array | None = None
    ) -> Array:
        one = c.values.ndim == 1
        values = np.repeat(c.values[:, None], len(states), axis=1) if one else c.values.T
        rows = [states.T, phases[None], values, *([] if more is None else [more.T])]
        return function(np.ascontiguousarray(np.concatenate(rows))).T
