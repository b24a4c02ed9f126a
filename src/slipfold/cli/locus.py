"""``slipfold locus``: bifurcations followed in two parameters, and the regions between them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from slipfold.cli.commands import FRICTION, SET, Reader, argument
from slipfold.cli.reading import (
    find_model,
    parse_assignments,
    parse_whole,
    parse_window,
    refuse_varied,
)
from slipfold.errors import InputError
from slipfold.options import Option, Regimes, Regions, Types

if TYPE_CHECKING:
    from slipfold.branches.settings import Settings
    from slipfold.branches.special_point import SpecialPoint
    from slipfold.progress import Observer
    from slipfold.results.diagram import Diagram
    from slipfold.results.locus_diagram import LocusDiagram

GIVEN = Reader(
    (
        argument(
            "MODEL|RESPONSE.nc",
            "Name of a built-in model (see slipfold models), or a case file, e.g. case.toml: all "
            "bifurcations in the window. Or a file that slipfold response --out wrote: those that "
            "pass its special points.",
        ),
        SET,
        FRICTION,
    ),
    lambda texts, _: {"given": texts},
)
"""A model, or a saved response."""

Window = Annotated[
    list[str],
    Option(
        "One of the two parameters and its range, e.g. f=11.5:13.5Hz; give it twice.",
        "spans",
        "NAME=FIRST:LAST",
        flags=("--vary",),
    ),
]
Periods = Annotated[
    list[int] | None,
    Option(
        "Period of the orbits in forcing periods; both by default. With RESPONSE.nc, any period of "
        "its points to start from; all by default.",
        "wholes",
        "1|2",
        flags=("--period",),
    ),
]
Labels = Annotated[
    list[str] | None,
    Option(
        "With RESPONSE.nc, its special point to start from, by its number under LAB in the printed "
        "table; all by default.",
        "texts",
        "LAB",
        flags=("--label",),
    ),
]
Only = Annotated[
    bool,
    Option(
        "With RESPONSE.nc, follow the loci through its special points alone, and none that start "
        "at points of codimension two on them.",
        "flag",
    ),
]


def locus(
    given: dict[str, Any],
    window: Window,
    *,
    label: Labels = None,
    only: Only = False,
    type_: Types = None,
    period: Periods = None,
    regions: Regions = False,
    regimes: Regimes = None,
    settings: Settings,
    on_progress: Observer,
) -> LocusDiagram:
    """Follow the loci in a window of a model, or those from the points of a saved response."""
    model = given["model"]
    types = [text.upper() for text in type_ or ()] or None
    if model.lower().endswith(".nc"):
        from slipfold.computations.loci import locus as follow

        changes = [f"--set {item}" for item in given["set_"] or ()]
        changes += [] if given["friction"] is None else [f"--friction {given['friction']}"]
        _refuse(model, changes, regions or regimes is not None, bool(label and (types or period)))
        response = load_response(model)
        plane, spans = parse_window(window, response.model)
        if label:
            points = labeled_points(response, model, label)
        else:
            points = matching_points(response, model, (plane, spans), types, period)
        return follow(
            points, plane, spans, switch=not only, settings=settings, on_progress=on_progress
        )
    from slipfold.computations.loci import bifurcation_set
    from slipfold.loci.bifurcation_set import PERIODS

    _refuse_of_model(model, label, only, regimes if not regions else None)
    values = parse_assignments(given["set_"])
    chosen = find_model(model, values, given["friction"])
    plane, spans = parse_window(window, chosen, "a bifurcation set")
    refuse_varied(values, plane)
    return bifurcation_set(
        chosen,
        plane,
        spans,
        types=types,
        periods=period or PERIODS,
        regions=regions,
        regimes=regimes,
        settings=settings,
        on_progress=on_progress,
    )


def _refuse_of_model(
    model: str, label: Sequence[str] | None, only: bool, regimes: tuple[int, int] | None
) -> None:
    """Refuse what does not go with a model."""
    if label:
        raise InputError(
            f"--label {label[0]} is for a saved response, but {model} is a model; give a file "
            "that slipfold response --out wrote, or leave out --label"
        )
    if only:
        raise InputError(
            f"--only is for a saved response, but {model} is a model, whose loci are searched; "
            "give a file that slipfold response --out wrote, or --type"
        )
    if regimes is not None:
        raise InputError(f"--regimes {regimes[0]}x{regimes[1]} needs --regions; give both")


def _refuse(path: str, given: Sequence[str], regions: bool, both: bool) -> None:
    """Refuse what does not go with a saved response."""
    if given:
        raise InputError(
            f"{given[0]} is for a model, but the parameters of {path} are those it was "
            f"computed with; leave out {given[0].split()[0]}"
        )
    if regions:
        raise InputError(
            f"--regions needs all loci in the window, but only those of {path} are followed; give "
            "a model, or leave out --regions"
        )
    if both:
        raise InputError(
            "--label says already which special points are meant; leave out --type and --period"
        )


def load_response(path: str) -> Diagram:
    """Read a saved response."""
    from slipfold.results.diagram import Diagram
    from slipfold.results.result import load

    result = load(path)
    if not isinstance(result, Diagram):
        raise InputError(
            f"{path} holds a {type(result).__name__}, but loci start from the special points of a "
            "response; give a file that slipfold response --out wrote"
        )
    return result


def labeled_points(diagram: Diagram, path: str, labels: Sequence[str]) -> list[SpecialPoint]:
    """Return the special points with these labels."""
    known = _bifurcations(diagram)
    chosen = []
    for text in labels:
        label = parse_whole(text, "--label")
        if label not in known:
            raise InputError(
                f"--label {text} is no bifurcation with a locus; {_listed(path, known)}"
            )
        chosen.append(known[label])
    return chosen


def matching_points(
    diagram: Diagram,
    path: str,
    window: tuple[tuple[str, str], tuple[tuple[float, float], tuple[float, float]]],
    types: Collection[str] | None,
    periods: Collection[int] | None,
) -> list[SpecialPoint]:
    """Return the special points inside the window that are of these types and periods."""
    from slipfold.orbits.bifurcation_types import LOCUS_TYPES

    for kind in types or ():
        if kind not in LOCUS_TYPES:
            raise InputError(f"there are no loci of type {kind!r}; give {', '.join(LOCUS_TYPES)}")
    known = _bifurcations(diagram)
    matching = [
        point
        for point in known.values()
        if (types is None or point.type in types) and (periods is None or point.period in periods)
    ]
    if not matching:
        listed = _listed(path, known)
        raise InputError(f"no bifurcation of that type and period is in {path}; {listed}")
    inside = [
        point
        for point in matching
        if all(
            min(ends) <= point.model.values[name] <= max(ends)
            for name, ends in zip(*window, strict=True)
        )
    ]
    if not inside:
        values = " and ".join(
            f"{name} = {matching[0].model.values[name]:.6g}" for name in window[0]
        )
        raise InputError(
            f"no special point of {path} is inside the window; the first is at {values}, give a "
            "window that holds it"
        )
    return inside


def first_point(diagram: Diagram, kind: str | None, period: int | None) -> SpecialPoint:
    """Return the first special point on the way that is of this type and period."""
    points = list(_bifurcations(diagram).values())
    matching = [
        point for point in points if kind in (None, point.type) and period in (None, point.period)
    ]
    first, last = diagram.span
    if not points:
        raise InputError(
            f"no special point lies on the way from {diagram.vary} = {first:g} to {last:g}; "
            f"give a longer span than --vary {diagram.vary}={first:g}:{last:g}"
        )
    if not matching:
        known = ", ".join(f"{point.type} of period {point.period}" for point in points)
        raise InputError(
            f"the response has no such special point on the way, but {known}; "
            "give another type, period or span"
        )
    return min(matching, key=lambda point: abs(point.value - first))


def _bifurcations(diagram: Diagram) -> dict[int, SpecialPoint]:
    from slipfold.orbits.bifurcation_types import LOCUS_TYPES
    from slipfold.results.diagram import points_by_label

    points = points_by_label(diagram)
    return {label: point for label, point in points.items() if point.type in LOCUS_TYPES}


def _listed(path: str, known: dict[int, SpecialPoint]) -> str:
    if not known:
        return f"{path} has none"
    labels = ", ".join(
        f"{label} ({point.type} of period {point.period})" for label, point in known.items()
    )
    return f"the labels of those in {path} are: {labels}"
