"""What errors of states are to be small beside: of a state that nothing feeds, its own size."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.flow import flow_of
from slipfold.flow.sizes.unfed import unfed_groups
from slipfold.models.model import Model


def own_sizes(model: Model, states: Array) -> Array:
    """Return the sizes of unfed groups, and for all other states the largest of all scaled ones.

    Shapes: states (..., n); returns (..., n).
    """
    scales = model.state_scales()
    scaled = np.abs(states / scales)
    sizes = np.maximum(1.0, np.broadcast_to(scaled.max(axis=-1, keepdims=True), states.shape))
    for group in map(list, unfed_states(model)):
        sizes[..., group] = scaled[..., group].max(axis=-1, keepdims=True)
    return np.asarray(sizes * scales)


def unfed_states(model: Model) -> list[tuple[int, ...]]:
    """Return the groups of states that nothing feeds at the values that the parameters have."""
    flow, scales = flow_of(model), model.state_scales()
    constants = flow.constants_of(model)

    def rates(states: Array) -> Array:
        phases = np.resize([0.1, 0.3, 0.6, 0.8], len(states))
        return flow.rates(states * scales, phases, constants)

    return unfed_groups(rates, len(scales))
