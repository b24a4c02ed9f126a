"""``slipfold uncertainty`` and ``design``: thresholds of uncertain and of chosen parameters."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any

from slipfold.cli.locus import first_point
from slipfold.cli.reading import parse_whole
from slipfold.computations import thresholds
from slipfold.errors import InputError
from slipfold.options import Option, resolved

if TYPE_CHECKING:
    from slipfold.models.model import Model
    from slipfold.progress import Observer
    from slipfold.results.diagram import Diagram

Type = Annotated[
    str | None,
    Option("Type of the special point; by default the first.", metavar="TYPE", flags=("--type",)),
]
Period = Annotated[int | None, Option("Period of its orbit in forcing periods.", "whole", "K")]


def of_response(compute: Callable[..., Any]) -> Callable[..., Any]:
    """Return a computation from a special point as one that follows the response to it first."""

    def run(
        model: Model,
        vary: str,
        span: tuple[float, float],
        *,
        type_: Type = None,
        period: Period = None,
        on_progress: Observer,
        **options: Any,
    ) -> Any:
        from slipfold.computations.response import response

        if options.get("keep"):
            options["keep"] = {each: _split(each, bound) for each, bound in options["keep"].items()}
        diagram = response(model, vary, span, on_progress=on_progress)
        if diagram.interrupted:
            raise KeyboardInterrupt
        if options.get("keep"):
            options["keep"] = _stored(diagram, options["keep"])
        point = first_point(diagram, type_, period)
        return compute(point, **options, on_progress=on_progress)

    own = list(resolved(run).parameters.values())[:-2]
    given = list(resolved(compute).parameters.values())[1:]
    parameters = [item.replace(kind=inspect.Parameter.KEYWORD_ONLY) for item in (*own, *given)]
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return run


uncertainty = of_response(thresholds.uncertainty)
design = of_response(thresholds.design)


def _split(text: str, bound: str) -> tuple[str, int, str]:
    kind, colon, period = text.partition(":")
    if not colon:
        raise InputError(f"--keep {text} has no period; give TYPE:PERIOD=VALUE, e.g. PD:1=40mN")
    return kind, parse_whole(period, f"--keep {kind}:"), bound


def _stored(diagram: Diagram, keep: Mapping[str, tuple[str, int, str]]) -> dict[str, Any]:
    """Return the special points of further thresholds, with their lower bounds."""
    return {
        each: (first_point(diagram, kind, period), bound)
        for each, (kind, period, bound) in keep.items()
    }
