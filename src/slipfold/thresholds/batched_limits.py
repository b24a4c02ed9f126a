"""Whether many orbits of period 1, each with parameters of its own, keep the model's limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.flow import Flow
from slipfold.flow.equations import Constants
from slipfold.flow.scaled import power_of_two
from slipfold.models.model import Model
from slipfold.orbits.forced_orbits import ForcedOrbits
from slipfold.orbits.limits import far_above, limit_margins

__all__ = ["keep_limits"]

Array = NDArray[np.float64]

LOOKS = (32, 128)
"""Samples of the first look and of a second one where the first does not settle it."""

ROWS = 512
"""Orbits looked at together: enough to hide the cost of a call, few enough for the cache."""


def keep_limits(flow: Flow, model: Model, states: Array, parameters: Array) -> NDArray[np.bool_]:
    """Return whether each orbit stays above all bounds of the model, shape (m,).

    Each is sampled. Between samples an output falls below them by no more than the bend there
    allows; where that could matter, the continuous orbit is searched.

    Shapes: states (m, n); parameters (m, n_p).
    """
    if not model.limits:
        return np.full(len(states), True)
    result = np.full(len(states), False)
    scales = power_of_two(model.state_scales())
    near = np.flatnonzero(np.isfinite(states).all(axis=1))
    for samples in LOOKS:
        for first in range(0, len(near), ROWS):
            some = near[first : first + ROWS]
            constants = flow.constants(parameters[some], scales)
            result[some] = _are_far(flow, model, states[some], constants, samples)
        near = near[~result[near]]
    for i in near:
        result[i] = _keeps_limits(flow, model, states[i], parameters[i])
    return result


def _are_far(
    flow: Flow, model: Model, states: Array, constants: Constants, count: int
) -> NDArray[np.bool_]:
    m = len(states)
    zero = np.zeros(m)
    samples = flow.sample(states, zero, zero + 1, count, constants)
    phases = np.tile(np.arange(count) / count, m)
    outputs = flow.outputs(samples.reshape(m * count, -1), phases, constants.repeated(count))
    columns = [flow.output_index(limit.output) for limit in model.limits]
    watched = outputs[:, columns].reshape(m, count, -1)
    # A corner between two samples lies at most half their second difference below them.
    bend = np.roll(watched, 1, axis=1) - 2 * watched + np.roll(watched, -1, axis=1)
    lowest = (watched - np.maximum(bend, 0.0)).min(axis=1)
    bounds = np.array([limit.bound for limit in model.limits])
    far = far_above(bounds, np.ptp(watched, axis=1))
    return np.asarray((lowest > far).all(axis=1), dtype=bool)


def _keeps_limits(flow: Flow, model: Model, state: Array, parameters: Array) -> bool:
    names = [parameter.name for parameter in model.parameters]
    values = dict(zip(names, parameters.tolist(), strict=True))
    try:
        orbits = ForcedOrbits(model.replace(**values), {names[0]: 1.0})
    except InputError:  # parameters that contradict each other
        return False
    zero = np.zeros(1)
    constants = flow.constants(parameters, orbits.flow_scales)
    nodes = flow.sample(state[None], zero, zero + 1, orbits.segments, constants)[0]
    return bool((limit_margins(orbits, orbits.pack(nodes, values[names[0]])) > 0).all())
