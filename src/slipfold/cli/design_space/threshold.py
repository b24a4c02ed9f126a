"""What starts from a threshold: its options, and the response on which it lies."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from slipfold.cli.carry_out import carry_out
from slipfold.cli.outputs import Outputs

if TYPE_CHECKING:
    from slipfold.models.model import Model
    from slipfold.results.diagram import Diagram
    from slipfold.results.result import Result

Found = TypeVar("Found", bound="Result")

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


def carry_out_on_response(
    of: tuple[Model, str, tuple[float, float]],
    compute: Callable[[Diagram, Callable[[Any], None]], Found],
    outputs: Outputs,
) -> Found:
    """Follow a response, then carry out what starts from it; interrupted before, there is none."""
    from slipfold.computations.response import response

    def find(observer: Callable[[Any], None]) -> Found:
        diagram = response(*of, observer=observer)
        if diagram.interrupted:
            raise KeyboardInterrupt
        return compute(diagram, observer)

    return carry_out(find, outputs)
