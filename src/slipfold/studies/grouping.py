"""How many cases go into one task: so many that it lasts longer than sending it takes."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice

AIM = 0.25
"""Seconds that are aimed at: what is lost when a process is killed."""

LARGEST = 4096
"""Cases of the largest task."""

GROWTH = 4
"""Factor by which tasks grow at most: the first cases also compile."""


class Groups:
    """Numbers of cases in their order, cut into groups as it becomes known how long cases take.

    Groups have at least so many.

    >>> groups = Groups(range(10))
    >>> groups.next(), groups.next()
    ((0,), (1,))
    >>> groups.learn(1, 0.08)
    >>> groups.next()
    (2, 3, 4)
    """

    def __init__(self, numbers: Iterable[int], least: int = 1) -> None:
        self._numbers = iter(numbers)
        self._least = self.size = least

    def next(self) -> tuple[int, ...]:
        """Return the next group; an empty one at the end."""
        return tuple(islice(self._numbers, self.size))

    def learn(self, count: int, seconds: float) -> None:
        """Take note of how long a group took."""
        wanted = int(AIM * count / max(seconds, 1e-9))
        self.size = max(self._least, min(wanted, GROWTH * self.size, LARGEST))
