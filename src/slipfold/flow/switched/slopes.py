"""How slips, events and what contacts hold change with states, phase and coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.flow.cache import cached
from slipfold.flow.equations import Constants, Equations
from slipfold.models.evaluation import compiled_function
from slipfold.models.output import Expression


class Slopes:
    """Some functions of state, phase and coefficients with their first derivatives, compiled."""

    def __init__(self, functions: Sequence[Expression], equations: Equations) -> None:
        inputs = [*equations.states, equations.phase, *equations.coefficients]
        self._shape = len(functions), len(inputs)
        self._states = equations.dimension
        self._functions, self._inputs = list(functions), inputs
        key = f"slopes {[str(item) for item in functions]}\n{equations.fingerprint()}"
        self._function: Any = cached(
            key,
            lambda: compiled_function(
                hy.diff_tensors(list(functions), diff_args=inputs, diff_order=1).jacobian.ravel(),
                inputs,
            ),
        )

    @cached_property
    def _values(self) -> Any:
        return compiled_function(self._functions, self._inputs)

    def values(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Return the functions themselves. Shapes: states (p, n); phases (p,); returns (p, q)."""
        known = np.tile(constants.values, (len(states), 1))
        inputs = np.concatenate([states, phases[:, None], known], axis=1)
        return np.ascontiguousarray(self._values(np.ascontiguousarray(inputs.T)).T)

    def at(
        self, state: Array, phase: float, constants: Constants, directions: Array
    ) -> tuple[Array, Array, Array]:
        """Return derivatives by state and phase, and along changes of the coefficients.

        Shapes: state (n,); directions (n_c, k); returns (q, n), (q,), (q, k).
        """
        found = self._function(np.concatenate([state, [phase], constants.values]))
        found, n = found.reshape(self._shape), self._states
        return found[:, :n], found[:, n], found[:, n + 1 :] @ directions
