"""``slipfold study`` and ``paper``: many cases, as a file describes them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from slipfold.declarations import Option
from slipfold.errors import InputError
from slipfold.interface.cli.commands import FILES, Reader, argument, given_text, optional
from slipfold.interface.cli.running import (
    DONE,
    FAILED,
    INTERRUPTED,
    Outputs,
    live_line,
    note,
    reporter,
    say,
)
from slipfold.options import Resume, RetryFailed
from slipfold.progress import duration_text
from slipfold.threads import cores

CASE = argument(
    "CASE.toml", "The study: a case file with the tables [compute] and [cases].", "case"
)
(Out,) = optional(
    out=Option(
        "Write everything as netCDF, CASE.nc if not given. Finished cases are stored next to it, "
        "in the folder FILE.study.",
        metavar="FILE.nc",
    )
)
READERS = {
    "case": given_text(CASE),
    "files": Reader(
        (FILES[0], Out, FILES[2]),
        lambda texts, _: {"files": Outputs(texts["json"], texts["out"], texts["csv"])},
    ),
}
Check = Annotated[bool, Option("Print what would be computed, and how long it may take.")]
Workers = Annotated[int | None, Option("Processes to compute in; as many as there are cores.")]
Scheduler = Annotated[
    str | None,
    Option("Compute on a Dask cluster, e.g. tcp://127.0.0.1:8786, instead.", metavar="ADDRESS"),
]


def study(
    case: str,
    files: Outputs,
    check: Check = False,
    resume: Resume = False,
    retry_failed: RetryFailed = False,
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> int:
    """Compute the cases that a store lacks, or say what would be computed."""
    from slipfold.computations.study import study as compute
    from slipfold.interface.cli.interruption import deferred_interrupts

    count = workers or cores()
    if check:
        _check(case, count, scheduler)
        return DONE
    file = files.out or f"{Path(case).stem}.nc"
    if Path(file).suffix == ".zarr":
        raise InputError(
            f"--out {file} would be netCDF all the same; give a name that ends in .nc (in Python "
            "to_xarray().to_zarr of the result writes zarr)"
        )
    outputs = Outputs(files.json, file, files.csv).checked()
    store = Path(file).with_suffix(".study")
    with live_line() as show, deferred_interrupts() as check_interrupt:
        result = compute(
            case,
            store,
            executor=scheduler or (None if count == 1 else count),
            resume=resume,
            retry_failed=retry_failed,
            on_progress=reporter(show, check_interrupt),
        )
    if result.interrupted:
        how = "" if retry_failed else " with --resume"
        note(
            f"interrupted; {result.done} of {len(result)} cases are stored in {store}; the same "
            f"command{how} continues"
        )
        return INTERRUPTED
    outputs.write(result)
    return DONE


def _check(case: str, workers: int, scheduler: str | None) -> None:
    """Print the size of a study and its estimated time, without contacting a scheduler."""
    from slipfold.studies.plan import read_plan, total
    from slipfold.studies.run import estimate

    plan = read_plan(case)
    count = total(plan.cases)
    product = " x ".join(map(str, plan.cases.shape))
    said = f"{product} = {count}" if len(plan.cases.shape) > 1 else f"{count}"
    cases = f"{said} case{'s' * (count > 1)} over {', '.join(plan.cases.names)}"
    say(f"{plan.work.what} of {plan.model!r}\n{cases}")
    result = estimate(plan)
    processes = "one process" if workers == 1 else f"{workers} processes"
    if scheduler is not None:
        processes += f" of this machine, not at {scheduler}"
    alone, at_most = (" alone", "at most ") if result.batched else ("", "")
    say(
        f"{result.seconds:.3g} s a case{alone}, from {result.tried} of them: "
        f"{at_most}{duration_text(-(-count // workers) * result.seconds)} on {processes}"
        f"{', as cases are computed in batches' if result.batched else ''}"
    )
    for reason in result.failures:
        say(f"one of these failed: {reason}")


Folder = Annotated[
    str, Option("Folder to write to; made if there is none.", metavar="DIR", flags=("--out",))
]
Processes = Annotated[int | None, Option("Processes to compute with; one a processor by default.")]
WithTori = Annotated[bool, Option("Follow the tori, too, and draw them in figures 2 and 3.")]
WithLongTerm = Annotated[
    bool,
    Option(
        "Draw the long-term behavior, too: tori in figures 2 and 3 as with --tori, both completed "
        "with chaos, hysteresis with its basins, regimes over the bifurcation set; some ten "
        "minutes more."
    ),
]


def paper(
    out: Folder = "paper-output",
    processes: Processes = None,
    tori: WithTori = False,
    long_term: WithLongTerm = False,
) -> int:
    """Compute and draw what the source paper shows."""
    from slipfold.interface.paper.reproduce import reproduce

    with live_line() as show:
        made = reproduce(
            out,
            on_progress=lambda progress: show(str(progress)),
            processes=processes or cores(),
            tori=tori,
            long_term=long_term,
        )
    if made.interrupted:
        note(made.message)
        return INTERRUPTED
    say(made.message)
    for sentence in made.stopped:
        note(f"stopped early: {sentence}")
    return FAILED if made.stopped else DONE
