"""A mode that is ready to run: its integrator knows the parameters of a motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.equations import Constants
from slipfold.flow.switched.compiled_mode import CompiledMode

__all__ = ["ReadyMode"]

Array = NDArray[np.float64]


class ReadyMode:
    """An integrator with the places of its states: most pieces of a motion differ in them alone."""

    def __init__(
        self, compiled: CompiledMode, integrator: Any, constants: Constants, weights: Array
    ) -> None:
        known = np.concatenate([constants.values, constants.scales, weights])
        integrator.pars[: len(known)] = known
        self.compiled, self.integrator = compiled, integrator
        self.constants, self.weights = constants, weights
        n, count = len(constants.scales), compiled.contacts
        own = 0 if compiled.slow is None else 3
        whole = integrator.state
        self.scaled = whole[:n]
        self.slow = whole[n : n + own]  # logarithm and angle of slow slip, and the phase
        self.energies = whole[n + own :].reshape(2, count)
        self.units = 1 / (weights[:count] * weights[count : 2 * count])  # of energies, in J
