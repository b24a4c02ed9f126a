"""The special points of a saved response that a command starts from."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from slipfold.cli.parsing import parse_whole
from slipfold.errors import InputError

if TYPE_CHECKING:
    from slipfold.branches.special_point import SpecialPoint
    from slipfold.results.diagram import Diagram


def load_response(path: str) -> Diagram:
    """Read a saved response."""
    from slipfold.results.diagram import Diagram
    from slipfold.results.result import load

    found = load(path)
    if not isinstance(found, Diagram):
        raise InputError(
            f"{path} holds a {type(found).__name__}, but loci start from the special points of a "
            "response; give a file that slipfold response --out wrote"
        )
    return found


def labelled_points(diagram: Diagram, path: str, labels: Sequence[str]) -> list[SpecialPoint]:
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
    from slipfold.branches.special_point import LOCUS_TYPES

    for kind in types or ():
        if kind not in LOCUS_TYPES:
            raise InputError(f"there are no loci of type {kind!r}; give {', '.join(LOCUS_TYPES)}")
    known = _bifurcations(diagram)
    wanted = [
        point
        for point in known.values()
        if (types is None or point.type in types) and (periods is None or point.period in periods)
    ]
    if not wanted:
        listed = _listed(path, known)
        raise InputError(f"no bifurcation of that type and period is in {path}; {listed}")
    inside = [
        point
        for point in wanted
        if all(
            min(ends) <= point.model.values[name] <= max(ends)
            for name, ends in zip(*window, strict=True)
        )
    ]
    if not inside:
        places = " and ".join(f"{name} = {wanted[0].model.values[name]:.6g}" for name in window[0])
        raise InputError(
            f"no special point of {path} is inside the window; the first is at {places}, give a "
            "window that holds it"
        )
    return inside


def first_point(diagram: Diagram, kind: str | None, period: int | None) -> SpecialPoint:
    """Return the first special point on the way that is of this type and period."""
    points = list(_bifurcations(diagram).values())
    wanted = [
        point for point in points if kind in (None, point.type) and period in (None, point.period)
    ]
    begin, end = diagram.span
    if not points:
        raise InputError(
            f"no special point lies on the way from {diagram.vary} = {begin:g} to {end:g}; "
            f"give a longer span than --vary {diagram.vary}={begin:g}:{end:g}"
        )
    if not wanted:
        known = ", ".join(f"{point.type} of period {point.period}" for point in points)
        raise InputError(
            f"the response has no such special point on the way, but {known}; "
            "give another type, period or span"
        )
    return min(wanted, key=lambda point: abs(point.value - begin))


def _bifurcations(diagram: Diagram) -> dict[int, SpecialPoint]:
    from slipfold.branches.special_point import LOCUS_TYPES
    from slipfold.results.diagram import points_by_label

    points = points_by_label(diagram.branches)
    return {label: point for label, point in points.items() if point.type in LOCUS_TYPES}


def _listed(path: str, known: dict[int, SpecialPoint]) -> str:
    if not known:
        return f"{path} has none"
    labels = ", ".join(
        f"{label} ({point.type} of period {point.period})" for label, point in known.items()
    )
    return f"the labels of those in {path} are: {labels}"
