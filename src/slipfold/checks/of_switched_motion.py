"""Periods of a motion through stick and slip, carried again and held against the equations."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from slipfold.checks.checked import Check, Checked
from slipfold.checks.choice import spread
from slipfold.checks.elsewhere import elsewhere
from slipfold.checks.held_legs import FORCES, hold_legs
from slipfold.checks.of_motion import repeated
from slipfold.checks.orbit_difference import ALLOWED
from slipfold.flow.flow import flow_of
from slipfold.flow.switched.sampled import dense_legs
from slipfold.flow.switched.switched_flow import switched_flow_of
from slipfold.flow.trajectory import Trajectory

ONE_IN, HELD_ONE_IN = 20, 200
"""Of so many periods one is carried again, and one is held against the equations, which takes the
time of ten in the plane and of forty on a line; one of each in any case."""


def check_switched_motion(motion: Trajectory) -> Checked:
    """Carry some periods again, with other steps, and hold a few against equations and friction."""
    if not motion.periods or motion.sticking is None:
        return Checked(())
    try:
        with np.errstate(all="ignore"):  # numbers of a wrong motion may overflow
            return Checked((*_held(motion), _again(motion)))
    except KeyboardInterrupt:
        return Checked((), interrupted=True)


def _again(motion: Trajectory) -> Check:
    assert motion.sticking is not None
    flow = switched_flow_of(motion.model)
    constants = flow_of(motion.model).constants_of(motion.model)
    weights = flow.weights(motion.strobe[0], constants)
    count = -(-motion.periods // ONE_IN)
    chosen = np.unique(np.linspace(0, motion.periods - 1, count).astype(int))
    ends = [
        elsewhere(flow, motion.sticking.mode(i), motion.strobe[i], 1.0, constants, weights)[0]
        for i in chosen
    ]
    return repeated(motion, chosen, np.array(ends), "other steps")


def _held(motion: Trajectory) -> Iterable[Check]:
    """Hold the last period, the first and some between them against equations and friction."""
    assert motion.sticking is not None
    flow = switched_flow_of(motion.model)
    constants = flow_of(motion.model).constants_of(motion.model)
    for place in spread(motion.periods)[: -(-motion.periods // HELD_ONE_IN)]:
        state, mode = motion.strobe[place], motion.sticking.mode(place)
        weights = flow.weights(state, constants)
        found = hold_legs(
            flow, dense_legs(motion.model, state, mode, 1.0), state, constants, weights
        )
        time = f"{place * constants.period:.6g} s"
        yield Check(f"the motion from {time} on", "quadrature", found.drift, ALLOWED)
        name = f"friction and its changes from {time} on"
        yield Check(name, "forces", found.forces, FORCES, "forces")
