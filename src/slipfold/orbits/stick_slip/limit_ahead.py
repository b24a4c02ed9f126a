"""Limits of a model that orbits through stick and slip come to: motions that meet one end there."""

from __future__ import annotations

import numpy as np

from slipfold.flow.switched.mode_equations import Undetermined
from slipfold.flow.switched.switched_motion import Broken
from slipfold.flow.switched.transition import Undecided
from slipfold.orbits.discretisations.switched_shooting import SwitchedShooting
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.orbit_point import OrbitPoint

AHEAD = 1e-6
"""Arclength beyond the last orbit that is tried: a thousand times the shortest step, so that a
limit that ended the steps is met clearly; the limit lies no farther."""

BESIDE = 1e-3
"""Distance from the last orbit, in scaled states, within which its own limit is met: it grows as
the square root of `AHEAD` at most, unless a contact is caught and another motion comes to one."""


def limit_ahead(orbits: Orbits, last: OrbitPoint) -> str | None:
    """Return the sentence of the limit that orbits meet just beyond the last one, None if none.

    No orbit meets it, and so nothing along the curve changes its sign. But a motion from where the
    next orbit is expected does.
    """
    by, expected = orbits.by, last.z + AHEAD * last.tangent
    if not isinstance(by, SwitchedShooting) or not by.switched.limits:
        return None
    nodes, constants = orbits.nodes(expected), orbits.constants(expected)
    for node, begin, end in zip(nodes, by.start, by.end, strict=True):
        try:
            by.motion(node, float(begin), float(end), constants)
        except Broken as broken:
            return broken.stop.reason if _is_at_limit(broken, orbits, last) else None
        except (Undecided, Undetermined):
            return None
    return None


def _is_at_limit(broken: Broken, orbits: Orbits, last: OrbitPoint) -> bool:
    """Whether a motion ends at a limit, and beside the last orbit."""
    by, leg = orbits.by, broken.leg
    assert isinstance(by, SwitchedShooting)
    if leg is None or broken.stop.kind not in {limit.name for limit in by.switched.limits}:
        return False
    at = np.array([leg.end])
    state = by.states(orbits.nodes(last.z), orbits.constants(last.z), at)[0]
    return float(np.linalg.norm((leg.state - state) / by.scales)) < BESIDE
