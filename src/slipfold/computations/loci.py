"""Bifurcations followed in two parameters, and the regions between them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any, TypeVar

import numpy as np

from slipfold import options
from slipfold.bifurcations.branches.settings import Event, Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.loci.bifurcation_set import find_bifurcation_set
from slipfold.bifurcations.loci.follow import follow_loci
from slipfold.bifurcations.loci.window import Window, measured_across, parse_plane
from slipfold.computations.arguments import (
    checked_events,
    checked_model,
    checked_settings,
    refuse_varied,
    special_point_of,
)
from slipfold.declarations import documented
from slipfold.errors import InputError
from slipfold.models.equilibria import check_followed
from slipfold.models.model import Model
from slipfold.orbits.find import may_slip
from slipfold.progress import Observer, Progress
from slipfold.results.checks.curves import check_loci
from slipfold.results.diagram import Labeled
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.records import provenance
from slipfold.text import place_text

AnyModel = TypeVar("AnyModel", bound=Model)


@documented
def locus(
    special_point: options.LocusStart,
    vary: options.PlaneNames,
    window: options.Window = None,
    *,
    type: options.LocusType = None,
    settings: Settings | None = None,
    events: Sequence[Event] = (),
    on_progress: Observer | None = None,
    switch: options.Switch = True,
) -> LocusDiagram:
    """Follow the locus of a bifurcation in two parameters, and the loci that start on it.

    Or the locus of an extremum (see `slipfold.Event`), as that of the peaks of a resonance over the
    level of the force. Several peaks at one level may lie on several branches, of which isolas are
    found in this way.

    Returns
    -------
    LocusDiagram
        Loci with their special points. One that stops early says why in its `started` or `stopped`.

    Raises
    ------
    InputError
        For a point that has no locus in this plane or is outside the window, an unknown parameter,
        the same one twice, a wrong unit, a value outside its bounds, or an empty window.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> window = {"f": (12.4, 12.6), "Nd": (0, "100mN")}
    >>> doubling, = sf.locus(diagram.special[0], ("f", "Nd"), window, switch=False).loci
    >>> doubling.type, doubling.period, doubling.stopped.kind
    ('PD', 1, 'window')

    >>> from slipfold.models.registry import model_named
    >>> onset, = sf.locus(
    ...     model_named("lure"), ("a", "b"), ((0.9, 1.1), (0.9, 1.1)), type="HB"
    ... ).loci
    >>> onset.kind, bool(abs(onset.values.prod(axis=1) - 1).max() < 1e-12)
    ('equilibrium', True)
    """
    watched = checked_events(events)
    if isinstance(special_point, Model):
        if watched:
            raise InputError(
                "events are located on loci from special points, but a model is given; leave them "
                "out, or give a special point"
            )
        if not switch:
            raise InputError(
                "switch=False is for loci from special points, but a model is given; give a type "
                'of bifurcation instead, e.g. type="PD"'
            )
        return bifurcation_set(
            special_point, vary, window, types=type, regions=False, settings=settings,
            on_progress=on_progress,
        )  # fmt: skip
    if type is not None:
        raise InputError(
            f"type = {type!r} goes with a model, but special points have theirs; leave it out"
        )
    points = _points(special_point)
    model = points[0].model
    plane, spans = parse_plane(model, vary, window)
    base = corner_model(model, plane, spans)
    chosen = checked_settings(settings)
    on_progress = with_position(on_progress, model, plane)
    started = perf_counter()
    remarks: list[str] = []
    loci = follow_loci(
        points, plane, spans, settings=chosen, observer=on_progress, switch=switch,
        remarks=remarks, events=watched,
    )  # fmt: skip
    checked = check_loci(loci, on_progress)
    return LocusDiagram(
        base,
        plane,
        spans,
        loci,
        None,
        chosen,
        provenance(perf_counter() - started),
        interrupted=checked.interrupted,
        missing=tuple(remarks),
        checked=checked,
    )


def _points(given: Any) -> list[SpecialPoint]:
    one = isinstance(given, SpecialPoint | Labeled)
    points = [special_point_of(item) for item in ([given] if one else _several(given))]
    if not points:
        raise InputError("no special point is given; give at least one, e.g. diagram.special[0]")
    return points


def _several(given: Any) -> list[Any]:
    """Return the items of a sequence, or what stands for a sequence of one."""
    return list(given) if isinstance(given, Iterable) and not isinstance(given, str) else [given]


@documented
def bifurcation_set(
    model: Model,
    plane: options.PlaneNames,
    window: options.Window = None,
    *,
    types: options.Types = None,
    periods: options.OrbitPeriods = (1, 2),
    regions: options.Regions = None,
    regimes: options.Regimes = None,
    settings: Settings | None = None,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> LocusDiagram:
    """Find all bifurcations of the responses of period 1 and 2 in a window of two parameters.

    Responses are followed across the window, and from their special points the loci; between the
    loci lie regions, in each of which the same stable responses exist; without `regions` they are
    found where there may be some, else the summary says why not unless `types` or `periods` do.

    Returns
    -------
    LocusDiagram
        The loci with their special points, and the regions if requested.

    Examples
    --------
    >>> import slipfold as sf
    >>> window = {"f": (12.4, 12.6), "Nd": (0, "60mN")}
    >>> result = sf.bifurcation_set(
    ...     sf.SlidingOscillator(), ("f", "Nd"), window, types=["PD"], periods=[1], regions=False
    ... )
    >>> [(locus.type, locus.period) for locus in result.loci]
    [('PD', 1)]
    """
    model = checked_model(model)
    names, spans = parse_plane(model, plane, window)
    refuse_varied(names, parameters, "the window")
    kinds, chosen_periods = None if types is None else _types(types), _periods(periods)
    base = corner_model(model, names, spans, parameters)
    chosen = checked_settings(settings)
    grid = _grid(regimes, regions)
    regions = True if regions is None and grid is not None else regions
    on_progress = with_position(on_progress, model, names)
    started = perf_counter()
    base = measured_across(base, names, spans)
    result = find_bifurcation_set(
        base,
        names,
        spans,
        types=kinds,
        periods=chosen_periods,
        regions=regions,
        settings=chosen,
        observer=on_progress,
    )
    labels, stopped = result.regions, result.interrupted
    if labels is not None and grid is not None:
        from slipfold.long_term.regimes import resolve_regions

        labels, stopped = resolve_regions(base, names, spans, labels, grid, on_progress)
    checked = check_loci(result.loci, on_progress)
    return LocusDiagram(
        base,
        names,
        spans,
        result.loci,
        labels,
        chosen,
        provenance(perf_counter() - started),
        interrupted=stopped or checked.interrupted,
        missing=result.missing,
        checked=checked,
    )


def _types(given: Any) -> tuple[Any, ...]:
    return tuple(item.upper() if isinstance(item, str) else item for item in _several(given))


def _grid(given: Any, regions: bool | None) -> tuple[int, int] | None:
    if given is None:
        return None
    if regions is False:
        raise InputError(
            f"regimes = {given!r} needs regions; give regions=True (--regions) as well"
        )
    return given


def _periods(given: Any) -> tuple[Any, ...]:
    items = tuple(_several(given))
    for item in items:
        if isinstance(item, bool | np.bool_):
            raise InputError(f"period = {item} is not a number of forcing periods; give 1 or 2")
    return items


def corner_model(
    model: AnyModel,
    vary: tuple[str, str],
    window: Window,
    changes: Mapping[str, float | str] | None = None,
) -> AnyModel:
    """Return a model at a corner of the window, the lowest that it can have.

    Parameters of a model may bound one another. Part of a window may be outside these bounds, where
    a locus then ends at a limit of the model, but not a full side of it.
    """
    other = dict(changes or {})
    sides = [[(value, end) for end in window[1]] for value in window[0]]
    sides += [[(end, value) for end in window[0]] for value in window[1]]
    corners = [
        _first_allowed(model, [{**other, vary[0]: a, vary[1]: b} for a, b in side])
        for side in sides
    ]
    return corners[0]


def _first_allowed(model: AnyModel, candidates: Sequence[dict[str, float | str]]) -> AnyModel:
    refused: InputError | None = None
    for candidate in candidates:
        try:
            changed = model.replace(**candidate)
            # Where a moving surface stands still solutions lead to orbits that stick.
            if not changed.forced or may_slip(changed):
                check_followed(changed)
            return changed
        except InputError as error:
            refused = refused or error
    assert refused is not None
    raise refused


def with_position(
    on_progress: Observer | None, model: Model, plane: tuple[str, str]
) -> Observer | None:
    """Return what reports progress with the values of the two parameters in its text."""
    if on_progress is None:
        return None

    def report(progress: Progress) -> None:
        position = place_text(model, plane, progress.values["place"])
        on_progress(replace(progress, text=f"{progress.text}  {position}"))

    return report
