"""``slipfold measure``, ``fit`` and ``plan``: measured responses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from slipfold.cli.carry_out import carry_out
from slipfold.cli.case_file import find_model
from slipfold.cli.options import Csv, Friction, Json, ModelName, Out, Sets
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import (
    parse_assignments,
    parse_bounds,
    parse_numbers,
    parse_span,
    parse_whole,
)
from slipfold.cli.status import DONE, FAILED, INTERRUPTED, note, say
from slipfold.progress import Progress

if TYPE_CHECKING:
    from slipfold.models.model import Model

Vary = Annotated[
    list[str],
    typer.Option(metavar="NAME=FIRST:LAST", help="The parameter that is swept, e.g. f=11:14."),
]
Points = Annotated[
    str, typer.Option(metavar="N", help="Values of it, evenly spaced from first to last.")
]
Quantities = Annotated[
    list[str],
    typer.Option(
        "--quantity",
        metavar="MEASURE OUTPUT",
        help="What is measured, e.g. 'max y': max, min, peak_to_peak or modulus. Repeatable.",
    ),
]
Sweep = Annotated[
    str, typer.Option(metavar="up|down|both", help="Direction; both is up and then down.")
]
Errors = Annotated[
    list[str] | None,
    typer.Option(
        "--error",
        metavar="R",
        help="Standard deviation of readings, once for all quantities or once for each.",
    ),
]
Seed = Annotated[str, typer.Option(metavar="N", help="Seed of the noise, a whole number.")]
File = Annotated[
    str | None,
    typer.Option("--csv", metavar="FILE", help="Write the readings there, else they are printed."),
]
Data = Annotated[
    str,
    typer.Argument(
        metavar="DATA.csv",
        help="Readings with units in the head, e.g. 'Nd [N], max y [mm]'; also 'error of max y "
        "[mm]' and sweep.",
    ),
]
Bounds = Annotated[
    list[str],
    typer.Option(
        "--fit",
        metavar="NAME=LEAST:GREATEST",
        help="A parameter to be fitted, and its bounds, e.g. mu=0.3:0.7. Repeatable.",
    ),
]
Names = Annotated[
    list[str],
    typer.Option("--fit", metavar="NAME", help="A parameter that a fit is to tell. Repeatable."),
]
Best = Annotated[
    str | None,
    typer.Option(metavar="N", help="Choose the N values that tell most, and plan these alone."),
]


def measure(
    model: ModelName,
    vary: Vary,
    quantity: Quantities,
    points: Points = "21",
    sweep: Sweep = "up",
    error: Errors = None,
    seed: Seed = "1",
    set_: Sets = None,
    friction: Friction = None,
    csv: File = None,
) -> int:
    """Measure a response as a test stand would: sweep a parameter, with jumps and with noise.

    Exit status: 0 done, 2 bad input, 3 the motion ended at a limit, 130 interrupted; what was read
    by then is kept.
    """
    from slipfold.cli.interruption import deferred_interrupts
    from slipfold.cli.progress import live_line
    from slipfold.computations.measure import measure as compute
    from slipfold.measured.csv_file import csv_of
    from slipfold.results.writing import check_writable, write_file

    if csv is not None:
        check_writable(csv)
    chosen = find_model(model, parse_assignments(set_), friction)
    name, values = _values(vary, points, chosen)
    total = 0
    with live_line() as show, deferred_interrupts() as check:

        def observe(progress: Progress) -> None:
            nonlocal total
            total = progress.total or 0
            show(str(progress))
            check()

        found = compute(
            chosen,
            name,
            values,
            quantity,
            sweep=sweep,
            errors=_errors(error) or 0.0,
            seed=parse_whole(seed, "--seed"),
            observer=observe,
        )
        remarks = [repr(chosen), f"swept {sweep} over {name}"]
        if found.stopped is not None:
            remarks.append(f"stopped early: {found.stopped}")
        text = csv_of(found, remarks)
        if csv is None:
            say(text.rstrip())
        else:
            write_file(csv, text.encode())
            note(f"wrote {csv}")
    if found.stopped is not None:
        note(f"stopped early: {found.stopped}; {len(found)} of {total} readings are kept")
        return FAILED
    if len(found) < total:
        note(f"interrupted after {len(found)} of {total} readings, which are kept")
        return INTERRUPTED
    return DONE


def fit(
    model: ModelName,
    data: Data,
    bounds: Bounds,
    set_: Sets = None,
    friction: Friction = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
) -> int:
    """Fit parameters to a measured response, with intervals of confidence.

    Exit status: 0 done, 2 bad input, 130 interrupted.
    """
    from slipfold.computations.fit import fit as compute
    from slipfold.measured.csv_file import read_measurement

    outputs = Outputs(json, out, csv).checked()
    chosen = find_model(model, parse_assignments(set_), friction)
    measurement = read_measurement(data, chosen)
    carry_out(
        lambda observer: compute(
            chosen, measurement, parse_bounds(bounds, chosen), observer=observer
        ),
        outputs,
    )
    return DONE


def plan(
    model: ModelName,
    vary: Vary,
    quantity: Quantities,
    names: Names,
    error: Errors = None,
    points: Points = "21",
    best: Best = None,
    set_: Sets = None,
    friction: Friction = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
) -> int:
    """Tell how well a planned measurement would tell parameters, and which readings tell most.

    Exit status: 0 done, 2 bad input.
    """
    from slipfold.cli.progress import live_line
    from slipfold.computations.plan_measurement import plan_measurement as compute
    from slipfold.errors import InputError

    outputs = Outputs(json, out, csv).checked()
    chosen = find_model(model, parse_assignments(set_), friction)
    errors = _errors(error)
    if errors is None:
        raise InputError("no --error is given; give what readings scatter by, e.g. --error 1e-4")
    name, values = _values(vary, points, chosen)
    with live_line():
        found = compute(chosen, name, values, quantity, names, errors=errors)
    if best is not None:
        found = found.some(found.best(parse_whole(best, "--best")))
    outputs.write(found)
    if best is not None and json != "-":
        say(f"best at {name} = {', '.join(f'{value:.6g}' for value in found.values)}")
    return DONE


def _values(vary: list[str], points: str, model: Model) -> tuple[str, list[float]]:
    """Return the parameter that is swept, and its values."""
    name, (first, last) = parse_span(vary, model)
    count = parse_whole(points, "--points")
    step = (last - first) / max(count - 1, 1)
    return name, [first + k * step for k in range(count - 1)] + [last]


def _errors(texts: list[str] | None) -> float | list[float] | None:
    """Return the standard deviations given, None if there are none."""
    found = parse_numbers(texts, "--error")
    if len(found) == 1:
        return found[0]
    return found or None
