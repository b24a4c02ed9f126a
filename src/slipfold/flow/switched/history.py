"""What contacts did in the course of a motion: which of them stuck, when, how long."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
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
        energies = np.array([*self._energies, np.zeros((2, len(self._contacts)))])
        found = [
            self._intervals(place, name, energies[:, :, place], time)
            for place, name in enumerate(self._contacts)
        ]
        return tuple(sorted(chain.from_iterable(found), key=lambda item: item.end))

    def _intervals(self, place: int, name: str, energies: Array, time: float) -> list[Interval]:
        """Return what one contact did. Shapes: energies (legs + 1, 2)."""
        doing, begins, legs = [self._mode[place]], [0.0], [0]
        for change, done in zip(self.changes, self._legs, strict=True):
            status = change.mode[place]
            if status is not doing[-1]:
                doing.append(status)
                begins.append(change.time)
                legs.append(done)
        sums = np.add.reduceat(energies, legs).tolist()
        rows = zip(doing, begins, [*begins[1:], time], sums, strict=True)
        return [
            Interval(name, status_name(status), begin, end, *both)
            for status, begin, end, both in rows
            if end > begin
        ]
