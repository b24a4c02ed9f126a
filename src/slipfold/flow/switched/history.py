"""What contacts did in the course of a motion: which of them stuck, when, how long."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain, repeat
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.switched.mode import Mode, status_name


class Interval(NamedTuple):
    """A time in which a contact does one thing.

    Parameters
    ----------
    contact
        Its name.
    state
        ``"slip"``, ``"stick"`` or ``"free"``.
    begin, end
        Time since the start of the motion, in forcing periods; of an autonomous model in s.
    work
        Work of its friction on the structure in J.
    heat
        What friction turned into heat in J.
    """

    contact: str
    state: str
    begin: float
    end: float
    work: float
    heat: float


@dataclass(eq=False, slots=True)  # frozen ones take three times as long to make
class Change:
    """An instant at which the mode changes."""

    time: float  # in phases since the start
    state: Array  # shape (n,)
    mode: Mode  # what follows


class Recorder:
    """Notes legs and changes while a motion goes on; what they amount to is found afterwards."""

    def __init__(self, contacts: Sequence[str], mode: Mode) -> None:
        self._contacts = contacts
        self._energies: list[Array] = []
        # Of all that begins with a mode: when, in which state, and how many legs came before
        self.modes, self._times, self._legs = [mode], [0.0], [0]
        self._states: list[Array] = []
        self.begun = 0  # periods that are over where times are counted from

    def went_on(self, energies: Array) -> None:
        """Note the energies of a leg, shape (2 k,)."""
        self._energies.append(energies)

    def changed(self, time: float, state: Array, mode: Mode) -> None:
        """Note a new mode, at a phase of the present period."""
        self.modes.append(mode)
        self._times.append(self.begun + time)
        self._states.append(state)
        self._legs.append(len(self._energies))

    @property
    def changes(self) -> list[Change]:
        """All of them so far."""
        return list(map(Change, self._times[1:], self._states, self.modes[1:]))

    @property
    def last_time(self) -> float:
        """When something changed last, zero if nothing did, in phases."""
        return self._times[-1]

    def ended(self, time: float) -> tuple[Interval, ...]:
        """Return all intervals, those that still last as far as the end, by their ends."""
        count = len(self._contacts)
        energies = np.zeros((len(self._energies) + 1, 2, count))
        if self._energies:
            energies[:-1] = np.concatenate(self._energies).reshape(-1, 2, count)
        found = [
            self._intervals(place, name, energies[:, :, place], time)
            for place, name in enumerate(self._contacts)
        ]
        if count == 1:
            return tuple(found[0])
        return tuple(sorted(chain.from_iterable(found), key=attrgetter("end")))

    def _intervals(self, place: int, name: str, energies: Array, time: float) -> list[Interval]:
        """Return what one contact did. Shapes: energies (legs + 1, 2)."""
        doing = np.array([mode[place] for mode in self.modes])
        kept = np.flatnonzero(np.append(True, doing[1:] != doing[:-1]))
        sums = np.add.reduceat(energies, np.array(self._legs)[kept])
        begins = np.array(self._times)[kept]
        ends = np.append(begins[1:], time)
        lasts = ends > begins
        names = map(status_name, doing[kept][lasts].tolist())
        columns = (part[lasts].tolist() for part in (begins, ends, *sums.T))
        return [*map(Interval._make, zip(repeat(name), names, *columns, strict=False))]
