"""``slipfold study``: one computation for many cases, as a file describes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from slipfold.cli.options import Csv, Json
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import parse_whole
from slipfold.cli.status import DONE, INTERRUPTED, note, say
from slipfold.errors import InputError
from slipfold.threads import cores

if TYPE_CHECKING:
    from slipfold.progress import Progress

CaseFile = Annotated[
    str,
    typer.Argument(
        metavar="CASE.toml",
        help="The study: a case file with the tables [compute] and [cases].",
    ),
]
Out = Annotated[
    str | None,
    typer.Option(
        "--out",
        metavar="FILE.nc",
        help="Write everything as netCDF, CASE.nc if not given. Finished cases are kept beside it, "
        "in the folder FILE.study.",
    ),
]
Check = Annotated[
    bool,
    typer.Option("--check", help="Say what would be computed, and how long it may take."),
]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with a study that was interrupted.")]
RetryFailed = Annotated[
    bool, typer.Option("--retry-failed", help="Compute cases that failed again, too.")
]
Workers = Annotated[
    str | None,
    typer.Option(metavar="N", help="Processes to compute in; as many as there are cores."),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS", help="Compute on a Dask cluster, e.g. tcp://127.0.0.1:8786, instead."
    ),
]


def study(
    case: CaseFile,
    check: Check = False,
    resume: Resume = False,
    retry_failed: RetryFailed = False,
    workers: Workers = None,
    scheduler: Scheduler = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
) -> int:
    """Compute the same thing for many cases, on all cores or a cluster; lose none.

    Each finished case is kept at once: after Ctrl-C, a crash or a full disk, --resume goes on. A
    case that fails is kept with its reason and stops no others. Exit status: 0 done, 2 bad input
    or a store that cannot be written, 130 interrupted.
    """
    from pathlib import Path

    from slipfold.cli.interruption import deferred_interrupts
    from slipfold.cli.progress import live_line
    from slipfold.computations.study import study as compute

    count = cores() if workers is None else parse_whole(workers, "--workers")
    if check:
        _check(case, count, scheduler)
        return DONE
    file = out or f"{Path(case).stem}.nc"
    if Path(file).suffix == ".zarr":
        raise InputError(
            f"--out {file} would be netCDF all the same; give a name that ends in .nc (in Python "
            "to_xarray().to_zarr of the result writes zarr)"
        )
    outputs = Outputs(json, file, csv).checked()
    store = Path(file).with_suffix(".study")
    with live_line() as show, deferred_interrupts() as check_interrupt:

        def observe(progress: Progress) -> None:
            show(str(progress))
            check_interrupt()

        found = compute(
            case,
            store,
            executor=scheduler or (None if count == 1 else count),
            resume=resume,
            retry_failed=retry_failed,
            observer=observe,
        )
    if found.interrupted:
        how = "" if retry_failed else " with --resume"
        note(
            f"interrupted; {found.done} of {len(found)} cases are kept in {store}; the same "
            f"command{how} goes on"
        )
        return INTERRUPTED
    outputs.write(found)
    return DONE


def _check(case: str, workers: int, scheduler: str | None) -> None:
    """Print what a study is; a scheduler is not asked what it has."""
    from slipfold.progress import duration_text
    from slipfold.studies.cases import total
    from slipfold.studies.estimate import estimate
    from slipfold.studies.plan import read_plan

    plan = read_plan(case)
    count = total(plan.cases)
    product = " x ".join(map(str, plan.cases.shape))
    said = f"{product} = {count}" if len(plan.cases.shape) > 1 else f"{count}"
    say(f"{plan.work.what} of {plan.model!r}\n{said} cases over {', '.join(plan.cases.names)}")
    found = estimate(plan)
    processes = "one process" if workers == 1 else f"{workers} processes"
    if scheduler is not None:
        processes += f" of this machine, not at {scheduler}"
    alone, most = (" by itself", "at most ") if found.beside else ("", "")
    say(
        f"{found.seconds:.3g} s a case{alone}, from {found.tried} of them: "
        f"{most}{duration_text(count * found.seconds / workers)} on {processes}"
        f"{', as cases go side by side' if found.beside else ''}"
    )
    for reason in found.failures:
        say(f"one of these failed: {reason}")
