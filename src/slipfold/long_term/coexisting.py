"""Branches that are not connected to known ones: from a start each, or from many."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.gaps import BranchSearch, gaps_between
from slipfold.bifurcations.branches.orbit_between import orbits_at
from slipfold.bifurcations.branches.start import Begin
from slipfold.errors import InputError
from slipfold.long_term.attractor import Attractor, stroboscopic_states
from slipfold.long_term.search import UNDECIDED, Box, SearchResult, box_around, search
from slipfold.long_term.verified import ATTRACTOR, CycleLine
from slipfold.models.angles import distances
from slipfold.models.equilibria import equilibria_in
from slipfold.models.model import Model
from slipfold.orbits.find import periodic_orbit
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.progress import Observer, Progress

Follow = Callable[..., tuple[Branch, ...]]
"""A function that follows a branch, and all branches that leave it, from a start `begin`."""

INTERRUPTED = "interrupted before a motion had settled"


class GAPS:
    """Where a solution is started between branches."""

    # Share of the span that a gap has at least: a screen shows it, and a branch is worth its time
    wide: float = 0.05
    # Places at which a solution is started: each takes as long as a short branch
    places: int = 3


class Further:
    """Branches of a response, and those from further starts."""

    def __init__(self, branches: tuple[Branch, ...], follow: Follow) -> None:
        self.interrupted = any(branch.interrupted for branch in branches)
        self._response = branches
        self._follow = follow
        self._added: list[tuple[Begin, tuple[Branch, ...]]] = []

    @property
    def branches(self) -> tuple[Branch, ...]:
        """All branches, new ones last."""
        known = self._response
        for _, new in self._added:
            known = (*known, *_numbered(new, len(known)))
        return known

    def add(self, begin: Callable[[], Begin]) -> str:
        """Follow the branches from a start, unless a branch passes through it.

        Branches that are found to emanate from the new ones are replaced by them. Return why
        nothing was followed; empty if something was, or is known. An interruption keeps the
        branches followed so far.
        """
        if self.interrupted:
            return ""
        try:
            start = begin()
            if not _is_known(start, self.branches):
                new = self._follow(begin=start)
                kept = [item for item in self._added if not _is_known(item[0], new)]
                self._added = [*kept, (start, new)]
                self.interrupted = any(branch.interrupted for branch in new)
        except KeyboardInterrupt:
            self.interrupted = True
            return INTERRUPTED
        except InputError as error:
            return str(error)
        return ""

    def fill_gaps(
        self,
        model: Model,
        span: tuple[float, float],
        begin: Callable[[float], Begin],
        own: float,
        observer: Observer | None,
    ) -> str:
        """Add the branches of attractors at parameter values that no branch reaches.

        These are the model's own value, if it is one, and middles of gaps. Beyond a limit of the
        model there is nothing to follow. Return why not all of them were tried; empty if they were.
        """
        tried = list[float]()
        while len(tried) < GAPS.places:
            branches = self.branches
            gaps = (
                [] if any(item.interrupted for item in branches) else _open(branches, model, span)
            )
            gaps = [
                part
                for low, high in gaps
                for part in pairwise(sorted({low, high, *(v for v in tried if low < v < high)}))
            ]
            if not gaps:
                break
            low, high = max(gaps, key=lambda gap: gap[1] - gap[0])
            mine = not tried and any(first < own < last for first, last in gaps)
            at = own if mine else (low + high) / 2
            tried.append(at)
            why = self.add(partial(_reported, observer, len(tried), branches, at, begin))
            if self.interrupted:
                return why
        return ""

    def search(
        self,
        model: Model,
        vary: str,
        span: tuple[float, float],
        box: Box | None,
        observer: Observer | None,
    ) -> BranchSearch:
        """Add the branches of orbits that trajectories find at some parameter values.

        Return a record of the search.
        """
        box = box or box_around(model, _reached(model, self.branches))
        low, high = tuple(box.low.tolist()), tuple(box.high.tolist())
        count, undecided, before = ATTRACTOR.search_values, 0, self._added
        values = tuple(span[0] + (i + 0.5) / count * (span[1] - span[0]) for i in range(count))
        for index, value in enumerate(values):
            if self.interrupted:
                break
            place = len(self.branches), index, value
            on_progress = None if observer is None else partial(_report_place, observer, *place)
            try:
                at, starts = model.replace(**{vary: value}), box.starts(ATTRACTOR.search_starts, 0)
                seen = search(at, starts, ATTRACTOR.search_periods, on_progress, measure=False)
                undecided += int((seen.labels == UNDECIDED).sum())
                self.interrupted = seen.interrupted
                for begin in () if seen.interrupted else _begins(at, value, seen, starts):
                    self.add(begin)
            except InputError:  # parameters contradict each other there
                continue
            except KeyboardInterrupt:
                self.interrupted = True
        earlier = [new for start, new in self._added if (start, new) in before]
        found = self.branches[len(self._response) + sum(map(len, earlier)) :]
        numbers = tuple(branch.id for branch in found)
        stopped = self.interrupted
        return BranchSearch(values, low, high, ATTRACTOR.search_starts, numbers, stopped, undecided)


def _reported(
    observer: Observer | None,
    place: int,
    branches: Sequence[Branch],
    value: float,
    begin: Callable[[float], Begin],
) -> Begin:
    """Report what is known before a gap is looked into; return what is there."""
    if observer is not None:
        values = {**_at(len(branches), value), "branches": branches}
        observer(Progress("gaps", place - 1, GAPS.places, values=values))
    return begin(value)


def _open(
    branches: Sequence[Branch], model: Model, span: tuple[float, float]
) -> list[tuple[float, float]]:
    """Return gaps in which there may be something."""
    limits = [end.value for branch in branches for end in branch.ends if end.kind == "limit"]
    gaps = gaps_between(branches, span, GAPS.wide, not model.forced)
    return [gap for gap in gaps if not any(np.isclose(end, gap).any() for end in limits)]


STAGE = "search for others"


def _report_place(
    observer: Observer, branches: int, place: int, value: float, progress: Progress
) -> None:
    """Report the progress of the search at one parameter value."""
    done = place * ATTRACTOR.search_starts + progress.done
    total = ATTRACTOR.search_values * ATTRACTOR.search_starts
    observer(Progress(STAGE, done, total, values=_at(branches, value)))


def _at(branches: int, value: float) -> dict[str, Any]:
    """Return what is reported between branches: how many there are, and a parameter value."""
    return {"branch": branches, "points": 0, "parameter": value, "special": (), "period": 1}


def _begins(
    model: Model, value: float, seen: SearchResult, starts: Array
) -> Iterator[Callable[[], Begin]]:
    """Yield what returns starts of branches: attractors, equilibria of an autonomous model."""
    yield from (partial(_begin, model, value, item) for item in seen.attractors)
    for state in () if model.forced else equilibria_in(model, starts):
        yield partial(Begin, value, state=state)


def _begin(model: Model, value: float, item: Attractor) -> Begin:
    if item.kind == "equilibrium":
        return Begin(value, state=item.state)
    period = item.period or 1
    return Begin(value, periodic_orbit(model, period, item.state, duration=item.duration))


def _numbered(branches: Sequence[Branch], before: int) -> tuple[Branch, ...]:
    """Return branches numbered after the existing ones."""

    def moved(number: int | None) -> int | None:
        return None if number is None else number + before

    return tuple(
        replace(
            branch,
            id=branch.id + before,
            parent=moved(branch.parent),
            special=tuple(replace(p, leads_to=moved(p.leads_to)) for p in branch.special),
        )
        for branch in branches
    )


def _reached(model: Model, branches: Sequence[Branch]) -> Array:
    """Return how far orbits of branches reach from the model's start, shape (n,)."""
    away = [np.abs(branch.nodes - model.start) for branch in branches if len(branch)]
    reached = [each.max(axis=(0, 1)) for each in away]
    # Isolas lie beyond what branches reach.
    return np.asarray(2.0 * np.max([model.state_scales(), *reached], axis=0))


def _orbits_near(branch: Branch, value: float) -> Iterator[PeriodicOrbit]:
    """Yield the orbits of a branch at a value of its parameter, or at a fold beside it."""
    yield from orbits_at(branch, value)
    # A fold is on no chord that passes the value; orbits part with the root of the distance.
    near = ATTRACTOR.same_branch**2 * np.ptp(branch.parameter)
    yield from (item.orbit for item in branch.special if abs(item.value - value) <= near)


def _is_known(begin: Begin, branches: Sequence[Branch]) -> bool:
    """Whether a branch passes through a start."""
    return any(
        _is_one(begin, orbit, branch)
        for branch in branches
        for orbit in _orbits_near(branch, begin.value)
    )


def _is_one(begin: Begin, orbit: PeriodicOrbit, branch: Branch) -> bool:
    """Whether an orbit of a branch is that of a start."""
    model, resting = orbit.model, branch.kind == "equilibrium"
    if begin.orbit is None or resting:
        if begin.orbit is not None or not resting or begin.state is None:
            return False
        return bool(distances(model, begin.state, orbit.state) < ATTRACTOR.same_branch)
    if model.forced:
        if orbit.period != begin.orbit.period:
            return False
        apart = distances(model, stroboscopic_states(begin.orbit), orbit.state)
        return bool(apart.min() < ATTRACTOR.same_branch)
    same = abs(orbit.duration / begin.orbit.duration - 1) < ATTRACTOR.same_branch
    line = CycleLine(begin.orbit, begin.orbit.model.state_scales())
    return same and bool(line.distance(orbit.state) < ATTRACTOR.same_branch)
