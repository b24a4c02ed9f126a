"""How far implicit steps lead beside a stiff orbit."""

from __future__ import annotations

import numpy as np

from slipfold.flow.flow import Flow
from slipfold.flow.implicit.steps import End, implicit_motion
from slipfold.flow.implicit.takeover import Takeover
from slipfold.models.turns import without_turns
from slipfold.orbits.periodic_orbit import PeriodicOrbit

PARTS = 8
"""Parts of an orbit, each from a node of its own, so that errors do not grow on the way."""


def implicit_drift(orbit: PeriodicOrbit, flow: Flow) -> float | None:
    """Return by how much they miss where parts end, over the size; None if motion is not stiff."""
    constants = flow.constants_of(orbit.model)
    if not flow.is_stiff(orbit.state, constants):
        return None
    takeover = Takeover(flow, constants)
    count = len(orbit.nodes)
    places = np.arange(0, count, max(1, count // PARTS))
    nodes = orbit.nodes[places] / constants.scales
    phases = np.append(places, count) * (orbit.period / count)
    apart = np.full(nodes.shape, np.inf)
    for row, (state, start, end) in enumerate(zip(nodes, phases, phases[1:], strict=False)):
        motion = implicit_motion(takeover.field, state, start, end)
        if motion.end is not End.ARRIVED:
            break
        following = nodes[(row + 1) % len(nodes)]
        apart[row] = without_turns(
            motion.state - following, orbit.model.whole_turns / constants.scales
        )
    return float(np.abs(apart).max()) / max(1.0, float(np.abs(nodes).max()))
