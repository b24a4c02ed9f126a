"""Slip and stick in turn: most of what a contact along a line does that is the only one.

Nothing else can change where it stops and friction clearly holds it, or where it yields. Whatever
is less clear is left to those who look closely.
"""

from __future__ import annotations

from collections.abc import Callable

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.switched.history import Recorder
from slipfold.flow.switched.mode import STUCK, Mode
from slipfold.flow.switched.ready_mode import ARRIVED, STEPS
from slipfold.flow.switched.switched_flow import SwitchedFlow

MOST = 1_000
"""Legs in a period of which none is looked at more closely."""


def in_turn(
    flow: SwitchedFlow,
    mode: Mode,
    state: Array,
    phase: float,
    further: float,
    constants: Constants,
    weights: Array,
    recorder: Recorder,
    ended: Callable[[Mode, Array], None],
) -> tuple[Mode, Array, float]:
    """Carry a state to the end of a period, or to where a closer look is due.

    A leg with constant rates may go somewhat further than that end, of which `ended` is told then.
    Nothing is made for a leg but what is noted. Shapes: state (n,).
    """
    # An event is a root that lies ahead: what begins at its limit may be beyond it already.
    if phase < 1 and mode == STUCK and not flow.rested(state, phase, constants)[1]:
        return mode, state, phase
    for _ in range(MOST):
        if phase >= 1:
            break
        ready = flow.ready(mode, constants, weights)
        compiled, integrator = ready.compiled, ready.integrator
        ready.set_out(state, phase)
        until = 1 + further if compiled.steady else 1.0
        outcome = int(integrator.propagate_until(until, STEPS)[0])
        after = mode if outcome == ARRIVED else compiled.follows.get(outcome)
        if after is None:
            break
        end, (final, energies) = integrator.time, ready.arrived()
        if after is STUCK:
            speed, holds = flow.rested(final, end, constants)
            if not holds:
                break
            final[flow.rests_by[0]] = speed
        elif not compiled.rests:
            final = flow.held(mode, final, end, constants)
        recorder.went_on(energies)
        if end > 1:
            ended(mode, state + (1 - phase) / (end - phase) * (final - state))
        if after is not mode:
            recorder.changed(end, final, after)
        state, phase, mode = final, end, after
    return mode, state, phase
