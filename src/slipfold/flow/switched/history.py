"""What contacts did in the course of a motion: which of them stuck, when, how long."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.switched.mode import Mode, status_name

__all__ = ["Change", "Interval", "Recorder"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Interval:
    """A time in which a contact does one thing; frozen.

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
    """Collects intervals and changes while a motion goes on."""

    def __init__(self, contacts: Sequence[str], mode: Mode) -> None:
        self._contacts, self._mode = contacts, mode
        self._begin = [0.0] * len(contacts)
        self._energies = np.zeros((2, len(contacts)))
        self.intervals: list[Interval] = []
        self.changes: list[Change] = []

    def went_on(self, energies: Array) -> None:
        """Add the energies of a leg, shape (2, k)."""
        self._energies += energies

    def changed(self, time: float, state: Array, mode: Mode) -> None:
        """Note a new mode."""
        self.changes.append(Change(time, state, mode))
        for place, after in enumerate(mode):
            if after is not self._mode[place]:
                self._close(time, place)
        self._mode = mode

    def ended(self, time: float) -> tuple[Interval, ...]:
        """Return all intervals, those that still last as far as the end."""
        known = len(self.intervals)
        kept = self._begin.copy(), self._energies.copy()
        for place in range(len(self._contacts)):
            self._close(time, place)
        found = tuple(self.intervals)
        del self.intervals[known:]
        self._begin, self._energies = kept
        return found

    def _close(self, time: float, place: int) -> None:
        if time > self._begin[place]:
            work, heat = self._energies[:, place].tolist()
            name, doing = self._contacts[place], status_name(self._mode[place])
            self.intervals.append(Interval(name, doing, self._begin[place], time, work, heat))
        self._begin[place] = time
        self._energies[:, place] = 0.0
