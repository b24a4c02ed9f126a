"""``slipfold measure``, ``fit`` and ``plan``: measured responses."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from slipfold.cli.interruption import deferred_interrupts
from slipfold.cli.reading import (
    GivenModel,
    OutputFiles,
    Reader,
    argument,
    command,
    option,
    parse_bounds,
    parse_number,
    varied,
)
from slipfold.cli.running import (
    DONE,
    FAILED,
    INTERRUPTED,
    live_line,
    note,
    reporter,
    say,
)
from slipfold.errors import InputError
from slipfold.options import Errors, Fitted, Option, Quantities, Seed, Sweeping
from slipfold.progress import Progress

if TYPE_CHECKING:
    from slipfold.parameter_space.measurement import Measurement

Varied = Annotated[
    tuple[str, tuple[float, float]], varied("The parameter that is swept, e.g. f=11:14.")
]
Points = Annotated[int, Option("Equidistant values of it, from first to last.", "whole", "N")]
File = Annotated[
    str | None,
    Option(
        "Write the measurements there, else they are printed.", metavar="FILE", flags=("--csv",)
    ),
]
DATA = argument(
    "DATA.csv",
    "Measurements with units in the head, e.g. 'Nd [N], max y [mm]'; also 'error of max y [mm]' "
    "and sweep.",
    "data",
)


def _read_data(given: Any, values: Any) -> Measurement:
    from slipfold.parameter_space.measurement import read_measurement

    return read_measurement(given["data"], values["model"])


Data = Annotated["Measurement", Reader((DATA,), _read_data)]
FittedBounds = Annotated[
    dict[str, tuple[float, float]],
    Reader(
        (
            option(
                "bounds",
                Option(
                    "A parameter to be fitted, and its bounds, e.g. mu=0.3:0.7.",
                    "texts",
                    "NAME=LEAST:GREATEST",
                    flags=("--fit",),
                ),
            ),
        ),
        lambda given, values: parse_bounds(given["bounds"], values["model"]),
    ),
]
Best = Annotated[
    int | None,
    Option("Choose the N most informative values, and plan these alone.", "whole", "N"),
]


@command
def measure(
    model: GivenModel,
    varied: Varied,
    quantity: Quantities,
    points: Points = 21,
    sweep: Sweeping = "up",
    error: Errors = (),
    seed: Seed = 1,
    csv: File = None,
) -> int:
    """Measure a response as a test stand would: sweep a parameter, with jumps and with noise.

    Exit status: 0 done, 2 bad input, 3 the solution ended at a limit, 130 interrupted; what was
    measured by then is kept.
    """
    from slipfold.computations.measured import measure as compute
    from slipfold.parameter_space.measurement import csv_of
    from slipfold.results.writing import check_writable, write_file

    if csv is not None:
        check_writable(csv)
    name, values = _values(varied, points)
    total = 0
    with live_line() as show, deferred_interrupts() as check:
        report = reporter(show, check)

        def observe(progress: Progress) -> None:
            nonlocal total
            total = progress.total or 0
            report(progress)

        errors = _errors(error) or 0.0
        compute = partial(compute, sweep=sweep, errors=errors, seed=seed, on_progress=observe)
        result = compute(model, name, values, quantity)
        remarks = [repr(model), f"swept {sweep} over {name}"]
        if result.stopped is not None:
            remarks.append(f"stopped early: {result.stopped}")
        text = csv_of(result, remarks)
        if csv is None:
            say(text.rstrip())
        else:
            write_file(csv, text.encode())
            note(f"wrote {csv}")
    if result.stopped is not None:
        note(f"stopped early: {result.stopped}; {len(result)} of {total} readings are kept")
        return FAILED
    if len(result) < total:
        note(f"interrupted after {len(result)} of {total} readings, which are kept")
        return INTERRUPTED
    return DONE


@command
def fit(model: GivenModel, data: Data, bounds: FittedBounds, outputs: OutputFiles) -> int:
    """Fit parameters to a measured response, with intervals of confidence.

    Exit status: 0 done, 2 bad input, 130 interrupted.
    """
    from slipfold.computations.measured import fit as compute

    outputs.of(partial(compute, model, data, bounds))
    return DONE


@command
def plan(
    model: GivenModel,
    varied: Varied,
    outputs: OutputFiles,
    quantity: Quantities,
    names: Fitted,
    error: Errors = (),
    points: Points = 21,
    best: Best = None,
) -> int:
    """Compute how accurately a planned measurement determines parameters, and the best readings.

    Exit status: 0 done, 2 bad input.
    """
    from slipfold.computations.measured import plan_measurement as compute

    errors = _errors(error)
    if errors is None:
        raise InputError("no --error is given; give what readings scatter by, e.g. --error 1e-4")
    name, values = _values(varied, points)
    with live_line():
        result = compute(model, name, values, quantity, names, errors=errors)
    if best is not None:
        result = result.some(result.best(best))
    outputs.write(result)
    if best is not None and outputs.json != "-":
        say(f"best at {name} = {', '.join(f'{value:.6g}' for value in result.values)}")
    return DONE


def _values(varied: tuple[str, tuple[float, float]], count: int) -> tuple[str, list[float]]:
    """Return the parameter that is swept, and its values."""
    name, (first, last) = varied
    step = (last - first) / max(count - 1, 1)
    return name, [first + k * step for k in range(count - 1)] + [last]


def _errors(texts: Any) -> float | list[float] | None:
    """Return the standard deviations given, None if there are none."""
    result = [parse_number(text, "--error") for text in texts or ()]
    return result[0] if len(result) == 1 else result or None
