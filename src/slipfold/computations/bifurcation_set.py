"""All bifurcations of a model in a window of two parameters, in one call."""

from __future__ import annotations

from collections.abc import Iterable
from time import perf_counter
from typing import Any

import numpy as np

from slipfold.branches.settings import Settings
from slipfold.checks.curves import check_loci
from slipfold.computations.given import (
    checked_count,
    checked_model,
    checked_settings,
    refuse_varied,
)
from slipfold.computations.plane import GivenWindow, corner_model, parse_plane, with_place
from slipfold.errors import InputError
from slipfold.loci.bifurcation_set import find_bifurcation_set
from slipfold.loci.window import measured_across
from slipfold.long_term.region_motions import resolve_regions
from slipfold.models.followed import check_followed
from slipfold.models.model import Model
from slipfold.progress import Observer
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.records import provenance


def bifurcation_set(
    model: Model,
    plane: tuple[str, str],
    window: GivenWindow | None = None,
    *,
    types: str | Iterable[str] | None = None,
    periods: int | Iterable[int] = (1, 2),
    regions: bool = True,
    regimes: tuple[int, int] | None = None,
    settings: Settings | None = None,
    observer: Observer | None = None,
    **parameters: float | str,
) -> LocusDiagram:
    """Find all bifurcations of the responses of period 1 and 2 in a window of two parameters.

    Responses are followed across the window, and from their special points the loci; between the
    loci lie regions, in each of which the same stable responses exist.

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``.
    plane
        Names of the two parameters.
    window
        Two values of each, always to be given: a pair of pairs in the order of `plane`, or pairs
        by name; numbers in SI units, or text with a unit such as ``"20deg"``.
    types
        Types of bifurcation to follow: of ``"LP"``, ``"PD"``, ``"NS"``, ``"BP"``, ``"HB"`` of an
        autonomous model, and ``"GRAZE"``, ``"STICK"`` and ``"LIFT"``, where responses begin to
        touch, to stick at a turn or to lift off, of one whose contacts may; all if None.
    periods
        Periods of the orbits whose bifurcations are followed: 1, 2 or both, in forcing periods.
    regions
        Whether to find the regions, which takes a forced model, all types and both periods, and to
        check them by simulations.
    regimes
        Numbers of places along either parameter, e.g. ``(60, 50)``, at which motions from the
        model's start say what happens in regions without a stable response of period 1 or 2, and
        in those that are not known: higher periods, tori, chaos, stick-slip, as
        `slipfold.regimes` does; a thousandth of a second to a second each. None: not at all.
    settings
        Options of continuation; the defaults of `slipfold.Settings` if None.
    observer
        Called as the computation goes on, with a `slipfold.Progress`. If it raises
        `KeyboardInterrupt`, what is finished is returned.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    LocusDiagram
        The loci with their special points, and the regions if they were asked for.

    Raises
    ------
    InputError
        For an unknown parameter, type or period, the same parameter twice, a wrong unit, a value
        outside its bounds, an empty window, or `regimes` without `regions`.

    Examples
    --------
    >>> import slipfold as sf
    >>> window = {"f": (12.4, 12.6), "Nd": (0, "60mN")}
    >>> found = sf.bifurcation_set(
    ...     sf.SlidingOscillator(), ("f", "Nd"), window, types=["PD"], periods=[1], regions=False
    ... )
    >>> [(locus.type, locus.period) for locus in found.loci]
    [('PD', 1)]
    """
    model = checked_model(model)
    names, spans = parse_plane(model, plane, window)
    refuse_varied(names, parameters, "the window")
    kinds, wanted = None if types is None else _types(types), _periods(periods)
    base = corner_model(model, names, spans, parameters)
    if regions:  # their labels are those of orbits in slip
        check_followed(base)
    chosen = checked_settings(settings)
    grid = _grid(regimes, regions)
    observer = with_place(observer, model, names)
    started = perf_counter()
    base = measured_across(base, names, spans)
    found = find_bifurcation_set(
        base,
        names,
        spans,
        types=kinds,
        periods=wanted,
        regions=regions,
        settings=chosen,
        observer=observer,
    )
    labels, stopped = found.regions, found.interrupted
    if labels is not None and grid is not None:
        labels, stopped = resolve_regions(base, names, spans, labels, grid, observer)
    checked = check_loci(found.loci, observer)
    return LocusDiagram(
        base,
        names,
        spans,
        found.loci,
        labels,
        chosen,
        provenance(perf_counter() - started),
        interrupted=stopped or checked.interrupted,
        missing=found.missing,
        checked=checked,
    )


def _types(given: Any) -> tuple[Any, ...]:
    items = (given,) if isinstance(given, str) or not isinstance(given, Iterable) else given
    return tuple(item.upper() if isinstance(item, str) else item for item in items)


def _grid(given: Any, regions: bool) -> tuple[int, int] | None:
    if given is None:
        return None
    if not regions:
        raise InputError(f"regimes = {given!r} are told in regions; ask for these too")
    try:
        first, second = given
    except (TypeError, ValueError):
        raise InputError(f"regimes = {given!r} are not two numbers; give e.g. (60, 50)") from None
    return checked_count(first, "regimes"), checked_count(second, "regimes")


def _periods(given: Any) -> tuple[Any, ...]:
    items = tuple(given) if isinstance(given, Iterable) and not isinstance(given, str) else (given,)
    for item in items:
        if isinstance(item, bool | np.bool_):
            raise InputError(f"period = {item} is not a number of forcing periods; give 1 or 2")
    return items
