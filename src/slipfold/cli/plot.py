"""``slipfold plot``: a figure of a saved result."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from slipfold.cli.status import note
from slipfold.errors import InputError

__all__ = ["plot"]

FORMATS = ("png", "pdf", "svg")

MEASURES = ("max", "min", "peak_to_peak", "modulus", "stuck_fraction")

KINDS = (
    *("timeseries", "spectrum", "phase"),
    *("hysteresis", "friction", "path", "track", "timeline"),
)

OPTIONS: dict[str, tuple[str, tuple[str, ...]]] = {
    "Diagram": ("response", ("output", "measure")),
    "Simulation": ("simulation", ("output", "kind", "contact")),
    "LocusDiagram": ("bifurcation set", ()),
}
"""What each kind of result is called, and the options that go with it."""

Result = Annotated[str, typer.Argument(metavar="RESULT.nc", help="A file written by --out.")]
Output = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="Of a response or simulation: what to draw, by default the first state.",
    ),
]
Measure = Annotated[
    str | None,
    typer.Option(metavar="|".join(MEASURES), help="Of a response: what to show of each orbit."),
]
Kind = Annotated[
    str | None,
    typer.Option(
        metavar="|".join(KINDS),
        help="Of a simulation: what to draw; the last five show contacts.",
    ),
]
Contact = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Of a simulation: the contact to draw, by default all."),
]
Out = Annotated[
    str | None,
    typer.Option(
        metavar="FILE", help="Figure to write: .png, .pdf or .svg; by default RESULT.png."
    ),
]


def plot(
    result: Result,
    output: Output = None,
    measure: Measure = None,
    kind: Kind = None,
    contact: Contact = None,
    out: Out = None,
) -> None:
    """Draw a saved result."""
    from slipfold.results.load import load
    from slipfold.results.writing import check_writable, write_file

    path = Path(result).with_suffix(".png") if out is None else Path(out)
    form = path.suffix.lower().lstrip(".")
    if form not in FORMATS:
        raise InputError(f"{path} has no ending of a figure; give .png, .pdf or .svg")
    check_writable(path)
    found = load(result)
    options = {"output": output, "measure": measure, "kind": kind, "contact": contact}
    given = {name: value for name, value in options.items() if value is not None}
    _check_options(given, type(found).__name__, result)
    write_file(path, _draw(found, form, given))
    note(f"wrote {path}")


def _check_options(given: Mapping[str, str], kind: str, path: str) -> None:
    """Refuse what goes with another kind of result."""
    name, known = OPTIONS[kind]
    instead = f"use --{' or --'.join(known)}" if known else "leave it out"
    for option, value in given.items():
        if option not in known:
            meant = [f"{other}s" for other, options in OPTIONS.values() if option in options]
            raise InputError(
                f"--{option} {value} is for {' and '.join(meant)}, but {path} is a {name}; "
                f"{instead}"
            )


def _draw(found: Any, form: str, options: Mapping[str, str]) -> bytes:
    # A figure of its own needs no window, whatever the environment says.
    from matplotlib.figure import Figure

    from slipfold.plots.style import COLUMN, figure_style

    with figure_style():
        # Bands need no height.
        height = 0.5 if options.get("kind") == "timeline" else 1.25
        figure = Figure(figsize=(2 * COLUMN, height * COLUMN), layout="constrained")
        found.plot(ax=figure.add_subplot(), **options)
        content = io.BytesIO()
        figure.savefig(content, format=form)
    return content.getvalue()
