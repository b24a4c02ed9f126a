"""What ``slipfold uncertainty`` and ``design`` read: special points of a response to follow."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from slipfold.declarations import Option
from slipfold.errors import InputError
from slipfold.interface.cli.commands import (
    FRICTION,
    MODEL,
    SET,
    VARY,
    Reader,
    Values,
    declaration,
    option,
    optional,
    read_model,
    read_span,
)
from slipfold.interface.cli.locus import select_points
from slipfold.interface.cli.reading import parse_assignments, parse_whole
from slipfold.options import Keep

if TYPE_CHECKING:
    from slipfold.bifurcations.branches.special_point import SpecialPoint
    from slipfold.progress import Observer

TYPE, PERIOD = optional(
    type=Option(
        "Type of the special point, of several the first along the branches; by default any.",
        metavar="TYPE",
    ),
    period=Option("Period of its orbit in forcing periods.", "whole", "K"),
)


def _read_point(texts: Values, values: Values) -> Values:
    model, span = read_model(texts, values), read_span(texts, values)
    if texts.get("distributions"):  # refused before the response is followed
        from slipfold.computations.thresholds import checked_distributions

        given = parse_assignments(texts["distributions"], "--distribution")
        checked_distributions(model["model"], span["vary"], given)
    requested = {
        "point": (texts["type"], texts["period"] and parse_whole(texts["period"], "--period"))
    }
    bounds = {}
    for name, bound in parse_assignments(
        texts.get("keep"), "--keep", "TYPE:PERIOD=VALUE", "PD:1=40mN"
    ).items():
        kind, colon, period = name.partition(":")
        if not colon:
            raise InputError(f"--keep {name} has no period; give TYPE:PERIOD=VALUE, e.g. PD:1=40mN")
        requested[name], bounds[name] = (kind, parse_whole(period, f"--keep {kind}:")), bound
    return {"before": partial(_points, {**model, **span}, requested, bounds)}


def _points(
    response_of: Values, requested: Values, bounds: Values, on_progress: Observer
) -> dict[str, Any]:
    """Follow the response; return its special points as arguments of the computation."""
    from slipfold.computations.response import response

    diagram = response(**response_of, on_progress=on_progress)
    if diagram.interrupted:
        raise KeyboardInterrupt

    def first(type_: str | None, period: int | None) -> SpecialPoint:
        types, periods = type_ and [type_.upper()], [period] if period else None
        return select_points(diagram, "the response", types, periods)[0]

    points = {name: first(*each) for name, each in requested.items()}
    kept = {name: (points[name], bound) for name, bound in bounds.items()}
    return {"point": points["point"]} | ({"keep": kept} if kept else {})


POINT = {"point": Reader((MODEL, SET, FRICTION, VARY, TYPE, PERIOD), _read_point)}
KEPT = {
    "point": Reader(
        (*POINT["point"].options, option("keep", declaration(Keep), None)), _read_point
    ),
    "keep": Reader((), lambda texts, values: {}),  # read with the point
}
