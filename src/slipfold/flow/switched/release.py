"""How slip in the plane begins: along the force that was needed, and along a series at first.

Where static friction is more than kinetic, slip grows at once. Where it is not, slip grows with
the square of the time, and its direction is held by friction the more firmly the slower it is:
explicit steps from zero would never end. A first short time is therefore taken by quadrature of
the rate at which slip grows in the direction that friction gives it. Where a period ends in it,
the rest of it follows in the next one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.dense_motion import StepPolynomials
from slipfold.flow.equations import Constants
from slipfold.flow.switched.at_the_limit import unlimited
from slipfold.flow.switched.events import REST
from slipfold.flow.switched.mode import Mode, Status
from slipfold.flow.switched.step_polynomials import BegunPolynomials
from slipfold.flow.switched.switched_flow import Leg, SwitchedFlow
from slipfold.flow.switched.transition import (
    SLACK,
    Undecided,
    largest,
    outward,
    response,
)

__all__ = ["FIRST", "begins", "direction_of_release", "release"]

Array = NDArray[np.float64]

AT_ONCE = 1e-3
"""Rate of slip, over what friction can do, that is no small one."""

INSTANT, FIRST = 1e-13, 1e-4
"""Phases taken for the beginning of slip: where it grows at once, and where it does not."""

LEAST = 1e-9
"""Phases in which what has begun to slip has not come anywhere yet."""

LEAST_SEEN = 1e-11
"""Slip over its size that is shown at least where it begins."""

BEGUN = 1e-6
"""Slip over its size, below which it may still be beginning."""


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
    end: float,
    *,
    dense: bool = False,
) -> list[Leg]:
    """Let a contact that is at rest go, or has just begun to; return the first pieces of its slip.

    None of them goes beyond the phase `end`. Shapes: state (n,).
    """
    first = _growth(flow, mode, contact, state, phase, constants)
    known, place = flow.quantities.at(state, phase, constants), flow.quantities.places[contact]
    before = np.array(known.slip[place])
    if first.rate > AT_ONCE * first.most:
        speed = max(first.rate * INSTANT * constants.period, 20 * REST / weights[contact])
        if np.linalg.norm(before) >= speed:  # it has begun already
            return []
        after = flow.slipping(mode, state, speed * first.along, phase, constants)
        nothing = np.zeros(2 * len(flow.contacts))
        return [Leg(mode, phase, phase, after, nothing, None, released=True)]
    stuck = tuple(Status.STICK if i == contact else item for i, item in enumerate(mode))
    legs, growths = list[Leg](), [first]
    # For this short time the contact is held by more than friction: its limit weighs nothing.
    weights = unlimited(weights, flow, contact)
    length = min(FIRST, end - phase)
    for until in (phase + length / 2, phase + length):
        last = legs[-1] if legs else None
        leg = flow.run(
            stuck,
            state if last is None else last.state,
            phase if last is None else last.end,
            until,
            constants,
            weights,
            dense=dense,
        )
        if leg.event is not None:
            raise Undecided("two contacts change while one of them begins to slip")
        legs.append(replace(leg, mode=mode, held=stuck, released=True))
        growths.append(_growth(flow, mode, contact, leg.state, leg.end, constants))
    if length < LEAST:
        return legs
    # What turns slip is its speed times the rate of its angle; both are known well enough.
    time = length * constants.period
    one, other = first.along, growths[-1].along
    angle = np.arctan2(one[0] * other[1] - one[1] * other[0], one @ other)
    turns = [np.linalg.norm(slip) * angle / time for slip in _slips(before, growths, time)]
    growths[1:] = [
        _growth(flow, mode, contact, leg.state, leg.end, constants, turn)
        for leg, turn in zip(legs, turns, strict=True)
    ]
    middle, slip = _slips(before, growths, time)
    if not slip @ growths[-1].along > 0:
        raise Undecided("slip begins against its own friction")
    after = flow.slipping(mode, legs[-1].state, slip, legs[-1].end, constants)
    least = LEAST_SEEN / weights[contact]
    legs = [_seen(flow, leg, _Slip(before, growths, phase, time, least), constants) for leg in legs]
    energies = legs[1].energies.copy()
    given = energies.reshape(2, -1)
    # Friction was less than what would have held by what lets slip grow.
    speeds = [float(np.linalg.norm(item)) for item in (before, middle, slip)]
    heat = growths[-1].friction * (speeds[0] + 4 * speeds[1] + speeds[2]) * time / 6
    driven = float(np.linalg.solve(growths[-1].change, slip - before) @ known.plate[place])
    given[:, contact] += driven - heat, heat
    return [legs[0], replace(legs[1], state=after, energies=energies)]


@dataclass(frozen=True, eq=False)
class _Slip:
    """Slip while it begins: its rate is a parabola through three that are known."""

    before: Array  # shape (2,)
    growths: list[_Growth]
    begin: float  # phase
    time: float  # in s until the last of them
    least: float  # slower slip has too few digits for its direction

    def at(self, share: float) -> Array:
        """Return slip after a share of the time, shape (2,)."""
        zero, half, whole = (item.rate * item.along for item in self.growths)
        rises, bends = 4 * half - 3 * zero - whole, zero - 2 * half + whole
        mean = zero + share * rises / 2 + share**2 * bends / 1.5
        slip = self.before + self.time * share * mean
        speed = float(np.linalg.norm(slip))
        return slip if speed > self.least else self.least * self.growths[0].along


def _seen(flow: SwitchedFlow, leg: Leg, slip: _Slip, constants: Constants) -> Leg:
    """Return a piece, in which the contact is held, with slip in what lies between its ends."""
    if not isinstance(leg.polynomials, StepPolynomials):
        return leg
    unit = constants.period / slip.time

    def placed(scaled: Array, phase: float) -> Array:
        state, slips = scaled * constants.scales, slip.at((phase - slip.begin) * unit)
        return flow.slipping(leg.mode, state, slips, phase, constants) / constants.scales

    held = flow.places_held(leg.mode)
    return replace(leg, polynomials=BegunPolynomials(leg.polynomials, len(leg.state), placed, held))


def begins(
    flow: SwitchedFlow,
    mode: Mode,
    contact: int,
    state: Array,
    phase: float,
    constants: Constants,
    weights: Array,
) -> bool:
    """Whether the slow slip of a contact is still beginning. Shapes: state (n,)."""
    slip = flow.quantities.at(state, phase, constants).slip[flow.quantities.places[contact]]
    if math.hypot(*slip) * weights[contact] > BEGUN:
        return False
    growth = _growth(flow, mode, contact, state, phase, constants)
    return growth.rate > -SLACK * growth.most


def _slips(before: Array, growths: list[_Growth], time: float) -> tuple[Array, Array]:
    """Return slip in the middle and at the end of a time, by the rates at both and before."""
    zero, half, whole = (item.rate * item.along for item in growths)
    middle = before + time / 24 * (5 * zero + 8 * half - whole)
    return middle, before + time / 6 * (zero + 4 * half + whole)


def direction_of_release(
    flow: SwitchedFlow, mode: Mode, contact: int, state: Array, phase: float, constants: Constants
) -> Array:
    """Return the direction in which a contact at rest begins to slip, shape (2,).

    Shapes: state (n,).
    """
    return _growth(flow, mode, contact, state, phase, constants).along


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
    size = now.starting[contact]
    along, rate = outward(alone, change, size, turn)
    return _Growth(np.array(along), rate, size * largest(change), size, np.array(change))
