"""A switched motion at any of its instants: states, what contacts do there, and outputs."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.flow import flow_of
from slipfold.flow.switched.events import Ending
from slipfold.flow.switched.mode import Mode, Status
from slipfold.flow.switched.switched_flow import Leg, SwitchedFlow, switched_flow_of
from slipfold.flow.switched.switched_motion import Broken, legs
from slipfold.models.model import Model

TOUCHES = 1e-7
"""Slip, over its size, that is as good as none: what follows is as far beside as is taken away."""


class Samples:
    """States at some phases, with the modes in which they are."""

    def __init__(self, model: Model, states: Array, phases: Array, modes: list[Mode]) -> None:
        self.states = states  # shape (m, n)
        self._model, self._phases, self._modes = model, phases, modes

    def outputs(self) -> Array:
        """Return all outputs there, the states first, shape (m, n_outputs)."""
        flow, constants = switched_flow_of(self._model), flow_of(self._model).constants_of
        known, found = constants(self._model), None
        for mode in dict.fromkeys(self._modes):
            chosen = np.array([item == mode for item in self._modes])
            values = flow.of(mode).outputs(self.states[chosen], self._phases[chosen], known)
            if found is None:
                found = np.empty((len(self.states), values.shape[1]))
            found[chosen] = values
        assert found is not None
        return found


def dense_legs(model: Model, state: Array, mode: Mode, end: float) -> Iterator[Leg]:
    """Carry a state from phase zero to another, with all that lies between.

    A motion that cannot go on ends there; where slip in the plane touches zero it goes on from
    rest.
    """
    flow = switched_flow_of(model)
    constants = flow_of(model).constants_of(model)
    weights = flow.weights(state, constants)
    phase, ahead = 0.0, True
    while ahead:
        ahead = False
        try:
            for leg, _ in legs(flow, mode, state, end, constants, weights, begin=phase, dense=True):
                yield leg
        except Broken as broken:
            if (last := broken.leg) is None:
                return
            yield last
            resting = _touches(flow, last, constants, weights)
            if resting is not None and phase < last.end < end:
                mode, phase, ahead = resting, last.end, True
                state = flow.held(mode, last.state, phase, constants)


def _touches(flow: SwitchedFlow, leg: Leg, constants: Constants, weights: Array) -> Mode | None:
    """Return the mode at rest of slip that turns too fast to follow, None if it does not rest."""
    stiff = leg.event is not None and leg.event.ending is Ending.STIFF
    if not stiff or Status.SLOW not in leg.mode:
        return None
    contact, now = leg.mode.index(Status.SLOW), flow.quantities.at(leg.state, leg.end, constants)
    speed = math.hypot(*now.slip[flow.quantities.places[contact]]) * weights[contact]
    resting = (*leg.mode[:contact], Status.STICK, *leg.mode[contact + 1 :])
    return resting if speed < TOUCHES else None


def sample_switched(model: Model, state: Array, mode: Mode, phases: Array) -> Samples:
    """Carry a state from phase zero along increasing phases. Shapes: state (n,); phases (m,)."""
    states = np.full((len(phases), len(state)), np.nan)
    modes = [mode] * len(phases)
    scales = flow_of(model).constants_of(model).scales
    done, last, doing = 0, state, mode
    for leg in dense_legs(model, state, mode, float(phases[-1])):
        arrived = leg.event is None and leg.end >= phases[-1]
        upto = len(phases) if arrived else int(np.searchsorted(phases, leg.end))
        if upto > done:
            if leg.polynomials is None:
                states[done:upto] = leg.state
            else:
                states[done:upto] = leg.polynomials(phases[done:upto])[:, : len(state)] * scales
            modes[done:upto] = [leg.seen] * (upto - done)
        done, last, doing = max(done, upto), leg.state, leg.seen
    # Where the last leg ends in an event at the last of the phases, no other one follows.
    states[done:], modes[done:] = last, [doing] * (len(phases) - done)
    return Samples(model, states, phases, modes)
