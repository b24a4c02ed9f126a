"""The right-hand side of a model at all collocation points, in scaled states."""

from __future__ import annotations

from functools import cached_property
from typing import Protocol

import numpy as np

from slipfold.arrays import Array
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model


class RightHandSide(Protocol):
    """What collocation needs to know of a model: see `VectorField.linear`."""

    turns: Array
    """Whole turns of angles in scaled states, zero for other states."""

    def linear(self, states: Array, phases: Array) -> tuple[Array, Array]:
        """Evaluate rates and Jacobians."""
        ...


class VectorField:
    """Rates of the scaled states and their Jacobians, each many at a time."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.scales = model.state_scales()
        self.turns = model.whole_turns / self.scales
        self.forced = model.forced
        self._evaluation = evaluation_of(model)
        self._ratios = self.scales[None, :] / self.scales[:, None]

    @cached_property
    def period(self) -> float:
        """Forcing period in seconds, or the model's value of the duration of one round."""
        return self._evaluation.period(self.model)

    def linear(self, states: Array, phases: Array) -> tuple[Array, Array]:
        """Evaluate rates and Jacobians.

        Shapes: states (..., n); phases (...); returns rates (..., n), jacobians (..., n, n).
        """
        rates, jacobians = self._evaluation.linear(
            self.model, states * self.scales, phases - np.floor(phases)
        )
        return rates / self.scales, jacobians * self._ratios
