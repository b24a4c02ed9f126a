"""Work queue of curves to follow: both directions of each, without duplicates."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, Generic

from slipfold.continuation.curve import P
from slipfold.continuation.end import End
from slipfold.continuation.traced_curve import Found, TracedCurve, joined


@dataclass(frozen=True, eq=False)
class Start(Generic[P]):
    """A point from which a curve is to be followed."""

    curve: Any  # its equations, a `Curve`
    # The first point; another with the opposite tangent where it continues in both directions
    points: tuple[P, ...]
    # Priority: the lowest is followed first, of equals the one that was added first
    rank: tuple[int, ...] = ()
    departs: bool = False  # whether it is a point of another curve
    parent: int | None = None  # number of the curve on which it was found
    found: Found[P] | None = None  # the special point at which it begins


@dataclass(eq=False)
class FollowedCurve(Generic[P]):
    """A curve that was followed, in both directions if it continues in both."""

    number: int  # from 1
    start: Start[P]  # where it was followed from
    traced: TracedCurve[P]  # what was followed
    started: End | None  # why it begins where it begins; None where that is at its start

    @property
    def interrupted(self) -> bool:
        """Whether it was interrupted."""
        return any(end and end.kind == "interrupted" for end in (self.started, self.traced.end))


@dataclass(eq=False)
class CurveSet(ABC, Generic[P]):
    """Curves followed from starts and from their special points, each of them once."""

    curves: list[FollowedCurve[P]] = field(default_factory=list, init=False)
    leads: dict[Found[P], list[int]] = field(default_factory=dict, init=False)

    @abstractmethod
    def trace(self, start: Start[P], point: P) -> TracedCurve[P]:
        """Follow a start in the direction of one of its points."""

    @abstractmethod
    def children(self, followed: FollowedCurve[P]) -> Sequence[Start[P]]:
        """Return the starts of other curves on one that was followed."""

    @abstractmethod
    def known(self, start: Start[P]) -> int | None:
        """Return the number of the curve through a start, if it was followed already."""

    @property
    def interrupted(self) -> bool:
        """Whether the last curve was interrupted."""
        return bool(self.curves) and self.curves[-1].interrupted

    def lead(self, found: Found[P] | None, number: int) -> None:
        """Store which curve a special point leads to."""
        if found is not None and number not in self.leads.setdefault(found, []):
            self.leads[found].append(number)

    def explore(self, start: Start[P]) -> None:
        """Follow a curve and all that emanate from it."""
        waiting = [start]
        with self.kept_if_interrupted():
            while waiting and not self.interrupted:
                start = min(waiting, key=lambda item: item.rank)
                waiting.remove(start)
                number = self.known(start)
                if number is not None:
                    if number != start.parent:  # a point leads from a curve to others
                        self.lead(start.found, number)
                    continue
                followed = self._follow(start)
                self.lead(start.found, followed.number)
                waiting += self.children(followed)

    @contextmanager
    def kept_if_interrupted(self) -> Iterator[None]:
        """Let an interruption end the search after the last curve, if there is one."""
        try:
            yield
        except KeyboardInterrupt:
            if not self.curves:
                raise
            end = self.curves[-1].traced.end
            assert end is not None
            reason = f"{end.reason}; interrupted before others were found"
            self.curves[-1].traced.end = replace(end, kind="interrupted", reason=reason)

    def _follow(self, start: Start[P]) -> FollowedCurve[P]:
        """Follow a curve in all its directions; a closed one has only one."""
        traced, started = self.trace(start, start.points[0]), None
        interrupted = traced.end is None or traced.end.kind == "interrupted"
        if len(start.points) > 1 and not (traced.closes or interrupted):
            backward = self.trace(start, start.points[1])  # which is all of it if it closes
            traced = backward if backward.closes else joined(backward, traced)
            started = backward.end
        started = traced.end if traced.closes else started
        followed = FollowedCurve(len(self.curves) + 1, start, traced, started)
        self.curves.append(followed)
        return followed
