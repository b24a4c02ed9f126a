"""``slipfold plot``: a figure of a saved result."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from slipfold.declarations import Option
from slipfold.errors import InputError
from slipfold.interface.cli.commands import argument, given_text
from slipfold.interface.cli.running import note

if TYPE_CHECKING:
    from slipfold.results.diagram import Diagram

FORMATS = ("png", "pdf", "svg")

READERS = {"result": given_text(argument("RESULT.nc", "A file written by --out.", "result"))}
Output = Annotated[
    str | None,
    Option(
        "Of a response, simulation or sweep: what to draw, by default what its table shows first.",
        metavar="NAME",
    ),
]
Measure = Annotated[
    str | None,
    Option(
        "Of a response or sweep: what to show of each solution; max_and_min, rms, harmonic "
        "(the first) and level, in dB re ISO 1683 or as in 'level re 1 um', of responses only, "
        "stroboscopic of sweeps only.",
        metavar="max|min|max_and_min|peak_to_peak|modulus|rms|harmonic|level|stuck_fraction|stroboscopic",
    ),
]
PlotKind = Annotated[
    str | None,
    Option(
        "What to draw: of a simulation timeseries, spectrum or phase, and of its contacts "
        "hysteresis, friction, path, track or timeline; of a sweep points, section or waterfall; "
        "of a response the spectrum of a torus, the eigenvalues of equilibria, or a "
        "backbone.",
        metavar="KIND",
    ),
]
Contact = Annotated[
    str | None, Option("Of a simulation: the contact to draw, by default all.", metavar="NAME")
]
Measured = Annotated[
    str | None,
    Option(
        "Of a response: measurements to draw with it, see slipfold fit --help.", metavar="DATA.csv"
    ),
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
    Option(
        "Figure to write: .png, .pdf or .svg; by default RESULT.png. A response can also be "
        "written as .csv, with all its points.",
        metavar="FILE",
    ),
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
    from slipfold.models.units import parse_quantity
    from slipfold.results.diagram import Diagram
    from slipfold.results.result import load
    from slipfold.results.trajectories import Sweep
    from slipfold.writing import check_writable, write_file

    path = Path(result).with_suffix(".png") if out is None else Path(out)
    form = path.suffix.lower().lstrip(".")
    if form not in (*FORMATS, "csv"):
        raise InputError(
            f"{path} has no known ending; give .png, .pdf or .svg, or .csv of a response"
        )
    check_writable(path)
    saved = load(result)
    options = {
        "output": output,
        "measure": measure,
        "kind": kind,
        "contact": contact,
        "quantity": quantity,
        "measured": measured,
        "at": at,
    }
    given: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    if form == "csv":
        if not isinstance(saved, Diagram):
            raise InputError(f"{path} can hold only a response; give .png, .pdf or .svg")
        if refused := sorted(given.keys() - {"output", "measure"}):
            raise InputError(f"--{refused[0]} is of figures only, not of {path}; leave it out")
        write_file(path, _rows(saved, output, measure or "max").encode())
        note(f"wrote {path}")
        return
    if measured is not None:
        from slipfold.parameter_space.measurement import read_measurement

        given["measured"] = read_measurement(measured, saved.model)
    if at is not None:
        vary = saved.vary if isinstance(saved, Diagram | Sweep) else None
        unit = "" if vary is None else saved.model.parameter(vary).unit
        given["at"] = parse_quantity(at, unit, vary or "--at")
    from slipfold.plots.style import drawn

    figured: Any = saved
    # Bands need no height.
    height = 0.5 if kind == "timeline" else 1.25
    write_file(path, drawn(lambda ax: figured.plot(ax=ax, **given), form, height))
    note(f"wrote {path}")


def _rows(diagram: Diagram, output: str | None, measure: str = "max") -> str:
    """Return the points of a response as CSV, a row each; of tori there are only extrema."""
    from slipfold import lines
    from slipfold.models.levels import quantity_of
    from slipfold.orbits.extrema import AVERAGED
    from slipfold.results.tables import Frame

    model, shown, parts = diagram.model, output or diagram.model.shown[0], lines.parts_of(measure)
    lines.check_measure(diagram.branches, measure)
    rows: list[tuple[Any, ...]] = []
    for branch in diagram.branches:
        values = [lines.measured_along(branch, shown, part) for part in parts]
        known = [*zip(branch.arclength, branch.parameter, *values, [""] * len(branch), strict=True)]
        for item in branch.special:
            value = [lines.measured_at(item, shown, part) for part in parts]
            known.append((item.arclength, item.value, *value, item.type))
        rows += [(branch.id, *row) for _, *row in sorted(known, key=lambda each: each[0])]
    none = measure in (lines.STUCK, *AVERAGED) or lines.is_level(measure)
    for tori in diagram.tori:
        extrema = [
            [""] * len(tori) if none else lines.measure_of(tori.extrema, shown, p) for p in parts
        ]
        rows += [(tori.id, *row, "") for row in zip(tori.parameter, *extrema, strict=True)]
    heads = [f"{part.partition(' re ')[0]} {shown}" for part in parts]
    names = "branch", diagram.vary, *heads, "type"
    unit = "" if measure == lines.STUCK else quantity_of(model, shown).unit
    unit = lines.level_unit(model, shown, measure) if lines.is_level(measure) else unit
    units = {diagram.vary: model.parameter(diagram.vary).unit, **dict.fromkeys(heads, unit)}
    columns = {name: [row[i] for row in rows] for i, name in enumerate(names)}
    return Frame(columns, units).to_csv()
