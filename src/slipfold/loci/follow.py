"""Loci from special points of branches, and from the points of codimension two on the way."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.end import End
from slipfold.continuation.search import Found
from slipfold.continuation.trail import Trail
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.loci.cycle_locus import CycleLocus
from slipfold.loci.describe import coefficient_at, describe_point
from slipfold.loci.known_loci import begins_or_ends_at, lies_on
from slipfold.loci.locus import Locus, LocusPoint, locus_title
from slipfold.loci.locus_problem import LocusProblem
from slipfold.loci.point_problem import locus_class, locus_unknown
from slipfold.loci.progress import LocusLine, LocusObserver, LocusProgress
from slipfold.loci.start import Start, parent_starts, regular_start, starts_at
from slipfold.loci.trace import trace_locus
from slipfold.loci.window import Window, check_window
from slipfold.models.model import Model
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["LOCUS_TYPES", "follow_loci"]

LOCUS_TYPES = ("LP", "PD", "NS", "HB")
"""Types of bifurcation that have a locus in two parameters."""

OWN = ("duration",)
"""Parameters that belong to an orbit of an autonomous model, not to the case."""


def follow_loci(
    points: Sequence[SpecialPoint],
    vary: tuple[str, str],
    window: Window,
    *,
    settings: Settings | None = None,
    observer: LocusObserver | None = None,
    switch: bool = True,
    types: Sequence[str] = LOCUS_TYPES,
    largest_period: int | None = None,
) -> tuple[Locus, ...]:
    """Follow the loci of special points in two parameters, each locus once.

    Parameters
    ----------
    points
        Special points of branches of one model, of type LP, PD, NS or HB.
    vary
        Names of the two parameters.
    window
        Least and largest value of each.
    settings
        Options of continuation.
    observer
        Called after every point; may raise `KeyboardInterrupt` to stop with what is done.
    switch
        Whether loci that begin or pass at points of codimension two are followed as well.
    types
        Types of the loci that may be started there.
    largest_period
        Largest period of their orbits, in forcing periods; twice that of the points if None.

    Returns
    -------
    tuple of Locus
        In the order in which they were followed.

    Raises
    ------
    InputError
        If a parameter or the window cannot be used, or a point has no locus in this plane.
    """
    if not points:
        return ()
    base = points[0].model
    window = check_window(base, vary, window)
    settings = settings or Settings()
    for point in points:
        _check_point(point, base, vary, window)
    largest = largest_period or 2 * max(point.period for point in points)
    work = _Work(base, vary, window, settings, observer, types if switch else (), largest)
    refusals: list[InputError] = []
    for point in points:
        problem = work.problem(point)
        z = locus_unknown(problem, point)
        if work.known_family(problem, z) is None:
            try:
                start = regular_start(problem, z, settings)
            except InputError as error:
                refusals.append(error)
                continue
            work.follow([start, start.reversed()], None)
        if work.interrupted:
            break
    if len(refusals) == len(points):  # one point among many may be known too badly to start from
        raise refusals[0]
    return work.loci()


def _check_point(point: SpecialPoint, base: Model, vary: tuple[str, str], window: Window) -> None:
    if point.type not in LOCUS_TYPES:
        raise InputError(
            f"a special point of type {point.type} has no locus in {vary[0]} and {vary[1]}; give "
            f"one of type {', '.join(LOCUS_TYPES)}"
        )
    if point.model.kind != base.kind:
        raise InputError("the special points belong to different models; follow them one by one")
    for name, value in point.model.values.items():
        if name not in (*vary, *OWN) and value != base.values[name]:
            raise InputError(
                f"the special points differ in {name}: {base.values[name]:g} and {value:g}; "
                f"vary {name} or follow them one by one"
            )
    for name, (low, high) in zip(vary, window, strict=True):
        value = point.model.values[name]
        if not low <= value <= high:
            raise InputError(
                f"the special point at {name} = {value:.6g} is outside the window from {low:g} to "
                f"{high:g}; give a window that holds it"
            )


@dataclass(eq=False)
class _Family:
    """A locus: what was traced in one direction, or in both."""

    problem: LocusProblem
    traces: list[Trail[OrbitPoint]]
    parent: int | None

    def is_like(self, problem: LocusProblem) -> bool:
        """Whether a locus is of the same type and period."""
        own = self.problem
        same = (own.type, own.period) == (problem.type, problem.period)
        return same and own.orbits == problem.orbits


@dataclass(eq=False)
class _Work:
    """Loci followed so far, and what follows from them."""

    base: Model
    vary: tuple[str, str]
    window: Window
    settings: Settings
    observer: LocusObserver | None
    types: Sequence[str]
    largest_period: int
    families: list[_Family] = field(default_factory=list)
    links: dict[tuple[int, int, int], list[int]] = field(default_factory=dict)
    bases: dict[type[LocusProblem], Model] = field(default_factory=dict)
    interrupted: bool = False

    def problem(self, point: SpecialPoint) -> LocusProblem:
        """Equations of a point's locus; those of a class share one model: unknowns compare."""
        (a, b), (c, d) = self.window
        chosen = locus_class(point)
        base = self.bases.setdefault(chosen, self.base.replace(**_own(point.model)))
        kind = "NS" if point.type == "HB" else point.type
        return chosen(base, kind, self.vary, point.period, (b - a, d - c))

    def known_family(
        self, problem: LocusProblem, z: NDArray[np.float64], doubled: bool = False
    ) -> int | None:
        """Return the number of the locus that passes a place, if it was followed already."""
        meets = begins_or_ends_at if doubled else lies_on
        for number, family in enumerate(self.families):
            if not family.is_like(problem):
                continue
            # Cycles born at a Hopf point of a locus have units of their own.
            unknown = family.problem.join(problem.nodes(z), problem.free_values(z))
            if any(meets(trace.curve, trace.points, unknown) for trace in family.traces):
                return number
        return None

    def follow(self, starts: list[Start], parent: int | None) -> None:
        """Follow a locus to both ends, then those that start on it."""
        traces: list[Trail[OrbitPoint]] = []
        problem = starts[0].problem
        family = _Family(problem, traces, parent)
        self.families.append(family)
        for start in starts:
            trace = trace_locus(
                start.problem,
                start.point,
                self.window,
                self.settings,
                born=start.born,
                watch=self._tell,
            )
            traces.append(trace)
            if start.crosses and start is starts[0]:
                trace.found[:0] = _crossed(trace, start.crosses)
            assert trace.end is not None
            if trace.end.kind == "interrupted":
                self.interrupted = True
                return
            if trace.end.kind == "closed":
                break
        self._switch(family)

    def _switch(self, family: _Family) -> None:
        number = self.families.index(family)
        for side, trace in enumerate(family.traces):
            for place, found in enumerate(trace.found):
                links = self.links.setdefault((number, side, place), [])
                for group in _groups(trace.curve, found, self.settings):
                    if self.interrupted:
                        return
                    if self._is_wanted(group[0].problem):
                        links.append(self._follow_once(group, number))
            if trace.reached and not self.interrupted:
                group = parent_starts(trace.curve, trace.points[-1], self.settings)
                if group and self._is_wanted(group[0].problem):
                    self._follow_once(group, number)

    def _is_wanted(self, problem: LocusProblem) -> bool:
        return problem.type in self.types and problem.period <= self.largest_period

    def _follow_once(self, group: list[Start], parent: int) -> int:
        """Follow a locus unless it is known; return its number."""
        start = group[0]
        known = self.known_family(start.problem, start.point.z, start.doubled)
        if known is None:
            number = len(self.families)
            self.follow(group, parent)
            return number
        if start.doubled:
            self._place_end(self.families[known], start)
        return known

    def _place_end(self, family: _Family, start: Start) -> None:
        """Give a locus that ends on its parent the exact values of where it does."""
        for trace in family.traces:
            if trace.reached and begins_or_ends_at(trace.curve, trace.points[-1:], start.point.z):
                assert trace.end is not None
                place = start.problem.place(start.point.z)
                trace.end = End(trace.end.kind, trace.end.reason, place)

    def _tell(self, trace: Trail[OrbitPoint]) -> None:
        if self.observer is None:
            return
        problem = trace.curve
        names = "".join(f", {problem.named(found.type)}" for found in trace.found)
        start, last = (_pair(problem, point) for point in (trace.points[0], trace.points[-1]))
        points = len(trace.points)
        text = (
            f"{locus_title(problem.type, problem.period, problem.orbits)}, {points} points{names}"
        )
        done = len(self.families) - 1
        number = sum(len(family.traces) for family in self.families)
        line = LocusLine(number, problem.type, problem.period, start)
        self.observer(LocusProgress("loci", done, None, last, text, line))

    def loci(self) -> tuple[Locus, ...]:
        """Return everything as data."""
        result = []
        for number, family in enumerate(self.families):
            leads = {
                key[1:]: tuple(child + 1 for child in dict.fromkeys(children))
                for key, children in self.links.items()
                if key[0] == number
            }
            result.append(_as_locus(family, number + 1, leads))
        return tuple(result)


def _pair(problem: LocusProblem, point: OrbitPoint) -> tuple[float, float]:
    first, second = problem.values(point.z)
    return float(first), float(second)


def _crossed(trace: Trail[OrbitPoint], kind: str) -> list[Found]:
    """Return the point of codimension two that a locus was started from, as found on it."""
    if kind not in trace.points[0].tests or len(trace.points) < 2:
        return []
    first, second = trace.points[:2]
    slope = (second.tests[kind] - first.tests[kind]) / (second.arclength - first.arclength)
    return [Found(kind, first, slope)]


def _groups(problem: LocusProblem, found: Found, settings: Settings) -> list[list[Start]]:
    """Return the loci that start at a point; none where what they start from breaks down."""
    try:
        return list(_grouped(starts_at(problem, found, settings)))
    except BREAKDOWNS:
        return []


def _grouped(starts: Iterator[Start]) -> Iterator[list[Start]]:
    """Put both directions of one locus together."""
    group: list[Start] = []
    for start in starts:
        if group and (start.problem is not group[0].problem):
            yield group
            group = []
        group.append(start)
    if group:
        yield group


def _as_locus(family: _Family, number: int, leads: dict[tuple[int, int], tuple[int, ...]]) -> Locus:
    """Join both directions: the second one backwards, then the first."""
    forward = family.traces[0]
    problem = forward.curve
    points, found = list(forward.points), _described(forward, 0, leads, 1.0)
    assert forward.end is not None
    begun, stopped = _first_end(forward), forward.end
    if len(family.traces) > 1:
        backward = family.traces[1]
        assert backward.end is not None
        points = [problem.turned(point) for point in backward.points[:0:-1]] + points
        found = _described(backward, 1, leads, -1.0)[::-1] + found
        begun = backward.end
    arclength = np.array([point.arclength for point in points])
    offset = arclength[0]
    durations = _durations(problem, points)
    return Locus(
        id=number,
        type=problem.type,
        kind=problem.orbits,
        period=problem.period,
        parent=None if family.parent is None else family.parent + 1,
        model=problem.model if durations is None else problem.model.replace(duration=durations[0]),
        vary=problem.vary,
        values=np.array([problem.values(point.z) for point in points]),
        nodes=np.array([problem.nodes(point.z) for point in points]),
        multipliers=np.array([problem.reported_multipliers(point) for point in points]),
        coefficient=np.array([coefficient_at(problem, point) for point in points]),
        residual=np.array([point.residual for point in points]),
        arclength=arclength - offset,
        special=tuple(replace(item, arclength=item.arclength - offset) for item in found),
        begun=begun,
        stopped=stopped,
        durations=durations,
    )


def _durations(problem: LocusProblem, points: Sequence[OrbitPoint]) -> NDArray[np.float64] | None:
    """Durations of one round of cycles in seconds; None where the parameters give them."""
    if not isinstance(problem, CycleLocus):
        return None
    return np.array([problem.duration(point.z) for point in points])


def _own(model: Model) -> dict[str, float]:
    """What belongs to an orbit of an autonomous model, not to the case."""
    return {name: model.values[name] for name in OWN if not model.forced}


def _first_end(trace: Trail[OrbitPoint]) -> End:
    """Say why a locus that was followed in one direction only begins where it does."""
    assert trace.end is not None
    if trace.end.kind in ("closed", "interrupted"):
        return trace.end
    place = trace.curve.place(trace.points[0].z)
    return End("codimension-2", "born at a point of codimension two", place)


def _described(
    trace: Trail[OrbitPoint], side: int, leads: dict[tuple[int, int], tuple[int, ...]], sign: float
) -> list[LocusPoint]:
    result = []
    for place, found in enumerate(trace.found):
        described = describe_point(trace.curve, found)
        started = leads.get((side, place), ())
        result.append(replace(described, arclength=sign * described.arclength, leads_to=started))
    return result
