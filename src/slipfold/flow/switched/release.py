"""How slip in the plane begins: along the force that was needed, and along a series at first.

Where static friction is more than kinetic, slip grows at once. Where it is not, slip grows with
the square of the time, and its direction is held by friction the more firmly the slower it is:
explicit steps from zero would never end. A first short time is therefore taken by quadrature of
the rate at which slip grows in the direction that friction gives it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.equations import Constants
from slipfold.flow.switched.events import REST
from slipfold.flow.switched.mode import Mode, Status
from slipfold.flow.switched.switched_flow import Leg, SwitchedFlow
from slipfold.flow.switched.transition import Undecided, outward, response

__all__ = ["release"]

Array = NDArray[np.float64]

AT_ONCE = 1e-3
"""Rate of slip, over what friction can do, that is no small one."""

NOTHING = 2.0**-100

INSTANT, FIRST = 1e-13, 5e-5
"""Phases taken for the beginning of slip: where it grows at once, and where it does not."""


@dataclass(frozen=True, eq=False)
class _Growth:
    """How slip grows at an instant."""

    along: Array  # direction, shape (2,)
    rate: float
    most: float  # rate that friction alone could give
    friction: float
    change: Array  # of the rate of slip with friction, shape (2, 2)


def release(
    flow: SwitchedFlow,
    mode: Mode,
    contact: int,
    state: Array,
    phase: float,
    constants: Constants,
    weights: Array,
    *,
    dense: bool = False,
) -> list[Leg]:
    """Let a contact that is at rest go; return the first pieces of its slip.

    Shapes: state (n,).
    """
    begins = _growth(flow, mode, contact, state, phase, constants)
    if begins.rate > AT_ONCE * begins.most:
        speed = max(begins.rate * INSTANT * constants.period, 20 * REST / weights[contact])
        after = flow.slipping(mode, state, speed * begins.along, constants)
        nothing = np.zeros((2, len(flow.contacts)))
        return [Leg(mode, phase, phase, after, nothing, None)]
    stuck = tuple(Status.STICK if i == contact else item for i, item in enumerate(mode))
    legs, growths = list[Leg](), [begins]
    # For this short time the contact is held by more than friction: its limit weighs nothing.
    weights = weights.copy()
    weights[len(flow.contacts) + contact] *= NOTHING
    for end in (phase + FIRST / 2, phase + FIRST):
        last = legs[-1] if legs else None
        leg = flow.run(
            stuck,
            state if last is None else last.state,
            phase if last is None else last.end,
            end,
            constants,
            weights,
            dense=dense,
        )
        if leg.event is not None:
            raise Undecided("two contacts change while one of them begins to slip")
        legs.append(replace(leg, mode=mode, held=stuck))
        growths.append(_growth(flow, mode, contact, leg.state, leg.end, constants))
    # What turns slip is its speed times the rate of its angle; both are known well enough.
    time = FIRST * constants.period
    first, last_one = begins.along, growths[-1].along
    angle = np.arctan2(first[0] * last_one[1] - first[1] * last_one[0], first @ last_one)
    turns = [0.5 * growths[-1].rate * part * part * angle for part in (0.5, 1.0)]
    growths[1:] = [
        _growth(flow, mode, contact, leg.state, leg.end, constants, turn)
        for leg, turn in zip(legs, turns, strict=True)
    ]
    zero, half, whole = (item.rate * item.along for item in growths)
    slip = time / 6 * (zero + 4 * half + whole)
    if not slip @ growths[-1].along > 0:
        raise Undecided("slip begins against its own friction")
    after = flow.slipping(mode, legs[-1].state, slip, constants)
    energies = legs[1].energies.copy()
    # Friction was less than what would have held by what lets slip grow.
    now, place = flow.quantities.at(state, phase, constants), flow.quantities.places[contact]
    heat = growths[-1].friction * float(np.linalg.norm(slip)) * time / 3
    driven = float(np.linalg.solve(growths[-1].change, slip) @ now.plate[place])
    energies[:, contact] += driven - heat, heat
    return [legs[0], replace(legs[1], state=after, energies=energies)]


def _growth(
    flow: SwitchedFlow,
    mode: Mode,
    contact: int,
    state: Array,
    phase: float,
    constants: Constants,
    turn: float = 0.0,
) -> _Growth:
    now, places = flow.quantities.at(state, phase, constants), flow.quantities.places
    rest = [i for i, status in enumerate(mode) if status is Status.STICK or i == contact]
    alone, change = response(now, places, mode, rest, contact)
    size = float(now.starting[contact])
    along, rate = outward(alone, change, size, turn)
    return _Growth(along, rate, size * float(np.abs(change).max()), size, change)
