"""Many curves: starts that wait, both directions, nothing twice, and what joins what."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic

from slipfold.continuation.curve import P
from slipfold.continuation.end import End
from slipfold.continuation.search import Found
from slipfold.continuation.trail import Trail, joined


@dataclass(frozen=True, eq=False)
class Start(Generic[P]):
    """Where a curve is to be followed from."""

    curve: Any  # its equations, a `Curve`
    # The first point; another with the opposite tangent where it goes on in both directions
    points: tuple[P, ...]
    # Its turn: the lowest is followed first, of equals the one that has waited longest
    rank: tuple[int, ...] = ()
    departs: bool = False  # whether another curve passes there
    parent: int | None = None  # number of the curve it was found on
    found: Found[P] | None = None  # the special point at which it begins


@dataclass(eq=False)
class Chart(Generic[P]):
    """A curve that was followed, in both directions if it goes on in both."""

    number: int  # from 1
    start: Start[P]  # where it was followed from
    trail: Trail[P]  # what was followed
    begun: End | None  # why it begins where it begins; None where that is at its start

    @property
    def interrupted(self) -> bool:
        """Whether whoever watches stopped it."""
        return any(end and end.kind == "interrupted" for end in (self.begun, self.trail.end))


class Atlas(ABC, Generic[P]):
    """Curves followed from starts, and from what is found on them, each of them once."""

    def __init__(self) -> None:
        self.charts: list[Chart[P]] = []
        self.leads: dict[Found[P], list[int]] = {}

    @abstractmethod
    def trail(self, start: Start[P], point: P) -> Trail[P]:
        """Follow a start in the direction of one of its points."""

    @abstractmethod
    def births(self, chart: Chart[P]) -> Sequence[Start[P]]:
        """Return where others begin on a curve that was followed."""

    @abstractmethod
    def known(self, start: Start[P]) -> int | None:
        """Return the number of the curve that a start lies on, if it was followed already."""

    @property
    def interrupted(self) -> bool:
        """Whether whoever watches stopped the last curve."""
        return bool(self.charts) and self.charts[-1].interrupted

    def lead(self, found: Found[P] | None, number: int) -> None:
        """Note which curve a special point leads to."""
        if found is not None and number not in self.leads.setdefault(found, []):
            self.leads[found].append(number)

    def explore(self, start: Start[P]) -> None:
        """Follow a curve and all that leave it."""
        waiting = [start]
        while waiting and not self.interrupted:
            start = min(waiting, key=lambda item: item.rank)
            waiting.remove(start)
            number = self.known(start)
            if number is not None:
                if number != start.parent:  # a point leads from a curve to others
                    self.lead(start.found, number)
                continue
            chart = self._chart(start)
            self.lead(start.found, chart.number)
            waiting += self.births_until_interrupted(chart)

    def births_until_interrupted(self, chart: Chart[P]) -> Sequence[Start[P]]:
        """Return where others begin on a curve; none where whoever watches stops the search."""
        try:
            return self.births(chart)
        except KeyboardInterrupt:
            end = chart.trail.end
            assert end is not None
            reason = f"{end.reason}; interrupted before what begins on it was found"
            chart.trail.end = replace(end, kind="interrupted", reason=reason)
            return ()

    def _chart(self, start: Start[P]) -> Chart[P]:
        """Follow a curve in all its directions; round a closed one there is but one."""
        trail, begun = self.trail(start, start.points[0]), None
        if trail.closes:
            begun = trail.end
        elif len(start.points) > 1 and trail.end is not None and trail.end.kind != "interrupted":
            backward = self.trail(start, start.points[1])
            trail, begun = joined(backward, trail), backward.end
        chart = Chart(len(self.charts) + 1, start, trail, begun)
        self.charts.append(chart)
        return chart
