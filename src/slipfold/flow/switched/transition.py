"""Which mode follows: the one whose forces and accelerations agree with each other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.switched.contact_quantities import ContactsNow
from slipfold.flow.switched.mode import Mode, Status

__all__ = ["Undecided", "next_mode", "outward", "response"]

Array = NDArray[np.float64]

TURNS = 50
"""Newton steps to the direction of slip that begins: three are enough."""

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

    def forces(self, mode: Mode, given: Mapping[int, Array] | None = None) -> tuple[Array, Array]:
        """Return friction and rates of slip if the contacts go on in a mode.

        Friction in contacts that slip may be given.
        """
        now = self.now
        friction = np.zeros(len(now.slip))
        stuck = list[int]()
        for contact, (status, place) in enumerate(zip(mode, self.places, strict=True)):
            if status is Status.STICK:
                stuck += range(place.start, place.stop)
            elif status is not Status.OPEN:
                known = (given or {}).get(contact)
                friction[place] = self._sliding(contact, status, place) if known is None else known
        normal = now.normal
        if Status.OPEN in mode:
            normal = np.array([
                0.0 if status is Status.OPEN else force
                for status, force in zip(mode, now.normal, strict=True)
            ])  # fmt: skip
        rates = now.free + now.by_normal @ normal + now.by_friction @ friction
        if stuck:
            columns = now.by_friction[:, stuck]
            matrix = columns[stuck]
            # One component needs no elimination, which takes longer than all else here.
            if len(stuck) == 1:
                held = -rates[stuck] / matrix[0]
            else:
                held = np.linalg.solve(matrix, -rates[stuck])
            friction[stuck] = held
            rates = rates + columns @ held
            rates[stuck] = 0.0
        return friction, rates

    def _sliding(self, contact: int, status: Status, place: slice) -> Array:
        """Return the friction of a contact that slips."""
        now, starts = self.now, contact in self.rest
        if place.stop - place.start == 1:
            forth = status is Status.FORTH if starts else now.slip[place.start] > 0
            size = (now.starting if starts else now.kinetic)[contact]
            return np.array([size if forth else -size])
        if starts:
            along = self._borne[place]
            return np.asarray(now.starting[contact] * along / np.linalg.norm(along))
        slip = now.slip[place]
        return np.asarray(now.kinetic[contact] * slip / np.linalg.norm(slip))

    @cached_property
    def _borne(self) -> Array:
        """Friction if all that is at rest sticks."""
        changes = dict.fromkeys(self.rest, Status.STICK)
        return self.forces(_changed(self.moving, changes))[0]

    def response(self, mode: Mode, contact: int) -> tuple[Array, Array]:
        """Return a contact's rate of slip without its friction, and its change with that.

        Others go on in the mode, those that stick with whatever friction it takes.
        """
        place = self.places[contact]
        size = place.stop - place.start
        alone = self.forces(mode, {contact: np.zeros(size)})[1][place]
        columns = [self.forces(mode, {contact: unit})[1][place] - alone for unit in np.eye(size)]
        return alone, np.array(columns).T

    def violations(self, mode: Mode) -> dict[int, Status]:
        """Return the contacts at rest that cannot go on like this, and what they had better do."""
        friction, rates = self.forces(mode)
        found = {}
        for contact in self.rest:
            place, most = self.places[contact], self.now.holding[contact]
            if mode[contact] is Status.STICK:
                if math.hypot(*friction[place]) > most * (1 + SLACK):
                    planar = place.stop - place.start == 2
                    straight = Status.FORTH if friction[place.start] > 0 else Status.BACK
                    found[contact] = Status.SLOW if planar else straight
            elif mode[contact] is Status.SLOW:
                alone, change = self.response(mode, contact)
                start = self.now.starting[contact]
                away = outward(alone, change, start)[1]
                if away < -SLACK * np.abs(change).max() * most:
                    found[contact] = Status.STICK
            else:
                size = abs(self.now.by_friction[place.start, place.start]) * most
                if float(mode[contact]) * rates[place.start] < -SLACK * size:
                    found[contact] = Status.STICK
        return found


def outward(alone: Array, change: Array, size: float, turn: float = 0.0) -> tuple[Array, float]:
    """Return the direction in which slip in the plane begins, and how fast it grows.

    Slip grows along itself, ``s' = k e`` with friction ``size e``, but for what turns it.

    Shapes: alone (2,); change (2, 2); returns e (2,).
    """
    needed = np.linalg.solve(change, -alone)
    angle = float(np.arctan2(needed[1], needed[0]))
    for _ in range(TURNS):
        along = np.array([np.cos(angle), np.sin(angle)])
        across = np.array([-along[1], along[0]])
        rate = alone + size * change @ along
        slope = size * across @ change @ across - along @ rate
        step = (across @ rate - turn) / slope
        angle -= step
        if abs(step) < 1e-15:
            break
    along = np.array([np.cos(angle), np.sin(angle)])
    return along, float(along @ (alone + size * change @ along))


def response(
    now: ContactsNow, places: Sequence[slice], mode: Mode, rest: Sequence[int], contact: int
) -> tuple[Array, Array]:
    """Return the rate of slip of a contact without its friction, and its change with that."""
    return _Instant(now, places, tuple(rest), mode).response(mode, contact)


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
    if not changes:
        return mode
    return tuple(changes.get(place, status) for place, status in enumerate(mode))


def _all(instant: _Instant, mode: Mode) -> Iterator[Mode]:
    """All modes, those that stick most first."""
    rest = instant.rest
    if len(rest) > TRIED:
        return
    planar = (Status.STICK, Status.SLOW)
    straight = (Status.STICK, Status.FORTH, Status.BACK)
    sizes = [instant.places[item].stop - instant.places[item].start for item in rest]
    choices = product(*(planar if size == 2 else straight for size in sizes))
    for chosen in sorted(choices, key=lambda some: -some.count(Status.STICK)):
        yield _changed(mode, dict(zip(rest, chosen, strict=True)))
