"""Starts released at some phase of the forcing: their states at the next phase zero."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import Stop, guarded_flow_of
from slipfold.flow.switched.mode import shown
from slipfold.flow.switched.simulate import comes_to_rest, told_in_slip
from slipfold.flow.switched.switched_flow import switched_flow_of
from slipfold.flow.switched.switched_motion import Broken, first_mode, legs
from slipfold.models.model import Model


def released(model: Model, starts: Array, phases: Array) -> tuple[Array, dict[int, Stop]]:
    """Return the states at the end of the period, and why motions ended before, by their place.

    These are no numbers. Contacts may stick on the way. Shapes: starts (k, n); phases (k,), from
    0 to 1; returns (k, n).
    """
    found, stops = starts.copy(), dict[int, Stop]()
    constants, guarded = flow_of(model).constants_of(model), guarded_flow_of(model)
    # Elsewhere contacts may stick at any time.
    sticks = not told_in_slip(model, starts, constants)
    for place in np.flatnonzero((phases > 0) & (phases < 1)):
        state, phase = starts[place], float(phases[place])
        stop: Stop | None = None
        if not sticks:
            states, stop, _ = guarded.released(state, phase, constants)
            if stop is None:
                found[place] = states[-1]
                continue
        if sticks or comes_to_rest(stop, model):
            try:
                found[place] = _through_stick(model, state, phase)
                continue
            except Broken as broken:
                time = (broken.stop.time - phase) * constants.period
                stop = replace(broken.stop, time=time)
        assert stop is not None
        found[place], stops[int(place)] = np.nan, stop
    return found, stops


def _through_stick(model: Model, state: Array, phase: float) -> Array:
    """Carry a state to the end of the period, from event to event. Shapes: state (n,)."""
    flow, constants = switched_flow_of(model), flow_of(model).constants_of(model)
    weights = flow.weights(state, constants)
    mode = first_mode(flow, state, constants, weights, phase)
    state = flow.held(shown(mode), state, phase, constants)
    for leg, _ in legs(flow, mode, state, 1.0, constants, weights, begin=phase):
        state = leg.state
    return state
