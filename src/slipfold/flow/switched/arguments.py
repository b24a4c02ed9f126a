"""What compiled functions of a state are given: the state, its phase and what stays the same."""

from __future__ import annotations

import threading

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants


class Arguments(threading.local):
    """Their place in memory, one a thread: most calls of a motion differ in few of them."""

    def __init__(self) -> None:
        self._constants: Constants | None = None
        self._whole, self._count = np.empty(0), 0

    def of(self, state: Array, phase: float, constants: Constants) -> Array:
        """Return state, phase and coefficients, good until the next call. Shapes: state (n,)."""
        if constants is not self._constants:
            self._whole = np.concatenate([state, (phase,), constants.values])
            self._constants, self._count = constants, len(state)
        whole, count = self._whole, self._count
        whole[:count] = state
        whole[count] = phase
        return whole


def many(states: Array, phases: Array, constants: Constants) -> Array:
    """Return the same of many states, one a column. Shapes: states (p, n); phases (p,)."""
    known = np.repeat(constants.values[:, None], len(states), axis=1)
    # Without coefficients the columns are not yet one behind the other.
    return np.ascontiguousarray(np.concatenate([states.T, phases[None], known]))
