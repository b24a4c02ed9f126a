"""Which mode follows: the one whose forces and accelerations agree with each other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from slipfold.flow.switched.contact_quantities import ContactsNow, Numbers
from slipfold.flow.switched.mode import Mode, Status

TURNS = 50
"""Newton steps to the direction of slip that begins: three are enough."""

SLACK = 1e-11
"""Share of what friction holds by which rounding may place a force beyond it."""

TRIED = 7
"""Contacts at rest at one instant of which all combinations are tried."""


class Undecided(ValueError):
    """No mode agrees with itself."""


@dataclass(eq=False)
class _Instant:
    """Contacts at an instant, some of them at rest."""

    now: ContactsNow
    places: Sequence[slice]  # components of each contact
    rest: tuple[int, ...]  # contacts without slip, of which it is open what they do
    moving: Mode  # what each contact does; of those at rest it means nothing

    def forces(
        self, mode: Mode, given: Mapping[int, Numbers] | None = None
    ) -> tuple[Numbers, Numbers]:
        """Return friction and rates of slip if the contacts go on in a mode.

        Friction in contacts that slip may be given.
        """
        now, rows = self.now, range(len(self.now.slip))
        friction, rates = [0.0] * len(rows), list(now.free)
        stuck = list[int]()
        for contact, (status, place) in enumerate(zip(mode, self.places, strict=True)):
            if status is Status.OPEN:
                continue
            for row in rows:
                rates[row] += now.by_normal[row][contact] * now.normal[contact]
            if status is Status.STICK:
                stuck += range(place.start, place.stop)
                continue
            known = (given or {}).get(contact)
            forces = self._sliding(contact, status, place) if known is None else known
            friction[place] = forces
            for column, force in enumerate(forces, place.start):
                for row in rows:
                    rates[row] += now.by_friction[row][column] * force
        if stuck:
            matrix = [[now.by_friction[row][column] for column in stuck] for row in stuck]
            held = _solved(matrix, [-rates[row] for row in stuck])
            for column, force in zip(stuck, held, strict=True):
                friction[column] = force
                for row in rows:
                    rates[row] += now.by_friction[row][column] * force
            for row in stuck:
                rates[row] = 0.0
        return friction, rates

    def _sliding(self, contact: int, status: Status, place: slice) -> Numbers:
        """Return the friction of a contact that slips."""
        now, starts = self.now, contact in self.rest
        size = (now.starting if starts else now.kinetic)[contact]
        if place.stop - place.start == 1:
            forth = status is Status.FORTH if starts else now.slip[place.start] > 0
            return [size if forth else -size]
        along = (self._borne if starts else now.slip)[place]
        length = math.hypot(*along)
        return [size * part / length if length else math.nan for part in along]

    @cached_property
    def _borne(self) -> Numbers:
        """Friction if all that is at rest sticks."""
        changes = dict.fromkeys(self.rest, Status.STICK)
        return self.forces(_changed(self.moving, changes))[0]

    def response(self, mode: Mode, contact: int) -> tuple[Numbers, list[Numbers]]:
        """Return a contact's rate of slip without its friction, and its change with that.

        Others go on in the mode, those that stick with whatever friction it takes.
        """
        place = self.places[contact]
        size = range(place.stop - place.start)
        alone = self.forces(mode, {contact: [0.0 for _ in size]})[1][place]
        columns = [
            self.forces(mode, {contact: [float(i == axis) for i in size]})[1][place]
            for axis in size
        ]
        return alone, [[column[row] - alone[row] for column in columns] for row in size]

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
                if away < -SLACK * largest(change) * most:
                    found[contact] = Status.STICK
            else:
                size = abs(self.now.by_friction[place.start][place.start]) * most
                if float(mode[contact]) * rates[place.start] < -SLACK * size:
                    found[contact] = Status.STICK
        return found


def outward(alone: Numbers, change: list[Numbers], size: float) -> tuple[Numbers, float]:
    """Return the direction in which slip in the plane begins, and how fast it grows.

    Slip grows along itself, ``s' = k e`` with friction ``size e``.
    """
    (a, b), (c, d) = change
    x, y = _solved(change, [-part for part in alone])
    angle = math.atan2(y, x)
    for _ in range(TURNS):
        cos, sin = math.cos(angle), math.sin(angle)
        u, v = alone[0] + size * (a * cos + b * sin), alone[1] + size * (c * cos + d * sin)
        across = size * (sin * (a * sin - b * cos) - cos * (c * sin - d * cos))
        step = (cos * v - sin * u) / (across - (cos * u + sin * v))
        angle -= step
        if abs(step) < 1e-15:
            break
    cos, sin = math.cos(angle), math.sin(angle)
    u, v = alone[0] + size * (a * cos + b * sin), alone[1] + size * (c * cos + d * sin)
    return [cos, sin], cos * u + sin * v


def largest(matrix: list[Numbers]) -> float:
    """Return the size of the largest of its entries."""
    return max(abs(entry) for row in matrix for entry in row)


def _solved(matrix: list[Numbers], right: Numbers) -> Numbers:
    """Solve some equations; a library takes longer for one or two than all else here."""
    if len(right) == 1:
        return [right[0] / matrix[0][0]]
    if len(right) == 2:
        (a, b), (c, d) = matrix
        e, f = right
        size = a * d - b * c
        return [(d * e - b * f) / size, (a * f - c * e) / size]
    return [float(part) for part in np.linalg.solve(matrix, right)]


def friction_in(
    now: ContactsNow, places: Sequence[slice], mode: Mode, rest: Sequence[int]
) -> Numbers:
    """Return friction if contacts, some of them at rest, go on in a mode."""
    return _Instant(now, places, tuple(rest), mode).forces(mode)[0]


def response(
    now: ContactsNow, places: Sequence[slice], mode: Mode, rest: Sequence[int], contact: int
) -> tuple[Numbers, list[Numbers]]:
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
