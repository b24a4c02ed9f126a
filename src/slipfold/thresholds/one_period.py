"""Many motions over one forcing period, with their derivatives and what the limits watch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.flow import flow_of
from slipfold.flow.scaled import power_of_two
from slipfold.flow.strobes.linearised_steps import linearised_steps_of
from slipfold.models.model import Model
from slipfold.orbits.correct_orbits import transitions
from slipfold.orbits.limits import far_above

__all__ = ["OnePeriod", "Passed"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Passed:
    """What one period did, in scaled states."""

    mismatch: Array  # by how much each fails to close, shape (m, n)
    matrices: Array  # monodromy matrices, shape (m, n, n)
    along: Array  # derivatives along the parameter, shape (m, n)
    # Whether each stays far from all limits of the model as far as was looked: farther than orbits
    # move between the period that is watched and their last correction, shape (m,)
    clear: NDArray[np.bool_]


class OnePeriod:
    """One period of motions of a model, each with parameters of its own.

    `index` is the parameter that is varied, `width` its unit.
    """

    def __init__(self, model: Model, index: int, width: float) -> None:
        self.flow = flow_of(model)
        self.index, self.width = index, width
        self._steps = linearised_steps_of(model)
        self._bounds = np.array([limit.bound for limit in model.limits])

    @property
    def is_quick(self) -> bool:
        """Whether there is a way that is quicker than the flow."""
        return self._steps is not None

    def at(self, parameters: Array, values: Array) -> Array:
        """Return parameters with other values of the one that is varied."""
        moved = parameters.copy()
        moved[:, self.index] = values
        return moved

    def exact(self, x: Array, parameters: Array, scales: Array) -> Passed:
        """Integrate by the flow, whose errors are rounding; limits are not looked at.

        Shapes: x, scales (m, n); parameters (m, n_p).
        """
        unit = np.array([self.width])
        nodes = (x * scales)[:, None]
        parts = transitions(self.flow, nodes, parameters, scales, [self.index], unit)
        mismatch, matrices, along = (part[:, 0] for part in parts)
        return Passed(mismatch, matrices, along[:, :, 0], np.zeros(len(x), bool))

    def quick(self, x: Array, parameters: Array, scales: Array, tolerance: float) -> Passed:
        """Integrate in a fifth to a third of the time, with errors of about a tolerance.

        Shapes: x, scales (m, n); parameters (m, n_p).
        """
        if self._steps is None:
            return self.exact(x, parameters, scales)
        states, zero = x * scales, np.zeros(len(x))
        constants = self.flow.constants(parameters, power_of_two(scales))
        change = constants.rates[:, :, self.index]
        carried = self._steps.carry(
            states, zero, 1.0, constants.values, scales, change, tolerance=tolerance
        )
        with np.errstate(invalid="ignore"):
            swings = carried.highest - carried.lowest
            far = (carried.above > far_above(self._bounds, swings)).all(axis=1)
        return Passed(
            (carried.ends - states) / scales,
            carried.matrices * (scales[:, None, :] / scales[:, :, None]),
            carried.vectors * (self.width / scales),
            np.asarray(far & np.isfinite(carried.ends).all(axis=1)),
        )

    def residuals(self, states: Array, parameters: Array, scales: Array) -> Array:
        """Return by how much orbits fail to close by the flow, in scaled states, shape (m,).

        Shapes: states, scales (m, n); parameters (m, n_p).
        """
        zero = np.zeros(len(states))
        constants = self.flow.constants(parameters, power_of_two(scales))
        ends = self.flow.advance(states, zero, zero + 1, constants)
        return np.asarray(np.abs((ends - states) / scales).max(axis=1))
