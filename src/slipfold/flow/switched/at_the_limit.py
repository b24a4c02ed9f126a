"""Contacts that stick at the very limit of their friction: whether they are about to slip.

An event is a root that lies ahead. Where a mode begins at the limit, or rounding beyond it, there
is none, however much more has to be held afterwards.
"""

from __future__ import annotations

import math

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.switched.contact_quantities import ContactsNow
from slipfold.flow.switched.mode import Mode, Status
from slipfold.flow.switched.switched_flow import SwitchedFlow
from slipfold.flow.switched.transition import SLACK, friction_in, next_mode

AT_REST = 1e-12
"""Slip, over its size, that is rounding: a contact that comes to rest with another one."""

NOTHING = 2.0**-100

AHEAD = 1e-6
"""Phases after which a force that grows is larger."""

GROWN = 1e-13
"""Share of what friction holds by which it is then larger than rounding alone makes it."""


def at_rest(flow: SwitchedFlow, mode: Mode, now: ContactsNow, weights: Array) -> list[int]:
    """Return the closed contacts without slip."""
    return [
        contact
        for contact, place in enumerate(flow.quantities.places)
        if mode[contact] is not Status.OPEN
        and math.hypot(*now.slip[place]) * weights[contact] <= AT_REST
    ]


def unlimited(weights: Array, flow: SwitchedFlow, contact: int) -> Array:
    """Return weights with which a contact is held by more than friction.

    Shapes: weights (2 k + limits,).
    """
    weights = weights.copy()
    weights[len(flow.contacts) + contact] *= NOTHING
    return weights


def let_go(
    flow: SwitchedFlow,
    mode: Mode,
    state: Array,
    phase: float,
    constants: Constants,
    weights: Array,
    now: ContactsNow | None = None,
) -> Mode:
    """Return the mode in which contacts slip that stick at their limit and soon beyond it.

    Shapes: state (n,).
    """
    if Status.STICK not in mode or (flow.straight and flow.rested(state, phase, constants)[1]):
        return mode
    places = flow.quantities.places
    now = flow.quantities.at(state, phase, constants) if now is None else now
    rest = at_rest(flow, mode, now, weights)
    friction = friction_in(now, places, mode, rest)
    for contact, place in enumerate(places):
        most = now.holding[contact]
        if mode[contact] is not Status.STICK:
            continue
        if math.hypot(*friction[place]) < most * (1 - SLACK):
            continue
        held = unlimited(weights, flow, contact)
        leg = flow.run(mode, state, phase, phase + AHEAD, constants, held)
        later = flow.quantities.at(leg.state, leg.end, constants)
        ahead = friction_in(later, places, mode, rest)
        grown = math.hypot(*ahead[place]) - later.holding[contact]
        if grown - (math.hypot(*friction[place]) - most) > GROWN * most:
            straight = Status.FORTH if friction[place.start] > 0 else Status.BACK
            slips = Status.SLOW if place.stop - place.start == 2 else straight
            return next_mode(now, places, mode, rest, {contact: slips})
    return mode
