"""``slipfold plot``: a figure of a saved result."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Annotated, Any

import typer

from slipfold.cli.status import note
from slipfold.errors import InputError

__all__ = ["plot"]

FORMATS = ("png", "pdf", "svg")

MEASURES = ("max", "min", "peak_to_peak", "modulus")

KINDS = ("timeseries", "spectrum", "phase")

Result = Annotated[str, typer.Argument(metavar="RESULT.nc", help="A file written by --out.")]
Output = Annotated[str, typer.Option(metavar="NAME", help="State or output to draw.")]
Measure = Annotated[
    str | None,
    typer.Option(metavar="|".join(MEASURES), help="Of a response: what to show of each orbit."),
]
Kind = Annotated[
    str | None, typer.Option(metavar="|".join(KINDS), help="Of a simulation: what to draw.")
]
Out = Annotated[
    str | None,
    typer.Option(
        metavar="FILE", help="Figure to write: .png, .pdf or .svg; by default RESULT.png."
    ),
]


def plot(
    result: Result,
    output: Output = "x",
    measure: Measure = None,
    kind: Kind = None,
    out: Out = None,
) -> None:
    """Draw a saved result."""
    from slipfold.results.diagram import Diagram
    from slipfold.results.load import load
    from slipfold.results.writing import check_writable, write_file

    path = Path(result).with_suffix(".png") if out is None else Path(out)
    form = path.suffix.lower().lstrip(".")
    if form not in FORMATS:
        raise InputError(f"{path} has no ending of a figure; give .png, .pdf or .svg")
    check_writable(path)
    found = load(result)
    is_diagram = isinstance(found, Diagram)
    if is_diagram and kind is not None:
        raise InputError(
            f"--kind {kind} is for simulations, but {result} is a response; use --measure"
        )
    if not is_diagram and measure is not None:
        raise InputError(
            f"--measure {measure} is for responses, but {result} is a simulation; use --kind"
        )
    options = {"measure": measure} if is_diagram else {"kind": kind}
    given = {name: value for name, value in options.items() if value is not None}
    write_file(path, _draw(found, output, form, given))
    note(f"wrote {path}")


def _draw(found: Any, output: str, form: str, options: dict[str, str]) -> bytes:
    # A figure of its own needs no window, whatever the environment says.
    from matplotlib.figure import Figure

    from slipfold.plots.style import COLUMN, figure_style

    with figure_style():
        figure = Figure(figsize=(2 * COLUMN, 1.25 * COLUMN), layout="constrained")
        found.plot(output, ax=figure.add_subplot(), **options)
        content = io.BytesIO()
        figure.savefig(content, format=form)
    return content.getvalue()
