"""``slipfold locus``: bifurcations followed in two parameters, and the regions between them."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Annotated, Any

from slipfold.declarations import Option
from slipfold.errors import InputError
from slipfold.interface.cli.commands import (
    FRICTION,
    SET,
    Reader,
    Values,
    argument,
    read_varied,
    vary_option,
)
from slipfold.interface.cli.reading import load_result, make_model, parse_assignments, parse_event
from slipfold.options import Regimes, Regions, Types

if TYPE_CHECKING:
    from slipfold.bifurcations.branches.settings import Settings
    from slipfold.bifurcations.branches.special_point import SpecialPoint
    from slipfold.progress import Observer
    from slipfold.results.diagram import Diagram
    from slipfold.results.locus_diagram import LocusDiagram

GIVEN = Reader(
    (
        argument(
            "MODEL|RESPONSE.nc",
            "Name of a built-in model (see slipfold models), or a case file, e.g. case.toml: all "
            "bifurcations in the window. Or a file that slipfold response --out wrote: loci "
            "through its special points.",
        ),
        SET,
        FRICTION,
        vary_option("One of the two parameters and its range, e.g. f=11.5:13.5Hz; give it twice."),
    ),
    lambda texts, _: {"given": texts},
)
"""A model, or a saved response, and the window."""

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
    list[int] | None,
    Option(
        "With RESPONSE.nc, its special point to start from, by its number under LAB in the printed "
        "table; all by default.",
        "wholes",
        "LAB",
        flags=("--label",),
    ),
]
LocusEvents = Annotated[
    list[str] | None,
    Option(
        "With RESPONSE.nc, locate where an output of the orbits of a locus takes a value, or one "
        'of the two parameters: F=0.03, "max(x)=0.3".',
        "texts",
        "[MEASURE](NAME)=VALUE",
        flags=("--event",),
    ),
]
Only = Annotated[
    bool,
    Option(
        "With RESPONSE.nc, follow the loci through its special points alone, and none that start "
        "at points of codimension two on them."
    ),
]


def locus(
    given: Values,
    *,
    label: Labels = None,
    event: LocusEvents = None,
    only: Only = False,
    type_: Types = None,
    period: Periods = None,
    regions: Regions = False,
    regimes: Regimes = None,
    settings: Settings,
    on_progress: Observer,
) -> LocusDiagram:
    """Follow the loci in a window of a model, or those from the points of a saved response."""
    from slipfold.bifurcations.loci.isolated import PERIODS
    from slipfold.bifurcations.loci.window import parse_plane
    from slipfold.computations.loci import bifurcation_set
    from slipfold.computations.loci import locus as follow

    name = given["model"]
    saved = name.lower().endswith(".nc")
    ours = {"--label": label, "--event": event, "--only": only}
    theirs = {"--set": given["set_"], "--friction": given["friction"]}
    theirs |= {"--regions": regions, "--regimes": regimes}
    kinds = "a saved response", "a model"
    for flag, value in (theirs if saved else ours).items():
        if value:
            needed, own = kinds[saved], kinds[not saved]
            raise InputError(f"{flag} is for {needed}, but {name} is {own}; leave it out")
    window = read_varied(given, 2)
    first, second = window
    common: Any = {"settings": settings, "on_progress": on_progress}
    types = [text.upper() for text in type_ or ()] or None
    if not saved:
        model = make_model(name, parse_assignments(given["set_"]), given["friction"])
        common |= {"periods": period or PERIODS, "regions": regions, "regimes": regimes}
        return bifurcation_set(model, (first, second), window, types=types, **common)
    if label and (types or period):
        raise InputError("--label says which special points are meant; leave out --type, --period")
    response = load_response(name)
    points = select_points(response, name, types, period, label)
    names, spans = parse_plane(response.model, (first, second), window)
    inside = [
        point
        for point in points
        if label
        or all(
            low <= point.model.values[name] <= high
            for name, (low, high) in zip(names, spans, strict=True)
        )
    ]
    events = [parse_event(text, response.model, names) for text in event or ()]
    return follow(inside or points, names, spans, switch=not only, events=events, **common)


def load_response(path: str) -> Diagram:
    """Read a saved response."""
    from slipfold.results.diagram import Diagram

    advice = (
        "but loci start from the special points of a response; give a file that slipfold response "
        "--out wrote"
    )
    return load_result(path, Diagram, advice)


def select_points(
    diagram: Diagram,
    where: str,
    types: Collection[str] | None = None,
    periods: Collection[int] | None = None,
    labels: Collection[int] | None = None,
) -> list[SpecialPoint]:
    """Return the special points with loci that are requested, in the order of their labels."""
    from slipfold.bifurcations.loci.locus import locus_title
    from slipfold.orbits.bifurcation_types import FOLLOWED_TYPES
    from slipfold.results.diagram import points_by_label

    known = {
        label: point
        for label, point in points_by_label(diagram).items()
        if point.type in FOLLOWED_TYPES
    }
    requested = {"label": labels, "type": types, "period": periods}
    chosen = [
        point
        for label, point in known.items()
        if all(
            choice is None or value in choice
            for choice, value in zip(
                requested.values(), (label, point.type, point.period), strict=True
            )
        )
    ]
    if not chosen or not known.keys() >= set(labels or ()):
        given = ", ".join(
            f"{name} {' or '.join(map(str, choice))}"
            for name, choice in requested.items()
            if choice
        )
        branch_of = {point: branch for branch, point in diagram.special}
        titles = (
            locus_title(point.type, point.period, branch_of[point].kind, diagram.model.forced)
            for point in known.values()
        )
        listed = (f"{label} ({title})" for label, title in zip(known, titles, strict=True))
        raise InputError(
            f"{where} has no special point with a locus{' of ' if given else ''}{given}; "
            + (f"give one of {', '.join(listed)}" if known else "give another model or span")
        )
    return chosen
