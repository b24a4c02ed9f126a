"""All bifurcations of a model in a window of a plane, and the regions between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from slipfold.branches.settings import Settings
from slipfold.branches.special_point import LOCUS_TYPES, SpecialPoint
from slipfold.errors import InputError
from slipfold.flow.modes import contacts_of
from slipfold.loci.fan import FanLine, Touches, follow_fan, follow_settled, largest_period
from slipfold.loci.follow import follow_found
from slipfold.loci.into_stick import follow_sticking, found_in_stick, unfinished, without_copies
from slipfold.loci.isolated import follow_isolated
from slipfold.loci.locus import Locus
from slipfold.loci.region_map import RegionMap
from slipfold.loci.regions import map_regions
from slipfold.loci.window import Window, check_window, locus_progress, measured_across
from slipfold.models.model import Model
from slipfold.orbits.grazing import MET
from slipfold.progress import Observer

LINES = (11, 5)
"""Responses across the window in either direction from which loci are started."""

PERIODS = (1, 2)


@dataclass(frozen=True, eq=False)
class BifurcationSet:
    """Loci and regions of a window; frozen."""

    loci: tuple[Locus, ...]
    # The regions, None if they were not asked for or the computation was interrupted
    regions: RegionMap | None
    interrupted: bool  # whether the computation was interrupted
    missing: tuple[str, ...] = ()  # sentences on what was found and could not be followed


def find_bifurcation_set(
    model: Model,
    plane: tuple[str, str],
    window: Window,
    *,
    types: Sequence[str] | None = None,
    periods: Sequence[int] = PERIODS,
    regions: bool = True,
    settings: Settings | None = None,
    observer: Observer | None = None,
) -> BifurcationSet:
    """Find the loci of all bifurcations in a window, and which stable responses exist where.

    Responses are followed across the window in both directions; from each of their special points
    its locus is, unless it is known; from points of codimension two those that start there. Where a
    response ends since a contact begins to stick, the locus of that starts.
    """
    window = check_window(model, plane, window)
    types, periods = check_asked(model, types, periods)
    if regions and not model.forced:
        raise InputError(
            f"regions are found for forced models only, and {model.name} is autonomous; ask for "
            "its loci alone, regions=False"
        )
    if regions and not (types == possible_types(model) and periods == PERIODS):
        raise InputError(
            f"regions need the loci of all types ({', '.join(possible_types(model))}) and both "
            "periods (1, 2); ask for all of them or for no regions"
        )
    # Of Hopf points alone no cycles are needed.
    followed = (0,) if types == ("HB",) else periods
    settings = largest_period(settings or Settings(), followed)
    if model.found_sizes is None:
        model = measured_across(model, plane, window)
    lines: list[FanLine] = []
    stops: list[KeyboardInterrupt] = []
    touches = Touches(plane, window)
    touched = any(kind in types for kind in MET)

    def found() -> Iterator[SpecialPoint]:
        for line in _across(model, plane, window, settings, observer):
            lines.append(line)
            if line.interrupted:
                return
            yield from (point for branch in line.branches for point in branch.special)
            yield from touches.beside(line.branches) if touched else ()
        others = follow_isolated(
            model, lines, plane, window, settings, observer, everywhere=bool(touches.of)
        )
        for branch in others if model.forced else ():
            yield from branch.special
            yield from touches.beside([branch]) if touched else ()
        for branch in follow_sticking(model, lines, plane, window, settings, observer):
            yield from found_in_stick(branch)

    points = (
        point
        for point in found_until_interrupted(found(), stops)
        if point.type in types and point.period in periods and _inside(point.model, plane, window)
    )
    # A locus is followed as soon as a response shows it: whoever watches sees it at once.
    remarks: list[str] = []
    loci = follow_found(
        points,
        plane,
        window,
        settings,
        observer,
        types,
        max(periods),
        remarks,
        through_stick=True,
    )
    loci = without_copies(loci, window)
    if not any(line.branches or line.sticking for line in lines):
        raise InputError(
            f"no response exists on any of {len(lines)} lines across the window: {lines[0].failure}"
        )
    stopped = [*(line.interrupted for line in lines), *(locus.interrupted for locus in loci)]
    interrupted = bool(stops) or any(stopped)
    labels = None
    if regions and not interrupted:
        try:
            if observer is not None:
                middle = (sum(window[0]) / 2, sum(window[1]) / 2)
                text = f"between {len(loci)} loci"
                observer(locus_progress("regions", 0, None, middle, text, loci=loci))
            labels = map_regions(model, plane, window, loci, lines, observer, touches.of)
        except KeyboardInterrupt:
            interrupted = True
    others = lines[sum(LINES) :]
    remarks += [line.failure for line in others if line.failure]
    for line in lines:
        remarks += unfinished(line, plane, window, loci)
    missing = tuple(dict.fromkeys(remarks))
    return BifurcationSet(loci, labels, interrupted, missing)


def found_until_interrupted(
    points: Iterator[SpecialPoint], stops: list[KeyboardInterrupt]
) -> Iterator[SpecialPoint]:
    """Yield points as they are found, until whoever watches stops the search; note if so."""
    try:
        yield from points
    except KeyboardInterrupt as stop:
        stops.append(stop)


def _across(
    model: Model,
    plane: tuple[str, str],
    window: Window,
    settings: Settings,
    observer: Observer | None,
) -> Iterator[FanLine]:
    """Follow responses across the window, one after the other."""
    yield from follow_fan(model, plane, window, LINES, settings, observer)
    if not model.forced:
        yield from follow_settled(model, plane, window, settings, observer)


def _inside(model: Model, plane: tuple[str, str], window: Window) -> bool:
    return all(
        low <= model.values[name] <= high for name, (low, high) in zip(plane, window, strict=True)
    )


def possible_types(model: Model) -> tuple[str, ...]:
    """Return the types of loci in a set of a model.

    Only an autonomous one has equilibria, only one whose contacts may stick begins to.

    >>> from slipfold.models import model_named
    >>> possible_types(model_named("lure"))
    ('LP', 'PD', 'NS', 'BP', 'HB')
    >>> possible_types(model_named("sliding"))
    ('LP', 'PD', 'NS', 'BP', 'GRAZE', 'LIFT', 'STICK')
    """
    may_stick = any(contact.limits for contact in contacts_of(model))
    missing = {*(() if may_stick else MET), *(("HB",) if model.forced else ())}
    return tuple(kind for kind in LOCUS_TYPES if kind not in missing)


def check_asked(
    model: Model, types: Sequence[str] | None, periods: Sequence[int]
) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Return the types and periods of a set that is asked for, each once, in their order."""
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
                f"period = {period!r} is neither 1 nor 2; loci of longer periods start from their "
                "special points, see slipfold.locus"
            )
    if not types or not periods:
        raise InputError("no type or no period of loci is given; give e.g. PD and 1")
    kept = tuple(kind for kind in possible if kind in types)
    return kept, tuple(period for period in PERIODS if period in periods)
