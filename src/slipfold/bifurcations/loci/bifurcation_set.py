"""All bifurcations of a model in a window of a plane, and the regions between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.loci.fan import (
    FanLine,
    GrazingEnds,
    at_rest,
    follow_fan,
    follow_settled,
    with_cycles,
)
from slipfold.bifurcations.loci.follow import follow_found
from slipfold.bifurcations.loci.into_stick import (
    follow_sticking,
    points_in_stick,
    unfinished,
    without_duplicates,
)
from slipfold.bifurcations.loci.isolated import PERIODS, follow_isolated
from slipfold.bifurcations.loci.locus import Locus
from slipfold.bifurcations.loci.region_map import RegionMap
from slipfold.bifurcations.loci.regions import map_regions
from slipfold.bifurcations.loci.window import Plane, Window, measured_across, parse_plane
from slipfold.errors import InputError, refusal
from slipfold.flow.modes import MET, contacts_of
from slipfold.models.equilibria import check_followed
from slipfold.models.model import Model
from slipfold.orbits.bifurcation_types import LOCUS_TYPES
from slipfold.progress import Observer

LINES = (11, 5)
"""Numbers of lines across the window in each direction; loci start on the responses there."""


@dataclass(frozen=True, eq=False)
class BifurcationSet:
    """Loci and regions of a window; frozen."""

    loci: tuple[Locus, ...]
    # The regions; None if they were not requested or the computation was interrupted
    regions: RegionMap | None
    interrupted: bool  # whether the computation was interrupted
    # Sentences on special points that could not be followed, and on why there are no regions
    missing: tuple[str, ...] = ()


def find_bifurcation_set(
    model: Model,
    plane: tuple[str, str],
    window: Window,
    *,
    types: Sequence[str] | None = None,
    periods: Sequence[int] = PERIODS,
    regions: bool | None = None,
    settings: Settings | None = None,
    observer: Observer | None = None,
) -> BifurcationSet:
    """Find the loci of all bifurcations in a window, and the stable responses between them.

    Responses are followed across the window in both directions. The locus of each special point is
    followed unless it is known, and so are loci that start at points of codimension two. Where a
    response ends because a contact begins to stick, the grazing locus is followed.
    """
    plane, window = parse_plane(model, plane, window)
    every, (types, periods) = types is not None, check_requested(model, types, periods)
    why = _no_regions(model, types, periods)
    if regions and why:
        raise InputError(f"{why}; leave regions and regimes out")
    # Hopf loci need no cycles.
    followed = (0,) if types == ("HB",) else periods
    settings = replace(settings or Settings(), largest_period=max(followed))
    if model.estimated_scales is None:
        model = measured_across(model, plane, window)
    at = Plane(model, plane, window, settings, observer)
    search = _Search(at, types, periods, every, GrazingEnds(at))
    loci = search.follow_loci()
    if search.lines and not any(line.branches or line.sticking for line in search.lines):
        raise InputError(
            f"no response exists on any of {len(search.lines)} lines across the window: "
            f"{search.lines[0].failure}"
        )
    wanted = not why if regions is None else regions
    labels = search.map_regions(loci) if wanted and not search.interrupted else None
    is_noted = why and regions is None and not every and periods == PERIODS
    notes = (f"no regions: {why}",) if is_noted else ()
    return BifurcationSet(loci, labels, search.interrupted, (*search.missing(loci), *notes))


def _no_regions(model: Model, types: Sequence[str], periods: Sequence[int]) -> str:
    """Return why a set cannot have regions, whose labels are those of orbits in slip."""
    if not model.forced:
        return f"regions exist for forced models only, and {model.name} is autonomous"
    if types == possible_types(model) and periods == PERIODS:
        return refusal(check_followed, model)
    return (
        f"regions need the loci of all types ({', '.join(possible_types(model))}) and both periods "
        "(1, 2)"
    )


@dataclass(eq=False)
class _Search:
    """The state of a search for the loci in a window."""

    plane: Plane
    types: Sequence[str]
    periods: Sequence[int]
    every: bool  # also changes of contacts of responses that stick already
    grazing: GrazingEnds
    lines: list[FanLine] = field(default_factory=list)
    interrupted: bool = False
    _apart: list[FanLine] = field(default_factory=list)  # equilibria off the lines, with cycles
    _remarks: list[str] = field(default_factory=list)

    def follow_loci(self) -> tuple[Locus, ...]:
        """Follow each locus as soon as a response has a point of it, and report it at once."""
        plane, stops = self.plane, list[KeyboardInterrupt]()
        points = (
            point
            for point in until_interrupted(self._points(), stops)
            if point.type in self.types
            and point.period in self.periods
            and plane.contains([point.model.values[name] for name in plane.names])
        )
        loci = follow_found(
            points, plane, self.types, max(self.periods), self._remarks, through_stick=True
        )
        loci = without_duplicates(loci, plane.window)
        stopped = [*(line.interrupted for line in self.lines), *(each.interrupted for each in loci)]
        self.interrupted = bool(stops) or any(stopped)
        return loci

    def _points(self) -> Iterator[SpecialPoint]:
        """Yield the special points of responses, and the grazing points near their ends."""
        plane, lines = self.plane, self.lines
        if not plane.model.forced and max(self.periods) > 0:
            # Equilibria come first: they take seconds, cycles near homoclinic orbits minutes.
            equilibria = replace(plane, settings=replace(plane.settings, largest_period=0))
            for number, line in enumerate(at_rest(equilibria, LINES)):
                yield from self._on(line.branches)
                points = (point for branch in line.branches for point in branch.special)
                if number >= sum(LINES) and any(point.type == "HB" for point in points):
                    self._apart.append(line)
        for line in self._across():
            lines.append(line)
            if line.interrupted:
                return
            yield from self._on(line.branches)
        others = follow_isolated(plane, lines, everywhere=bool(self.grazing.points))
        for branch in others if plane.model.forced else ():
            yield from self._on([branch])
        for branch in follow_sticking(plane, lines):
            yield from points_in_stick(branch, self.every)

    def _on(self, branches: Sequence[Branch]) -> Iterator[SpecialPoint]:
        yield from (point for branch in branches for point in branch.special)
        if any(kind in self.types for kind in MET):
            yield from self.grazing.near(branches)

    def _across(self) -> Iterator[FanLine]:
        """Follow responses across the window, one after the other."""
        yield from follow_fan(self.plane, LINES)
        if not self.plane.model.forced:
            yield from follow_settled(self.plane, self.lines)
        if self.plane.settings.largest_period > 0:
            yield from (with_cycles(self.plane, line) for line in self._apart)

    def map_regions(self, loci: Sequence[Locus]) -> RegionMap | None:
        """Label the regions between loci; return None if that is interrupted."""
        try:
            middle = np.mean(self.plane.window, axis=1)
            text = f"between {len(loci)} loci"
            self.plane.report("regions", 0, None, middle, text, loci=loci)
            return map_regions(self.plane, loci, self.lines, self.grazing.points)
        except KeyboardInterrupt:
            self.interrupted = True
            return None

    def missing(self, loci: Sequence[Locus]) -> tuple[str, ...]:
        """Return a sentence for each point or response that could not be followed."""
        failures = [line.failure for line in self.lines[sum(LINES) :] if line.failure]
        ends = [text for line in self.lines for text in unfinished(self.plane, line, loci)]
        return tuple(dict.fromkeys([*self._remarks, *failures, *ends]))


def until_interrupted(
    points: Iterator[SpecialPoint], stops: list[KeyboardInterrupt]
) -> Iterator[SpecialPoint]:
    """Yield points until the observer stops the search, and note whether it did."""
    try:
        yield from points
    except KeyboardInterrupt as stop:
        stops.append(stop)


def possible_types(model: Model) -> tuple[str, ...]:
    """Return the types of loci that a model can have.

    Autonomous models alone have HB; models with contacts that can stick alone have GRAZE, LIFT and
    STICK.

    >>> from slipfold.models.registry import model_named
    >>> possible_types(model_named("lure"))
    ('LP', 'PD', 'NS', 'BP', 'HB')
    >>> possible_types(model_named("sliding"))
    ('LP', 'PD', 'NS', 'BP', 'GRAZE', 'LIFT', 'STICK')
    """
    missing = {*(() if contacts_of(model) else MET), *(("HB",) if model.forced else ())}
    return tuple(kind for kind in LOCUS_TYPES if kind not in missing)


def check_requested(
    model: Model, types: Sequence[str] | None, periods: Sequence[int]
) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Return the requested types and periods without duplicates, in the standard order."""
    possible = possible_types(model)
    types = possible if types is None else types
    for kind in types:
        if kind not in possible:
            if kind in MET:
                raise InputError(
                    f"there are no loci of type {kind!r} of {model.name}, none of whose contacts "
                    f"sticks; give {', '.join(possible)}"
                )
            of = "" if kind not in LOCUS_TYPES else f" of {model.name}, which is forced"
            raise InputError(f"there are no loci of type {kind!r}{of}; give {', '.join(possible)}")
    for period in periods:
        if period not in PERIODS:
            raise InputError(
                f"period = {period!r} is neither 1 nor 2; follow loci of longer periods from their "
                "special points with slipfold.locus"
            )
    if not types or not periods:
        raise InputError("no type or no period of loci is given; give e.g. PD and 1")
    chosen = tuple(kind for kind in possible if kind in types)
    return chosen, tuple(period for period in PERIODS if period in periods)
