"""How often the angles of an orbit turn round."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.models.model import Model
from slipfold.models.turns import turns_between


def turns_of_segments(
    model: Model, flow: Flow, nodes: Array, period: int, constants: Constants
) -> Array:
    """Return by how many whole turns segments of orbits end ahead of the next node.

    Shapes: nodes (k, m, n); returns (k, m, n), zero for what is no angle.
    """
    if not model.whole_turns.any():
        return np.zeros(nodes.shape)
    count, segments = nodes.shape[:2]
    edges = np.linspace(0, period, segments + 1)
    start, end = np.tile(edges[:-1], count), np.tile(edges[1:], count)
    ends = flow.advance(
        nodes.reshape(count * segments, -1), start, end, constants.repeated(segments)
    )
    return turns_between(ends.reshape(nodes.shape) - np.roll(nodes, -1, axis=1), model.whole_turns)
