"""Branches that are not connected to known ones: from a start each, or from many."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.orbit_between import orbit_between
from slipfold.bifurcations.branches.start import Begin
from slipfold.errors import InputError
from slipfold.long_term.attractor import Attractor, stroboscopic_states
from slipfold.long_term.branch_search import BranchSearch
from slipfold.long_term.search import Box, box_around, search
from slipfold.long_term.verified import ATTRACTOR, CycleLine
from slipfold.models.angles import wrap_angles
from slipfold.models.equilibria import damped_newton
from slipfold.models.model import Model, evaluation_of
from slipfold.orbits.find import periodic_orbit
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.progress import Observer, Progress


def equilibria_in(model: Model, starts: Array) -> list[Array]:
    """Return the equilibria that Newton's method finds from many starts, each once.

    Equilibria beyond a limit of the model are left out. Shapes: starts (k, n).
    """
    functions, scales = evaluation_of(model), model.state_scales()
    # There are other starts.
    states = damped_newton(functions.linear_of(model), starts, scales, halvings=12)
    result: list[Array] = []
    for state in states[np.isfinite(states).all(axis=1)]:
        values = dict(
            zip(functions.names, functions.outputs(model, state, np.zeros(())), strict=True)
        )
        if any(not values[limit.output] > limit.bound for limit in model.limits):
            continue
        reduced = wrap_angles(state, model.angle_periods)
        apart = [wrap_angles(reduced - other, model.angle_periods) / scales for other in result]
        if all(np.abs(each).max() > 1e-8 for each in apart):
            result.append(reduced)
    return result


class Follow(Protocol):
    """A function that follows a branch, and all branches that leave it, from a start."""

    def __call__(self, *, begin: Begin) -> tuple[Branch, ...]:
        """Return the branches that start there."""
        ...


@dataclass(frozen=True)
class GapSettings:
    """Where a solution is started between branches."""

    # Share of the span that a gap has at least: a screen shows it, and a branch is worth its time
    wide: float = 0.05
    # Places at which a solution is started: each takes as long as a short branch
    places: int = 3


GAPS = GapSettings()


def gaps_between(
    branches: Sequence[Branch], span: tuple[float, float], share: float, settled: bool = False
) -> list[tuple[float, float]]:
    """Return the parts of a span, wider than a share of it, that no branch reaches.

    With `settled` an equilibrium counts only where it is stable.
    """
    low, high = sorted(span)
    gaps, reached = [], low
    for first, last in sorted(part for branch in branches for part in _reach(branch, settled)):
        if first > reached:
            gaps.append((reached, first))
        reached = max(reached, last)
    if reached < high:
        gaps.append((reached, high))
    return [gap for gap in gaps if gap[1] - gap[0] > share * (high - low)]


def _reach(branch: Branch, settled: bool) -> Iterator[tuple[float, float]]:
    if settled and branch.kind == "equilibrium":
        for i in np.flatnonzero(branch.stable[:-1] & branch.stable[1:]):
            ends = branch.parameter[i : i + 2]
            yield float(ends.min()), float(ends.max())
        return
    values = [*branch.parameter, *(point.value for point in branch.special)]
    if values:
        yield float(min(values)), float(max(values))


def follow_from(
    branches: tuple[Branch, ...], follow: Follow, begin: Callable[[], Begin]
) -> tuple[tuple[Branch, ...], str]:
    """Return branches and those from a further start, unless one of them passes through it.

    Beside them: why nothing was followed from there; empty if something was, or is known.
    """
    try:
        start = begin()
        if not _is_known(start, branches):
            branches = (*branches, *_numbered(follow(begin=start), len(branches)))
    except InputError as error:
        return branches, str(error)
    return branches, ""


def fill_gaps(
    model: Model,
    span: tuple[float, float],
    branches: tuple[Branch, ...],
    follow: Follow,
    begin: Callable[[float], Begin],
) -> tuple[Branch, ...]:
    """Return branches and those of attractors at parameter values that none of them reaches.

    Beyond a limit of the model there is nothing to follow.
    """
    tried = list[float]()
    limits = {end.value for branch in branches for end in branch.ends if end.kind == "limit"}
    while len(tried) < GAPS.places and not any(branch.interrupted for branch in branches):
        gaps = [
            (low, high)
            for low, high in gaps_between(branches, span, GAPS.wide, not model.forced)
            if not any(low < value < high for value in tried)
            and not any(np.isclose(end, (low, high)).any() for end in limits)
        ]
        if not gaps:
            break
        low, high = max(gaps, key=lambda gap: gap[1] - gap[0])
        tried.append((low + high) / 2)
        branches, _ = follow_from(branches, follow, lambda: begin(tried[-1]))
    return branches


STAGE = "search for others"


def find_coexisting(
    model: Model,
    vary: str,
    span: tuple[float, float],
    branches: tuple[Branch, ...],
    follow: Follow,
    box: Box | None = None,
    observer: Observer | None = None,
) -> tuple[tuple[Branch, ...], BranchSearch]:
    """Search for orbits that coexist with branches at some parameter values, and follow them.

    Return all branches, new ones last, and a record of the search. An interruption keeps the
    branches followed so far.
    """
    box = box or box_around(model, _reached(model, branches))
    values = tuple(
        span[0] + (i + 0.5) / ATTRACTOR.search_values * (span[1] - span[0])
        for i in range(ATTRACTOR.search_values)
    )
    result: list[int] = []
    known, interrupted = branches, any(branch.interrupted for branch in branches)
    for index, value in enumerate(values):
        if interrupted:
            break

        on_progress = (
            None if observer is None else _PlaceProgress(observer, len(known), index, value)
        )
        try:
            at = model.replace(**{vary: value})
            seen = _seen(at, value, box, on_progress)
            interrupted = seen.interrupted
            for begin in () if interrupted else seen.begins:
                if not _is_known(begin, known):
                    new = _numbered(_followed(follow, begin), len(known))
                    known, result = (*known, *new), [*result, *(branch.id for branch in new)]
            interrupted |= any(branch.interrupted for branch in known)
        except InputError:  # parameters contradict each other there
            continue
        except KeyboardInterrupt:
            interrupted = True
    low, high = tuple(box.low.tolist()), tuple(box.high.tolist())
    return known, BranchSearch(
        values, low, high, ATTRACTOR.search_starts, tuple(result), interrupted
    )


@dataclass(frozen=True)
class _PlaceProgress:
    """Reports the progress of the search at one parameter value."""

    observer: Observer
    branches: int
    place: int
    value: float

    def __call__(self, progress: Progress) -> None:
        done, total = (
            self.place * ATTRACTOR.search_starts + progress.done,
            ATTRACTOR.search_values * ATTRACTOR.search_starts,
        )
        values = {"branch": self.branches, "points": 0, "parameter": self.value, "special": ()}
        self.observer(Progress(STAGE, done, total, values={**values, "period": 1}))


@dataclass(frozen=True, eq=False)
class _Seen:
    """Starts of branches at a value of the parameter."""

    begins: list[Begin]
    interrupted: bool


def _seen(model: Model, value: float, box: Box, on_progress: Observer | None) -> _Seen:
    starts = box.starts(ATTRACTOR.search_starts, 0)
    searched = search(model, starts, 256, on_progress, measure=False)  # periods of each trajectory
    begins = [begin for item in searched.attractors if (begin := _begin(model, value, item))]
    if not model.forced:
        resting = equilibria_in(model, starts)
        begins += [Begin(value, state=state) for state in resting]
    return _Seen(begins, searched.interrupted)


def _begin(model: Model, value: float, item: Attractor) -> Begin | None:
    try:
        if item.kind == "periodic":
            return Begin(value, periodic_orbit(model, item.period or 1, item.state))
        if item.kind == "cycle":
            return Begin(value, periodic_orbit(model, state=item.state, duration=item.duration))
    except InputError:
        return None
    return Begin(value, state=item.state) if item.kind == "equilibrium" else None


def _followed(follow: Follow, begin: Begin) -> tuple[Branch, ...]:
    """Follow branches from a start; none if it cannot be continued."""
    try:
        return follow(begin=begin)
    except InputError:
        return ()


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


def _orbits_at(branch: Branch, value: float) -> Iterator[PeriodicOrbit]:
    """Return the orbits of a branch at a value of its parameter."""
    away = branch.parameter - value
    for i in np.flatnonzero(away[:-1] * away[1:] <= 0):
        fraction = away[i] / (away[i] - away[i + 1]) if away[i] != away[i + 1] else 0.0
        arclength = branch.arclength[i] + fraction * (branch.arclength[i + 1] - branch.arclength[i])
        try:
            yield orbit_between(branch, float(arclength), value)
        except InputError:
            continue


def _is_known(begin: Begin, branches: Sequence[Branch]) -> bool:
    """Whether a branch passes through a start."""
    return any(
        _is_one(begin, orbit, branch)
        for branch in branches
        for orbit in _orbits_at(branch, begin.value)
    )


def _is_one(begin: Begin, orbit: PeriodicOrbit, branch: Branch) -> bool:
    """Whether an orbit of a branch is that of a start."""
    model, resting = orbit.model, branch.kind == "equilibrium"
    if begin.orbit is None or resting:
        if begin.orbit is not None or not resting or begin.state is None:
            return False
        apart = wrap_angles(begin.state - orbit.state, model.angle_periods)
        return bool(np.abs(apart / model.state_scales()).max() < ATTRACTOR.same_branch)
    if model.forced:
        if orbit.period != begin.orbit.period:
            return False
        apart = wrap_angles(stroboscopic_states(begin.orbit) - orbit.state, model.angle_periods)
        return bool(np.abs(apart / model.state_scales()).max(axis=1).min() < ATTRACTOR.same_branch)
    same = abs(orbit.duration / begin.orbit.duration - 1) < ATTRACTOR.same_branch
    line = CycleLine(begin.orbit, begin.orbit.model.state_scales())
    return same and bool(line.distance(orbit.state) < ATTRACTOR.same_branch)
