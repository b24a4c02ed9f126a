"""Thresholds of a map, computed again by other means."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from slipfold.checks.checked import Checked
from slipfold.checks.choice import Candidate, check_some, spread
from slipfold.flow.flow import flow_of
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.text.one_line import parameter_text
from slipfold.thresholds.threshold_map import GridThresholds

COST, FOLLOWED = 0.1, 6.0
"""Work for a threshold, and for one whose whole response was followed, in points of a branch of
period 1, as measured."""

LEAST = 12.0
"""Work that a map counts as having taken, however small: one orbit is checked by collocation."""

SEGMENTS = 8
"""Parts into which an orbit is cut that is known by its state at phase zero."""


def check_thresholds(found: GridThresholds) -> Checked:
    """Check the orbits at some thresholds and that one of their multipliers is -1 there.

    The highest threshold and the lowest come first, then those between. Whoever interrupted the map
    does not wait for checks.
    """
    if found.interrupted:
        return Checked((), interrupted=True)
    followed = int(found.followed.sum())
    points = COST * (found.values.size - followed) + FOLLOWED * followed
    return check_some(_candidates(found), max(points, LEAST))


def _candidates(found: GridThresholds) -> Iterator[Candidate]:
    known = np.argwhere(np.isfinite(found.values))
    ordered = known[np.argsort(found.values[tuple(known.T)], kind="stable")]
    for place in spread(len(ordered)) if len(ordered) else ():
        first, second = ordered[place].tolist()
        model = found.model_at(first, second)
        at = ", ".join(
            parameter_text(model.parameter(name), model.values[name])
            for name in (found.threshold, *found.axes)
        )
        yield Candidate(f"{found.type} at {at}", _orbit(found, first, second), resting=False)


def _orbit(found: GridThresholds, first: int, second: int) -> PeriodicOrbit:
    """The orbit at a threshold; its critical multiplier is what it is said to be."""
    model = found.model_at(first, second)
    flow = flow_of(model)
    constants = flow.constants_of(model)
    whole = np.array([0.0]), np.array([1.0])
    state = found.states[first, second]
    nodes = flow.sample(state[None], *whole, SEGMENTS, constants)[0]
    multipliers = found.multipliers[first, second].copy()
    multipliers[np.argmin(np.abs(multipliers + 1))] = -1
    return PeriodicOrbit(model, 1, nodes, multipliers, float(found.residuals[first, second]))
