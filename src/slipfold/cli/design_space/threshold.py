"""The threshold that a command is about: its options, and the response on which it lies."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import typer

from slipfold.cli.progress import done_text

if TYPE_CHECKING:
    from slipfold.branches.progress import Progress
    from slipfold.computations.design import DesignProgress
    from slipfold.design_space.sampling import SampleProgress
    from slipfold.models.model import Model
    from slipfold.results.diagram import Diagram

    ThresholdProgress = Progress | SampleProgress | DesignProgress

__all__ = ["Period", "Type", "Vary", "threshold_response", "threshold_text"]

Vary = Annotated[
    list[str],
    typer.Option(
        metavar="NAME=FIRST:LAST",
        help="Parameter of which the threshold is a value, and where it is looked for.",
    ),
]
Type = Annotated[
    str | None,
    typer.Option("--type", metavar="TYPE", help="Type of the special point; by default the first."),
]
Period = Annotated[
    str | None,
    typer.Option("--period", metavar="K", help="Period of its orbit in forcing periods."),
]


def threshold_response(
    model: Model, vary: str, span: tuple[float, float], observer: Callable[[Progress], None]
) -> Diagram:
    """Return the response on which a threshold is looked for; interrupted, there is none."""
    from slipfold.computations.response import response

    diagram = response(model, vary, span, observer=observer)
    if diagram.interrupted:
        raise KeyboardInterrupt
    return diagram


def threshold_text(stage: str) -> Callable[[ThresholdProgress], str]:
    """Return what puts into words the response, then the stage that comes after it."""
    from slipfold.branches.progress import Progress

    def text(progress: ThresholdProgress) -> str:
        if isinstance(progress, Progress):
            return "response"
        return done_text(stage, progress.done, progress.total)

    return text
