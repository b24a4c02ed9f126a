"""What may end a mode: functions of the states whose roots are its events."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import heyoka as hy

from slipfold.flow.switched.mode import Status
from slipfold.flow.switched.mode_equations import LOGARITHM, ModeEquations
from slipfold.models.output import Expression, Limit

REST, SLOW = 1e-13, 0.05
"""Slip in the plane, over its size, below which it is at an end, and below which it is slow."""

UNIT = 64.0
"""Logarithms are integrated in this unit: an integrator's errors go with what is largest."""

PHASE, END = hy.expression("phase in slow slip"), hy.expression("phase asked for")
"""Where time goes with a speed the phase is a state."""


class Ending(Enum):
    """Why a motion does not go on in its mode."""

    STOPS = "slip comes to an end"
    SLOWS = "slip in the plane becomes slow"
    QUICKENS = "it becomes fast again"
    ARRIVES = "the phase that was asked for"
    YIELDS = "friction cannot hold any more"
    PARTS = "the normal force vanishes"
    MEETS = "the contact closes"
    LIMIT = "a limit of the model is met"
    STIFF = "too many steps"
    SINGULAR = "no number"


@dataclass(frozen=True)
class Event:
    """A change that a mode may meet."""

    ending: Ending
    which: int  # number of the contact, or of the limit
    expression: Expression  # zero there
    rising: bool = False  # whether it comes from below
    towards: Status = Status.FORTH  # of a contact that yields: how it will slip
    scaled: bool = False  # whether it is over its size already


def events_of(
    mode: ModeEquations, limits: Sequence[Limit], slips: Sequence[Expression]
) -> tuple[Event, ...]:
    """Return the changes that a mode may meet; `slips` are one over the sizes of slips."""
    found = []
    for which, (contact, status) in enumerate(zip(mode.contacts, mode.mode, strict=True)):
        if status is Status.OPEN:
            normal = hy.subs(contact.normal, mode.held)
            found.append(Event(Ending.MEETS, which, normal, rising=True))
            continue
        if contact.opens:
            found.append(Event(Ending.PARTS, which, mode.normal[which]))
        if status is Status.STICK:
            most = mode.normal[which] * hy.subs(contact.holding, mode.held)
            friction = mode.friction[which]
            if len(friction) == 2:
                left = most - hy.sum([part * part for part in friction]) / most
                found.append(Event(Ending.YIELDS, which, left, towards=Status.SLOW))
                continue
            found.append(Event(Ending.YIELDS, which, most - friction[0]))
            found.append(Event(Ending.YIELDS, which, most + friction[0], towards=Status.BACK))
        elif status is Status.SLOW:
            found += _slow_events(which, slips[which])
        elif len(contact.slip) == 2:
            square = hy.subs(hy.sum([part * part for part in contact.slip]), mode.held)
            level = slips[which] ** 2.0 * square - SLOW**2
            found.append(Event(Ending.SLOWS, which, level, scaled=True))
        else:
            slip = hy.subs(contact.slip[0], mode.held)
            found.append(Event(Ending.STOPS, which, slip, rising=status is Status.BACK))
    outputs = dict(mode.equations.outputs)
    return (
        *found,
        *(
            Event(Ending.LIMIT, place, outputs[limit.output] - limit.bound)
            for place, limit in enumerate(limits)
        ),
    )


def _slow_events(which: int, slip: Expression) -> list[Event]:
    """Return what slow slip may meet: its end, its beginning, and the phase asked for."""
    logarithm = LOGARITHM + hy.log(slip)
    return [
        Event(Ending.STOPS, which, (logarithm - math.log(REST)) / UNIT, scaled=True),
        Event(
            Ending.QUICKENS,
            which,
            (logarithm - math.log(2 * SLOW)) / UNIT,
            rising=True,
            scaled=True,
        ),
        Event(Ending.ARRIVES, which, PHASE - END, rising=True, scaled=True),
    ]
