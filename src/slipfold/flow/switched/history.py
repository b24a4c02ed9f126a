"""What contacts did in the course of a motion: which of them stuck, when, how long."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import repeat
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.switched.mode import Mode, status_name

__all__ = ["Change", "Interval", "Recorder"]

Array = NDArray[np.float64]


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
        self._contacts, self._mode = contacts, mode
        self._energies: list[Array] = []
        self._legs: list[int] = []  # before each change
        self.changes: list[Change] = []

    def went_on(self, energies: Array) -> None:
        """Note the energies of a leg, shape (2, k)."""
        self._energies.append(energies)

    def changed(self, time: float, state: Array, mode: Mode) -> None:
        """Note a new mode."""
        self.changes.append(Change(time, state, mode))
        self._legs.append(len(self._energies))

    def ended(self, time: float) -> tuple[Interval, ...]:
        """Return all intervals, those that still last as far as the end, by their ends."""
        count = len(self._contacts)
        energies = np.concatenate([*self._energies, np.zeros((2, count))]).reshape(-1, 2, count)
        found = [
            item
            for place, name in enumerate(self._contacts)
            for item in self._intervals(place, name, energies[:, :, place], time)
        ]
        return tuple(sorted(found, key=attrgetter("end")))

    def _intervals(self, place: int, name: str, energies: Array, time: float) -> list[Interval]:
        """Return what one contact did. Shapes: energies (legs + 1, 2)."""
        doing = [self._mode[place], *(change.mode[place] for change in self.changes)]
        times = [0.0, *(change.time for change in self.changes)]
        legs = [0, *self._legs]
        kept = [0, *(i for i in range(1, len(doing)) if doing[i] is not doing[i - 1])]
        begins = [times[i] for i in kept]
        sums = np.add.reduceat(energies, [legs[i] for i in kept])
        found = map(
            Interval,
            repeat(name),
            [status_name(doing[i]) for i in kept],
            begins,
            [*begins[1:], time],
            *sums.T.tolist(),
        )
        return [item for item in found if item.end > item.begin]
