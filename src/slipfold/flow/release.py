"""Release of contacts: which ones leave stick at its limit, and how slip in the plane begins."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.batches import ROUNDING, TOLERANCE
from slipfold.flow.contact_state import ContactsNow, Instant, Undecided, largest, outward
from slipfold.flow.hybrid_flow import HybridSystem, SmoothPhase
from slipfold.flow.intervals import Field, LinearPart
from slipfold.flow.modes import CONTACT, Mode, Status, reported_mode
from slipfold.flow.polynomials import POINTS, OnsetPolynomials, SlipOnset, solve_onset


def at_rest(system: HybridSystem, mode: Mode, now: ContactsNow) -> tuple[int, ...]:
    """Return the closed contacts without slip."""
    return tuple(
        contact
        for contact, components in enumerate(system.places)
        if mode[contact] is not Status.OPEN
        and math.hypot(*now.slip[components]) * system.weights[contact] <= ROUNDING
    )


def released_at_limit(
    system: HybridSystem, mode: Mode, state: Array, phase: float, now: ContactsNow | None = None
) -> Mode:
    """Return the next mode: contacts slip if their friction exceeds its limit shortly after.

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
    instant = Instant(now, places, rest, mode)
    friction = instant.forces(mode)[0]
    at_limit = [
        contact
        for contact, components in enumerate(places)
        if mode[contact] is Status.STICK
        and math.hypot(*friction[components]) >= now.holding[contact] * (1 - CONTACT.slack)
    ]
    if not at_limit:
        return mode
    # Contacts alike reach it together, and none may end what shows the growth of another's force.
    part = system.without_limits(at_limit).run(mode, state, phase, phase + CONTACT.short)
    later = system.at(part.state, part.end)
    ahead, slips = Instant(later, places, rest, mode).forces(mode)[0], dict[int, Status]()
    for contact in at_limit:
        components, limit = places[contact], now.holding[contact]
        grown = math.hypot(*ahead[components]) - later.holding[contact]
        if grown - (math.hypot(*friction[components]) - limit) > TOLERANCE * limit:
            if components.stop - components.start == 2:  # one at a time: its speed rescales time
                return instant.next_mode({contact: Status.SLOW})
            slips[contact] = Status.FORTH if friction[components.start] > 0 else Status.BACK
    return instant.next_mode(slips) if slips else mode


@dataclass(frozen=True, eq=False)
class _Growth:
    """Growth of slip at an instant."""

    along: Array  # direction, shape (2,)
    rate: float
    by_friction: float  # rate from friction alone
    change: Array  # of the rate of slip with friction, shape (2, 2)


class Release:
    """The onset of slip in the plane, of a contact that rests or has just begun to slip."""

    def __init__(self, system: HybridSystem, mode: Mode, contact: int) -> None:
        self._system, self._mode, self._contact = system, mode, contact
        self._place = system.places[contact]
        self._size = 1 / system.weights[contact]  # of slip

    def phases(
        self, state: Array, phase: float, end: float, *, dense: bool = False
    ) -> list[SmoothPhase]:
        """Return the first smooth phases of slip, up to the phase `end` at most.

        Shapes: state (n,).
        """
        system, mode = self._system, self._mode
        first = self._growth(state, phase)
        before = self._slip(state, phase)
        if first.rate > CONTACT.immediate_rate * first.by_friction:
            period = system.constants.period
            speed = max(
                first.rate * CONTACT.immediate_phase * period, 20 * CONTACT.rest * self._size
            )
            if np.linalg.norm(before) >= speed:  # it has started already
                return []
            after = system.slipping(mode, state, speed * first.along, phase)
            none = np.zeros(2 * len(mode))
            return [SmoothPhase(mode, phase, phase, after, none, None, released=True)]
        onset = self._onset(state, phase, first, before)
        until = min(end, onset.end)
        compiled = system.flow.mode(reported_mode(mode))
        powers = compiled.powers(onset.stages, onset.phases, system.constants).copy()
        powers[:, [self._contact, len(mode) + self._contact]] += self._corrections(onset, first)
        energies = onset.integrals(until) @ powers
        seen = self._shown(onset, first.along, until) if dense else None
        after = system.held(mode, onset.at(until), until)
        return [SmoothPhase(mode, phase, until, after, energies, None, True, onset, seen)]

    def begins(self, state: Array, phase: float) -> bool:
        """Whether slow slip is still in its onset. Shapes: state (n,)."""
        if np.linalg.norm(self._slip(state, phase)) > CONTACT.short * self._size:
            return False
        growth = self._growth(state, phase)
        return growth.rate > -CONTACT.slack * growth.by_friction

    def direction(self, state: Array, phase: float) -> Array:
        """Return the direction in which slip begins, shape (2,). Shapes: state (n,)."""
        return self._growth(state, phase).along

    def _onset(self, state: Array, phase: float, first: _Growth, before: Array) -> SlipOnset:
        """Return the onset of slip that grows slowly, up to where one polynomial represents it."""
        contact, flow, constants = self._contact, self._system.flow, self._system.constants
        stuck = tuple(
            Status.STICK if i == contact else status for i, status in enumerate(self._mode)
        )
        field = Field(flow.of(self._mode), constants, constants.scales, [], LinearPart())
        # First the contact is held without a limit of friction: growth at both ends gives a guess.
        held, length = self._system.without_limits([contact]), CONTACT.longest_phase
        why = "slip begins against its own friction"
        while length > CONTACT.short:
            part = held.run(stuck, state, phase, phase + length)
            if part.event is not None:
                why = "two contacts change while one of them begins to slip"
                length = CONTACT.shrink_factor * (part.end - phase)
                continue
            growth = self._growth(part.state, part.end)
            time = length * constants.period
            speed = float(np.linalg.norm(_grown(before, first, growth, time, np.ones(1))))
            if growth.rate > 0 and speed > 0:
                fraction = min(1.0, growth.by_friction * time / speed / CONTACT.terms)
                fractions = fraction * POINTS.points
                slips = _grown(before, first, growth, time, fractions)
                polar = np.stack([np.log(np.hypot(*slips.T)), np.arctan2(*slips.T[::-1])], axis=1)
                states = state + fractions[:, None] * (part.state - state)
                phases = phase + length * fractions
                guess = flow.mode(self._mode).hold_all(states, phases, constants, polar)
                onset = solve_onset(field, state, phase, fraction * length, guess)
                if onset is not None:
                    apart = self._slip(onset.stages[-1], onset.phases[-1]) - slips[-1]
                    if np.linalg.norm(apart) < 0.5 * np.linalg.norm(slips[-1]):
                        return onset
            length *= CONTACT.shrink_factor
        raise Undecided(why)

    def _corrections(self, onset: SlipOnset, first: _Growth) -> Array:
        """Return corrections of the power of friction. Shapes: returns (s, 2).

        The direction of slow slip has few digits; the rates of the trajectory give friction more
        precisely.
        """
        flow, constants, components = self._system.flow, self._system.constants, self._place
        nothing = np.empty((len(constants.values), 0))
        slopes = flow.slips.at(onset.stages[-1], onset.phases[-1], constants, nothing)[0][
            components
        ]
        known = flow.quantities.along(onset.stages, onset.phases, constants)
        slips, plates = (
            np.array([item[part] for item in known])[:, components] for part in (0, -1)
        )
        friction = np.linalg.solve(first.change, slopes @ onset.missing.T).T
        return np.stack(
            [(friction * (plates - slips)).sum(axis=1), (friction * slips).sum(axis=1)], axis=1
        )

    def _shown(self, onset: SlipOnset, along: Array, end: float) -> OnsetPolynomials:
        """Return dense output of the onset, in which slip always has a direction."""
        scales, minimum = self._system.constants.scales, CONTACT.slack * self._size * along

        def placed(scaled: Array, phase: float) -> Array:
            state = scaled * scales
            if np.linalg.norm(self._slip(state, phase)) > np.linalg.norm(minimum):
                return scaled
            return self._system.slipping(self._mode, state, minimum, phase) / scales

        return OnsetPolynomials(onset.polynomials(end), len(scales), placed)

    def _slip(self, state: Array, phase: float) -> Array:
        return np.array(self._system.at(state, phase).slip[self._place])

    def _growth(self, state: Array, phase: float) -> _Growth:
        now = self._system.at(state, phase)
        rest = tuple(
            i for i, status in enumerate(self._mode) if status is Status.STICK or i == self._contact
        )
        instant = Instant(now, self._system.places, rest, self._mode)
        alone, change = instant.response(self._mode, self._contact)
        size = now.starting[self._contact]
        along, rate = outward(alone, change, size)
        return _Growth(np.array(along), rate, size * largest(change), np.array(change))


def _grown(before: Array, first: _Growth, last: _Growth, time: float, fractions: Array) -> Array:
    """Return slip after fractions of a time from its growth at both ends. Shapes: (p,)."""
    fractions = fractions[:, None]
    rates = first.rate * fractions + (last.rate - first.rate) * fractions**2 / 2
    along = first.along + fractions * (last.along - first.along)
    return np.asarray(before + time * rates * along)
