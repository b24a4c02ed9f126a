"""How slip begins: which contacts leave stick at its limit, and how slip in the plane grows.

Where static friction is more than kinetic, slip grows at once. Where it is not, slip grows with
the square of the time, and a first hundredth of a period or so is a polynomial.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.batches import ROUNDING, TOLERANCE
from slipfold.flow.contact_state import (
    SLACK,
    ContactsNow,
    Undecided,
    friction_in,
    largest,
    many,
    next_mode,
    outward,
    response,
)
from slipfold.flow.hybrid_flow import HybridSystem, SmoothPhase
from slipfold.flow.intervals import Field
from slipfold.flow.modes import REST, Mode, Status, shown
from slipfold.flow.polynomials import BegunPolynomials
from slipfold.flow.slip_onset import POINTS, SlipOnset, solve_onset
from slipfold.flow.stage_equations import LinearPart

SHORT = 1e-6
"""Phases, and slip over its size, that are short: a force that grows is larger after them, slip may
still be beginning, and no onset is shorter."""


def at_rest(system: HybridSystem, mode: Mode, now: ContactsNow) -> list[int]:
    """Return the closed contacts without slip."""
    return [
        contact
        for contact, place in enumerate(system.places)
        if mode[contact] is not Status.OPEN
        and math.hypot(*now.slip[place]) * system.weights[contact] <= ROUNDING
    ]


def released_at_limit(
    system: HybridSystem, mode: Mode, state: Array, phase: float, now: ContactsNow | None = None
) -> Mode:
    """Return the mode in which contacts slip that stick at their limit and soon beyond it.

    Shapes: state (n,).
    """
    flow = system.flow
    if Status.STICK not in mode:
        return mode
    if flow.straight and flow.stuck.rest(state, phase, system.constants)[1]:
        return mode
    places = system.places
    now = system.at(state, phase) if now is None else now
    rest = at_rest(system, mode, now)
    friction = friction_in(now, places, mode, rest)
    for contact, place in enumerate(places):
        most = now.holding[contact]
        if mode[contact] is not Status.STICK:
            continue
        if math.hypot(*friction[place]) < most * (1 - SLACK):
            continue
        part = system.without_limit(contact).run(mode, state, phase, phase + SHORT)
        later = system.at(part.state, part.end)
        ahead = friction_in(later, places, mode, rest)
        grown = math.hypot(*ahead[place]) - later.holding[contact]
        if grown - (math.hypot(*friction[place]) - most) > TOLERANCE * most:
            straight = Status.FORTH if friction[place.start] > 0 else Status.BACK
            slips = Status.SLOW if place.stop - place.start == 2 else straight
            return next_mode(now, places, mode, rest, {contact: slips})
    return mode


AT_ONCE = 1e-3
"""Rate of slip, over what friction can do, at or above which it begins at once."""

INSTANT, FIRST = 1e-13, 0.01
"""Phases taken for the onset of slip: where it grows at once, and at most where it does not."""

SHRINKS = 0.3
"""Fraction of a time to continue with that was too long."""

TERMS = 25.0
"""Terms of the series in which slip grows that fall, at the end of its onset: so many leave an
explicit integrator four steps until it is quick enough not to be stiff."""


@dataclass(frozen=True, eq=False)
class _Growth:
    """How slip grows at an instant."""

    along: Array  # direction, shape (2,)
    rate: float
    most: float  # rate that friction alone could give
    change: Array  # of the rate of slip with friction, shape (2, 2)


def release(
    system: HybridSystem,
    mode: Mode,
    contact: int,
    state: Array,
    phase: float,
    end: float,
    *,
    dense: bool = False,
) -> list[SmoothPhase]:
    """Let a contact that is at rest go, or has just begun to; return the first pieces of its slip.

    None of them goes beyond the phase `end`. Shapes: state (n,).
    """
    flow, constants, weights = system.flow, system.constants, system.weights
    first = _growth(system, mode, contact, state, phase)
    before = _slip(system, contact, state, phase)
    if first.rate > AT_ONCE * first.most:
        speed = max(first.rate * INSTANT * constants.period, 20 * REST / weights[contact])
        if np.linalg.norm(before) >= speed:  # it has begun already
            return []
        after = system.slipping(mode, state, speed * first.along, phase)
        return [SmoothPhase(mode, phase, phase, after, flow.no_energies(), None, released=True)]
    onset = _onset(system, mode, contact, state, phase, first, before)
    until = min(end, onset.end)
    known = many(onset.stages, onset.phases, constants)
    powers = np.array(flow.mode(shown(mode)).powers(known)).T
    powers[:, [contact, len(mode) + contact]] += _corrected(system, contact, onset, first)
    energies = onset.integrals(until) @ powers
    seen = _shown_onset(system, mode, contact, onset, first.along, until) if dense else None
    after = system.held(mode, onset.at(until), until)
    return [SmoothPhase(mode, phase, until, after, energies, None, True, onset, seen)]


def _onset(
    system: HybridSystem,
    mode: Mode,
    contact: int,
    state: Array,
    phase: float,
    first: _Growth,
    before: Array,
) -> SlipOnset:
    """Return how slip that grows slowly begins, for as long as a polynomial does for it."""
    stuck = tuple(Status.STICK if i == contact else item for i, item in enumerate(mode))
    flow, constants = system.flow, system.constants
    field = Field(flow.of(mode), constants, constants.scales, [], LinearPart())
    # Meanwhile the contact is held by more than friction: its limit weighs nothing.
    held, length = system.without_limit(contact), FIRST
    why = "slip begins against its own friction"
    while length > SHORT:
        part = held.run(stuck, state, phase, phase + length)
        if part.event is not None:
            why = "two contacts change while one of them begins to slip"
            length = SHRINKS * (part.end - phase)
            continue
        growth = _growth(system, mode, contact, part.state, part.end)
        time = length * constants.period
        speed = float(np.linalg.norm(_grown(before, first, growth, time, np.ones(1))))
        if growth.rate > 0 and speed > 0:
            fraction = min(1.0, growth.most * time / speed / TERMS)
            fractions = fraction * POINTS.points
            slips = _grown(before, first, growth, time, fractions)
            polar = np.stack([np.log(np.hypot(*slips.T)), np.arctan2(*slips.T[::-1])], axis=1)
            states = state + fractions[:, None] * (part.state - state)
            guess = flow.mode(mode).hold_all(states, phase + length * fractions, constants, polar)
            onset = solve_onset(field, state, phase, fraction * length, guess)
            if onset is not None:
                apart = _slip(system, contact, onset.stages[-1], onset.phases[-1]) - slips[-1]
                if np.linalg.norm(apart) < 0.5 * np.linalg.norm(slips[-1]):
                    return onset
        length *= SHRINKS
    raise Undecided(why)


def _corrected(system: HybridSystem, contact: int, onset: SlipOnset, first: _Growth) -> Array:
    """Return what the powers of friction lack since slow slip has few digits for its direction.

    By how the trajectory continues friction is known better. Shapes: returns (s, 2).
    """
    flow, constants, place = system.flow, system.constants, system.places[contact]
    nothing = np.empty((len(constants.values), 0))
    slopes = flow.slips.at(onset.stages[-1], onset.phases[-1], constants, nothing)[0][place]
    known = flow.quantities.along(onset.stages, onset.phases, constants)
    slips, plates = (np.array([item[part] for item in known])[:, place] for part in (0, -1))
    friction = np.linalg.solve(first.change, slopes @ onset.missing.T).T
    return np.stack(
        [(friction * (plates - slips)).sum(axis=1), (friction * slips).sum(axis=1)], axis=1
    )


def _grown(before: Array, first: _Growth, last: _Growth, time: float, shares: Array) -> Array:
    """Return slip after fractions of a time by how it grows at both ends. Shapes: shares (p,)."""
    shares = shares[:, None]
    rates = first.rate * shares + (last.rate - first.rate) * shares**2 / 2
    return np.asarray(before + time * rates * (first.along + shares * (last.along - first.along)))


def _slip(system: HybridSystem, contact: int, state: Array, phase: float) -> Array:
    return np.array(system.at(state, phase).slip[system.places[contact]])


def _shown_onset(
    system: HybridSystem, mode: Mode, contact: int, onset: SlipOnset, along: Array, end: float
) -> BegunPolynomials:
    """Return what is shown of slip that begins: at the very first it has no direction yet."""
    scales = system.constants.scales
    least = SLACK / system.weights[contact] * along

    def placed(scaled: Array, phase: float) -> Array:
        state = scaled * scales
        slip = _slip(system, contact, state, phase)
        if np.linalg.norm(slip) > np.linalg.norm(least):
            return scaled
        return system.slipping(mode, state, least, phase) / scales

    return BegunPolynomials(onset.polynomials(end), len(scales), placed)


def begins(system: HybridSystem, mode: Mode, contact: int, state: Array, phase: float) -> bool:
    """Whether the slow slip of a contact is still beginning. Shapes: state (n,)."""
    slip = system.at(state, phase).slip[system.places[contact]]
    if math.hypot(*slip) * system.weights[contact] > SHORT:
        return False
    growth = _growth(system, mode, contact, state, phase)
    return growth.rate > -SLACK * growth.most


def direction_of_release(
    system: HybridSystem, mode: Mode, contact: int, state: Array, phase: float
) -> Array:
    """Return the direction in which a contact at rest begins to slip, shape (2,).

    Shapes: state (n,).
    """
    return _growth(system, mode, contact, state, phase).along


def _growth(system: HybridSystem, mode: Mode, contact: int, state: Array, phase: float) -> _Growth:
    now, places = system.at(state, phase), system.places
    rest = [i for i, status in enumerate(mode) if status is Status.STICK or i == contact]
    alone, change = response(now, places, mode, rest, contact)
    size = now.starting[contact]
    along, rate = outward(alone, change, size)
    return _Growth(np.array(along), rate, size * largest(change), np.array(change))
