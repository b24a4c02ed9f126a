"""Orbits of branches, loci and threshold maps computed again by other means.

As many are computed again as a tenth of the work for the result pays for.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import accumulate, chain
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.progress import branch_progress
from slipfold.bifurcations.branches.solution_curve import OrbitSeries, names_of
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.flow.hybrid_flow import hybrid_system
from slipfold.flow.modes import CONTACT, MET, contacts_of
from slipfold.orbits.bifurcation_types import CONTACT_TYPES
from slipfold.orbits.check import rests
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.progress import Observer, Progress
from slipfold.results.checks.checked import CHECKS, Check, Checked
from slipfold.results.checks.orbit_difference import (
    Difference,
    balanced_difference,
    orbit_differences,
    pieces_of,
    retraced_difference,
)
from slipfold.results.checks.switched import switched_difference
from slipfold.text import place_text

if TYPE_CHECKING:
    from slipfold.bifurcations.loci.locus import Locus

ENDS = ((-1, "end"), (0, "beginning"))
"""Indices and names of the ends of a curve."""


class Candidate(NamedTuple):
    """An orbit that may be checked."""

    name: str
    orbit: PeriodicOrbit
    resting: bool


def check_branches(branches: Sequence[Branch], observer: Observer | None = None) -> Checked:
    """Check special points, the first one of each branch first, then ends."""

    def progress(done: int) -> Progress:
        last = branches[-1]
        at = last.id, last.period, len(last), last.stopped.value
        names = tuple(point.type for point in last.special)
        note = branch_progress(last.model.parameter(last.vary), *at, names, "checks", done)
        return replace(note, values={**note.values, "branches": branches})

    return _check_curves(branches, _on_branches(branches), progress, observer)


def check_together(cases: Sequence[Sequence[Branch]]) -> list[Checked]:
    """Check the branches of many cases that were followed together, which is less work for each."""
    each = [_Checks() for _ in cases]
    for branches, checks in zip(cases, each, strict=True):
        _choose(_on_branches(branches), CHECKS.batched * _points(branches), checks)
    _compare(each)
    return [Checked(tuple(checks.done)) for checks in each]


def _on_branches(branches: Sequence[Branch]) -> Iterator[Candidate]:
    for branch, point in _ranked(branches):
        yield _special(branch, point)
    for branch in branches:
        for index, word in ENDS if len(branch) else ():
            # The first point is left out where it is the one from which the branch emanates.
            if index == -1 or (branch.started.kind != "bifurcation" and len(branch) > 1):
                yield _end(branch, index, word)


def check_loci(loci: Sequence[Locus], observer: Observer | None = None) -> Checked:
    """Check the ends of each locus, then its special points, those that come first first."""
    # Next to a grazing orbit the order of events changes, so there is nothing to compare with.
    chosen = [locus for locus in loci if len(locus) and locus.type not in MET]
    ends = (_end(locus, index, word) for index, word in ENDS for locus in chosen)
    special = (
        Candidate(
            f"{point.type} of locus {locus.id} at {_at(locus, point.values)}",
            point.orbit,
            locus.kind == "equilibrium",
        )
        for locus, point in _ranked(chosen)
        if point.type not in CONTACT_TYPES
    )

    def progress(done: int) -> Progress:
        from slipfold.bifurcations.loci.window import locus_progress  # a response needs no loci

        first, second = loci[-1].stopped.values
        return locus_progress("checks", done, None, (first, second), "by another method")

    return _check_curves(loci, chain(ends, special), progress, observer)


def _check_curves(
    curves: Sequence[OrbitSeries],
    candidates: Iterable[Candidate],
    progress: Callable[[int], Progress],
    observer: Observer | None,
) -> Checked:
    """Check orbits of curves; none if one is interrupted."""
    if any(curve.interrupted for curve in curves):
        return Checked((), interrupted=True)

    def report(done: int) -> None:
        if observer is not None:
            observer(progress(done))

    return check_some(candidates, _points(curves), report)


def _points(curves: Sequence[OrbitSeries]) -> float:
    """Return the work for curves, in points of period 1."""
    return float(sum(len(curve) * curve.period for curve in curves))


def check_some(
    candidates: Iterable[Candidate],
    points: float,
    on_progress: Callable[[int], None] = lambda done: None,
) -> Checked:
    """Check orbits in their order as long as the work for so many points of a branch allows it.

    The first is checked in any case; if it is too expensive, only its states are. An interruption
    returns what is done.
    """
    checks = _Checks()
    try:
        try:
            _choose(candidates, points, checks, on_progress)
        finally:
            checks.compare()
    except KeyboardInterrupt:
        return Checked(tuple(checks.done), interrupted=True)
    return Checked(tuple(checks.done))


def _choose(
    candidates: Iterable[Candidate],
    points: float,
    checks: _Checks,
    on_progress: Callable[[int], None] = lambda done: None,
) -> None:
    """Check orbits in their order, or let them wait, as long as the work allows it."""
    left = CHECKS.fraction * points
    for candidate in candidates:
        if left < CHECKS.equilibrium and checks.count:
            break
        on_progress(len(checks.done))
        left -= _check(candidate, left, checks)


class _Checks:
    """Checks of a result in their order; those by collocation are done many at a time."""

    def __init__(self) -> None:
        self.done: list[Check] = []
        self.waiting: list[tuple[Candidate, int]] = []

    @property
    def count(self) -> int:
        """Number of checks, done or waiting."""
        return len(self.done) + len(self.waiting)

    def add(self, candidate: Candidate, method: str, found: Difference) -> None:
        """Record a comparison."""
        self.compare()
        self.done.append(_named(candidate, method, found))

    def compare_later(self, candidate: Candidate, pieces: int) -> None:
        """Compare an orbit with collocation, together with those that follow."""
        self.waiting.append((candidate, pieces))
        if sum(count for _, count in self.waiting) >= CHECKS.together:
            self.compare()

    def compare(self) -> None:
        """Compare the orbits that wait with collocation."""
        _compare([self])


def _compare(each: Sequence[_Checks]) -> None:
    """Compare the orbits that wait with collocation, those of several results together."""
    waiting = [(checks, *item) for checks in each for item in checks.waiting]
    while waiting:
        ahead = list(accumulate(count for *_, count in waiting))
        some = waiting[: bisect_left(ahead, CHECKS.together) + 1]
        with np.errstate(all="ignore"):  # numbers of a wrong orbit may overflow
            # Whoever interrupts it finds them still waiting.
            orbits = [candidate.orbit for _, candidate, _ in some]
            differences = orbit_differences(orbits, [count for *_, count in some])
        for (checks, candidate, _), found in zip(some, differences, strict=True):
            checks.done.append(_named(candidate, "collocation", found))
            checks.waiting.pop(0)
        del waiting[: len(some)]


def _named(candidate: Candidate, method: str, found: Difference) -> Check:
    return Check(candidate.name, method, found.value, found.allowed, found.what, found.unknown)


def spread(count: int) -> list[int]:
    """Choose some of a row in their order: the last, the first, then halfway between others.

    There are 17 at most.

    >>> spread(100)[:5]
    [99, 0, 49, 24, 74]
    """
    fractions = [1.0, 0.0, *(odd / 2**n for n in range(1, 5) for odd in range(1, 2**n, 2))]
    return list(dict.fromkeys(int(fraction * (count - 1)) for fraction in fractions))


def _check(candidate: Candidate, left: float, checks: _Checks) -> float:
    """Check an orbit if that much is left, and return the cost; never an exception."""
    orbit, first = candidate.orbit, not checks.count
    try:
        with np.errstate(all="ignore"):  # numbers of a wrong orbit may overflow
            if isinstance(orbit, StickSlipOrbit):
                checks.add(candidate, "other steps", switched_difference(orbit))
                return CHECKS.switched
            resting = candidate.resting and rests(orbit.model, orbit.nodes)
            each = CHECKS.piece * (1 + len(orbit.state) / 20)
            least = CHECKS.base + each * CHECKS.pieces * orbit.period
            if not (first or candidate.resting) and left < min(least, CHECKS.balanced):
                return 0.0
            pieces = 0 if resting else pieces_of(orbit)
            cost = (
                CHECKS.equilibrium if resting else CHECKS.base + each * pieces if pieces else np.inf
            )
            if cost <= left:
                checks.compare_later(candidate, pieces)
                return cost
            if not resting and not pieces and (first or left >= CHECKS.balanced):
                balanced = balanced_difference(orbit)
                if balanced is not None:
                    checks.add(candidate, balanced.method, balanced)
                    return CHECKS.balanced
            if first:
                found = retraced_difference(orbit)
                checks.add(candidate, found.method, found)
    except np.linalg.LinAlgError:
        checks.add(candidate, "collocation", Difference(np.inf))
        return left
    return 0.0


def _ranked(curves: Sequence[OrbitSeries]) -> list[tuple[Any, Any]]:
    """Return curves with their special points, those that come first on each first."""
    ranked = [(rank, curve, point) for curve in curves for rank, point in enumerate(curve.special)]
    return [(curve, point) for _, curve, point in sorted(ranked, key=lambda item: item[0])]


def _end(curve: OrbitSeries, index: int, word: str) -> Candidate:
    thing = "branch" if isinstance(curve, Branch) else "locus"
    name = f"{word} of {thing} {curve.id} at {_at(curve, curve._values[index])}"
    return Candidate(name, curve.orbit(index), curve.kind == "equilibrium")


def _special(branch: Branch, point: SpecialPoint) -> Candidate:
    name = f"{point.type} of branch {branch.id} at {_at(branch, point.value)}"
    planar = any(len(each.slip) == 2 for each in contacts_of(branch.model))
    vanishes = point.type == "GRAZE" and planar
    if not (vanishes or (point.type in CONTACT_TYPES and _holds_more(point.orbit))):
        return Candidate(name, point.orbit, branch.kind == "equilibrium")
    # Slip that vanishes at a graze in the plane has no direction, so nothing propagates a
    # trajectory through it, and stops that only just happen change as square roots, which
    # differences cannot resolve: a neighbor is checked, one that always slips if there is one.
    # So it is where rounding decides whether static friction holds a contact for a time.
    away = np.abs(branch.arclength - point.arclength)
    if not vanishes:
        away[away < CHECKS.beside] = np.inf
    elif branch.stuck_fraction is not None and not (branch.stuck_fraction > 0).all():
        away[branch.stuck_fraction > 0] = np.inf
    index = int(away.argmin())
    place = _at(branch, branch.parameter[index])
    return Candidate(f"orbit near {name}, at {place},", branch.orbit(index), False)


def _holds_more(orbit: PeriodicOrbit) -> bool:
    """Whether contacts, where they are loaded, have more static friction than kinetic."""
    system = hybrid_system(orbit.model, orbit.state)
    states = orbit.sample(CHECKS.loads * orbit.period)[1]
    phases = np.linspace(0.0, orbit.period, len(states), endpoint=False)
    found = system.flow.quantities.along(states, phases, system.constants)
    return any(
        normal > 0 and holding > (1 + CONTACT.slack) * starting
        for now in found
        for normal, holding, starting in zip(now.normal, now.holding, now.starting, strict=True)
    )


def _at(curve: OrbitSeries, values: Any) -> str:
    return place_text(curve.model, names_of(curve.vary), np.atleast_1d(values).tolist())
