"""``slipfold uncertainty`` and ``design``: thresholds of uncertain and of chosen parameters."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from slipfold.cli.locus import first_point
from slipfold.cli.reading import GivenModel, OutputFiles, command, parse_whole, varied
from slipfold.errors import InputError
from slipfold.options import (
    Above,
    Choose,
    Correlation,
    DesignState,
    Distributions,
    Indices,
    Keep,
    Load,
    Loads,
    Option,
    Outside,
    Samples,
    Seed,
)
from slipfold.progress import Observer

if TYPE_CHECKING:
    from slipfold.models.model import Model
    from slipfold.results.diagram import Diagram
    from slipfold.results.result import Result

AnyResult = TypeVar("AnyResult", bound="Result")

Varied = Annotated[
    tuple[str, tuple[float, float]],
    varied("Parameter of which the threshold is a value, and where it is searched."),
]
Type = Annotated[
    str | None,
    Option("Type of the special point; by default the first.", metavar="TYPE", flags=("--type",)),
]
Period = Annotated[int | None, Option("Period of its orbit in forcing periods.", "whole", "K")]


@command
def uncertainty(
    model: GivenModel,
    varied: Varied,
    outputs: OutputFiles,
    scatter: Distributions,
    correlation: Correlation = None,
    type_: Type = None,
    period: Period = None,
    samples: Samples = 1024,
    seed: Seed = 0,
    quiet: Loads = (),
    indices: Indices = False,
) -> int:
    """Compute the distribution of a threshold, by its gradients and by samples.

    Exit status: 0 done, 2 bad input, 130 interrupted; what was known by then is kept.
    """
    from slipfold.computations.thresholds import uncertainty as compute

    given: Any = {"correlation": correlation, "samples": samples, "seed": seed}
    given |= {"loads": quiet or (), "indices": indices}

    def find(diagram: Diagram, on_progress: Observer) -> Any:
        point = first_point(diagram, type_, period)
        return compute(point, scatter, **given, on_progress=on_progress)

    return outputs.status_of(partial(_on_response, model, varied, find))


@command
def design(
    model: GivenModel,
    varied: Varied,
    outputs: OutputFiles,
    choose: Choose,
    load: Load,
    above: Above = None,
    outside: Outside = None,
    keep: Keep = None,
    state: DesignState = None,
    type_: Type = None,
    period: Period = None,
) -> int:
    """Choose parameters for a threshold where it is wanted, at the lowest vibration.

    Exit status: 0 done, 2 bad input, 3 nothing found, 130 interrupted; what was known is kept.
    """
    from slipfold.computations.thresholds import design as compute

    given: Any = {"load": load, "above": above or None, "state": state}
    given["outside"] = None if outside is None else _pair(str(outside))
    others = {each: (*_type_and_period(each), least) for each, least in dict(keep or {}).items()}

    def find(diagram: Diagram, on_progress: Observer) -> Any:
        kept: Any = {
            each: (first_point(diagram, kind, periods), least)
            for each, (kind, periods, least) in others.items()
        }
        point = first_point(diagram, type_, period)
        return compute(point, choose, **given, keep=kept, on_progress=on_progress)

    found = outputs.of(partial(_on_response, model, varied, find))
    return outputs.status(found.interrupted, bool(found.reasons.any()))


def _on_response(
    model: Model,
    varied: tuple[str, tuple[float, float]],
    find: Callable[[Diagram, Observer], AnyResult],
    on_progress: Observer,
) -> AnyResult:
    """Follow a response, then compute from its special points."""
    from slipfold.computations.response import response

    diagram = response(model, *varied, on_progress=on_progress)
    if diagram.interrupted:
        raise KeyboardInterrupt
    return find(diagram, on_progress)


def _pair(text: str) -> tuple[str, str]:
    least, colon, most = text.partition(":")
    if not colon:
        raise InputError(f"--outside={text} has no two ends; give LEAST:LARGEST")
    return least, most


def _type_and_period(text: str) -> tuple[str, int]:
    kind, colon, period = text.partition(":")
    if not colon:
        raise InputError(f"--keep {text} has no period; give TYPE:PERIOD=VALUE, e.g. PD:1=40mN")
    return kind, parse_whole(period, f"--keep {kind}:")
