"""Extrema of outputs over what a motion has come to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipfold.flow import flow_of
from slipfold.flow.trajectory import Trajectory
from slipfold.orbits.extrema import Extrema, find_extrema

SEEN = 256
"""Periods that are looked at of a motion that has not settled."""

SAMPLES = 1024
"""Samples a period of a motion that sticks."""


def steady_extrema(motion: Trajectory, names: Sequence[str]) -> Extrema:
    """Find extrema over the orbit that a motion settled on, or else over its last periods.

    It has a whole period at least.
    """
    settlement = motion.settlement
    count = motion.steady_periods(1 if settlement.settled else SEEN)
    columns = [flow_of(motion.model).output_index(name) for name in names]
    if motion.sticking is not None:
        values = motion.steady_outputs(count, SAMPLES)[:, columns]
        return Extrema(tuple(names), values.min(axis=0)[None], values.max(axis=0)[None])
    model = motion.steady_model
    # A round of a cycle takes no whole number of intervals, so that it begins at the last state.
    cycle = settlement.duration is not None
    nodes = motion.strobe[-1:] if cycle else motion.strobe[-1 - count : -1]
    found = find_extrema(model, model.vector[None], nodes[None], len(nodes), names)
    if settlement.settled:
        return found
    # What does not close may be least or greatest where it begins, which nothing precedes.
    values = motion.steady_outputs(count, 1)[:, columns]
    low = np.minimum(found.minimum, values.min(axis=0))
    return Extrema(found.names, low, np.maximum(found.maximum, values.max(axis=0)))
