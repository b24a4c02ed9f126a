"""``slipfold plot``: a figure of a saved result."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from slipfold.cli.commands import argument, given_text
from slipfold.cli.running import note
from slipfold.errors import InputError
from slipfold.options import Option

FORMATS = ("png", "pdf", "svg")

MEASURES = ("max", "min", "peak_to_peak", "modulus", "stuck_fraction", "strobe")

OF_MOTIONS = (
    *("timeseries", "spectrum", "phase"),
    *("hysteresis", "friction", "path", "track", "timeline"),
)

KINDS = {
    "Simulation": OF_MOTIONS,
    "Sweep": ("points", "section", "waterfall"),
    "Diagram": ("spectrum",),
}
"""Kinds of drawings of each kind of result."""

OPTIONS: dict[str, tuple[str, tuple[str, ...]]] = {
    "Diagram": ("response", ("output", "measure", "measured", "kind", "at")),
    "Simulation": ("simulation", ("output", "kind", "contact")),
    "LocusDiagram": ("bifurcation set", ()),
    "ThresholdMap": ("threshold map", ()),
    "Basins": ("picture of basins", ()),
    "BasinFractions": ("set of shares of basins", ()),
    "Fit": ("fit", ()),
    "MeasurementPlan": ("plan of a measurement", ()),
    "RegimeMap": ("map of regimes", ()),
    "Sweep": ("sweep", ("output", "measure", "kind", "at")),
    "StudyResult": ("study", ("quantity",)),
    "Design": ("design", ()),
    "ThresholdUncertainty": ("scatter of a threshold", ()),
}
"""Name of each kind of result, and its options."""

READERS = {"result": given_text(argument("RESULT.nc", "A file written by --out.", "result"))}
Output = Annotated[
    str | None,
    Option(
        "Of a response, simulation or sweep: what to draw, by default the first state.",
        metavar="NAME",
    ),
]
Measure = Annotated[
    str | None,
    Option(
        "Of a response or sweep: what to show of each solution; strobe of sweeps only.",
        metavar="|".join(MEASURES),
    ),
]
PlotKind = Annotated[
    str | None,
    Option(
        "What to draw: the last three of a sweep, the others of a simulation, of which five show "
        "contacts; spectrum of a response is that of a torus.",
        metavar="|".join((*OF_MOTIONS, *KINDS["Sweep"])),
    ),
]
Contact = Annotated[
    str | None, Option("Of a simulation: the contact to draw, by default all.", metavar="NAME")
]
Measured = Annotated[
    str | None,
    Option("Of a response: readings to draw with it, see slipfold fit --help.", metavar="DATA.csv"),
]
At = Annotated[
    str | None,
    Option(
        "Of a section of a sweep, or the spectrum of a torus: the value of the parameter.",
        metavar="VALUE",
    ),
]
Quantity = Annotated[
    str | None, Option("Of a study: what to draw, by default the first number.", metavar="NAME")
]
Out = Annotated[
    str | None,
    Option("Figure to write: .png, .pdf or .svg; by default RESULT.png.", metavar="FILE"),
]


def plot(
    result: str,
    output: Output = None,
    measure: Measure = None,
    kind: PlotKind = None,
    contact: Contact = None,
    measured: Measured = None,
    at: At = None,
    quantity: Quantity = None,
    out: Out = None,
) -> None:
    """Draw a saved result."""
    from slipfold.models.quantity import parse_quantity
    from slipfold.results.diagram import Diagram
    from slipfold.results.result import load
    from slipfold.results.trajectories import Sweep
    from slipfold.results.writing import check_writable, write_file

    path = Path(result).with_suffix(".png") if out is None else Path(out)
    form = path.suffix.lower().lstrip(".")
    if form not in FORMATS:
        raise InputError(f"{path} has no ending of a figure; give .png, .pdf or .svg")
    check_writable(path)
    found = load(result)
    options = {
        "output": output,
        "measure": measure,
        "kind": kind,
        "contact": contact,
        "measured": measured,
        "at": at,
        "quantity": quantity,
    }
    given: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    _check_options(given, type(found).__name__, result)
    if measured is not None:
        from slipfold.parameter_space.measurement import read_measurement

        given["measured"] = read_measurement(measured, found.model)
    if isinstance(found, (Diagram, Sweep)) and at is not None:
        given["at"] = parse_quantity(at, found.model.parameter(found.vary).unit, found.vary)
    write_file(path, _draw(found, form, given))
    note(f"wrote {path}")


def _check_options(given: Mapping[str, str], kind: str, path: str) -> None:
    """Refuse options of another kind of result."""
    if kind not in OPTIONS:
        raise InputError(f"{path} holds numbers that no figure shows; give another result")
    name, known = OPTIONS[kind]
    for option, value in given.items():
        if not _goes_with(kind, option, value):
            meant = [
                f"{OPTIONS[other][0]}s" for other in OPTIONS if _goes_with(other, option, value)
            ]
            instead = f"use --{' or --'.join(known)}" if known else "leave it out"
            if option in known:
                instead = f"use --kind {' or '.join(KINDS[kind])}"
            raise InputError(
                f"--{option} {value} is for {' and '.join(meant)}, but {path} is a {name}; "
                f"{instead}"
            )


def _goes_with(kind: str, option: str, value: str) -> bool:
    """Whether a kind of result has an option; --kind only with what may be drawn of it.

    An unknown kind is refused by the drawing.
    """
    elsewhere = any(value in kinds for kinds in KINDS.values())
    of_it = option != "kind" or not elsewhere or value in KINDS.get(kind, ())
    return option in OPTIONS[kind][1] and of_it


def _draw(found: Any, form: str, options: Mapping[str, Any]) -> bytes:
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
