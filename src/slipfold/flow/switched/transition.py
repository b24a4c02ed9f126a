"""Which mode follows: the one whose forces and accelerations agree with each other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.switched.contact_quantities import ContactsNow
from slipfold.flow.switched.mode import Mode, Status

__all__ = ["Undecided", "next_mode"]

Array = NDArray[np.float64]

SLACK = 1e-11
"""Share of what friction holds by which rounding may place a force beyond it."""

TRIED = 7
"""Contacts at rest at one instant of which all combinations are tried."""


class Undecided(ValueError):
    """No mode agrees with itself."""


@dataclass(frozen=True, eq=False)
class _Instant:
    """Contacts at an instant, some of them at rest."""

    now: ContactsNow
    places: Sequence[slice]  # components of each contact
    rest: tuple[int, ...]  # contacts without slip, of which it is open what they do
    moving: Mode  # what each contact does; of those at rest it means nothing

    def forces(self, mode: Mode) -> tuple[Array, Array]:
        """Return friction and rates of slip if the contacts go on in a mode."""
        now = self.now
        closed = np.array([status is not Status.OPEN for status in mode])
        friction = np.zeros(len(now.slip))
        stuck = list[int]()
        for contact, (status, place) in enumerate(zip(mode, self.places, strict=True)):
            if status is Status.STICK:
                stuck += range(place.start, place.stop)
            elif status is not Status.OPEN:
                friction[place] = self._sliding(contact, status, place)
        rates = now.free + now.by_normal @ np.where(closed, now.normal, 0.0)
        rates = rates + now.by_friction @ friction
        if stuck:
            places = np.array(stuck)
            held = np.linalg.solve(now.by_friction[np.ix_(places, places)], -rates[places])
            friction[places] = held
            rates = rates + now.by_friction[:, places] @ held
            rates[places] = 0.0
        return friction, rates

    def _sliding(self, contact: int, status: Status, place: slice) -> Array:
        """Return the friction of a contact that slips."""
        now = self.now
        if contact in self.rest:
            return np.array([float(status) * now.starting[contact]])
        slip = now.slip[place]
        return np.asarray(now.kinetic[contact] * slip / np.linalg.norm(slip))

    def violations(self, mode: Mode) -> dict[int, Status]:
        """Return the contacts at rest that cannot go on like this, and what they had better do."""
        friction, rates = self.forces(mode)
        found = {}
        for contact in self.rest:
            place, most = self.places[contact], self.now.holding[contact]
            if mode[contact] is Status.STICK:
                if np.linalg.norm(friction[place]) > most * (1 + SLACK):
                    found[contact] = Status(int(np.sign(friction[place][0])))
            else:
                size = np.abs(self.now.by_friction[place, place]).max() * most
                if float(mode[contact]) * rates[place][0] < -SLACK * size:
                    found[contact] = Status.STICK
        return found


def next_mode(
    now: ContactsNow,
    places: Sequence[slice],
    mode: Mode,
    rest: Sequence[int],
    wanted: Mapping[int, Status],
) -> Mode:
    """Return the mode in which contacts go on.

    Those at `rest` have no slip; `wanted` says what some of them are about to do.
    Sticking goes before slipping back: a contact stops where friction can hold it.
    """
    instant = _Instant(now, places, tuple(rest), mode)
    seen = set[Mode]()
    trial = _changed(mode, wanted)
    while trial not in seen:
        seen.add(trial)
        wrong = instant.violations(trial)
        if not wrong:
            return trial
        # One at a time, the last first: where one lets go, what others bear changes.
        worst = max(wrong)
        trial = _changed(trial, {worst: wrong[worst]})
    for candidate in _all(instant, mode):
        if candidate not in seen and not instant.violations(candidate):
            return candidate
    raise Undecided("no state of its contacts agrees with the forces in them")


def _changed(mode: Mode, changes: Mapping[int, Status]) -> Mode:
    return tuple(changes.get(place, status) for place, status in enumerate(mode))


def _all(instant: _Instant, mode: Mode) -> Iterator[Mode]:
    """All modes, those that stick most first."""
    rest = instant.rest
    if len(rest) > TRIED:
        return
    choices = product((Status.STICK, Status.FORTH, Status.BACK), repeat=len(rest))
    for chosen in sorted(choices, key=lambda some: -some.count(Status.STICK)):
        yield _changed(mode, dict(zip(rest, chosen, strict=True)))
