"""``slipfold response``: the periodic response over a parameter, with its bifurcations."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated

from slipfold.cli.interruption import deferred_interrupts
from slipfold.cli.reading import (
    GivenModel,
    OutputFiles,
    ResponseSettings,
    command,
    parse_event,
    varied,
)
from slipfold.cli.running import (
    DONE,
    FAILED,
    INTERRUPTED,
    Outputs,
    live_line,
    note,
    reporter,
)
from slipfold.options import Box, Gradients, Option, Search, Settled, Start, Tori
from slipfold.progress import Progress

if TYPE_CHECKING:
    from slipfold.results.diagram import Diagram

Varied = Annotated[
    tuple[str, tuple[float, float]],
    varied("Parameter to follow and its first and last value, e.g. Nd=0:0.98 or f=14:11Hz."),
]
Events = Annotated[
    list[str] | None,
    Option(
        "Locate where the maximum (or min, peak_to_peak) of an output takes a value: "
        'x=0.3, "min(Vrel)=0.2"; or where the parameter does.',
        "texts",
        "[MEASURE](NAME)=VALUE",
        flags=("--event",),
    ),
]
Stops = Annotated[
    list[str] | None, Option("As --event, and end the branch there.", "texts", "EVENT")
]


@command
def response(
    model: GivenModel,
    varied: Varied,
    outputs: OutputFiles,
    settings: ResponseSettings,
    event: Events = None,
    stop_at: Stops = None,
    start: Start = None,
    settled: Settled = False,
    gradients: Gradients = False,
    search: Search = False,
    box: Box = None,
    tori: Tori = False,
) -> int:
    """Follow the periodic response over a parameter, with all bifurcations and doubled branches.

    Ctrl-C keeps what is finished. Exit status: 0 done, 2 bad input, 3 a branch could not be
    followed to its end, 130 interrupted.
    """
    from slipfold.branches.make_branch import complete_branches
    from slipfold.computations.response import response as compute

    events = [parse_event(text, model, varied[0]) for text in event or ()]
    events += [parse_event(text, model, varied[0], stop=True) for text in stop_at or ()]
    compute = partial(compute, model, *varied, start=start, settled=settled, gradients=gradients)
    compute = partial(compute, search=box or search, tori=tori, settings=settings, events=events)
    with deferred_interrupts() as check:
        with live_line() as show:
            diagram = compute(on_progress=reporter(show, check))

            def report(done: int, total: int) -> None:
                show(str(Progress("extrema and uncertainties", done, total)))
                if not diagram.interrupted:
                    check()

            tabled = outputs.out is not None or outputs.csv is not None
            complete = not tabled or complete_branches(diagram.branches, report)
        outputs.write(diagram)
    return _conclude(diagram, outputs, complete)


def _conclude(diagram: Diagram, outputs: Outputs, complete: bool) -> int:
    if diagram.interrupted or not complete:
        note(f"interrupted {_where(diagram)}; {outputs.kept}")
        return INTERRUPTED
    for branch in diagram.branches:
        for end in branch.ends:
            if end.early:
                note(f"branch {branch.id} stopped early: {end.reason}")
    for tori in diagram.tori:
        if tori.stopped.early:
            note(f"tori {tori.id} stopped early: {tori.stopped.reason}")
    return FAILED if diagram.failed else DONE


def _where(diagram: Diagram) -> str:
    """Return how far a computation had come when it was interrupted."""
    points = sum(len(branch) for branch in diagram.branches)
    if any(end.kind == "interrupted" for branch in diagram.branches for end in branch.ends):
        return f"on branch {len(diagram.branches)} after {points} points in all"
    number = sum(item.point.interrupted for item in diagram.special)
    if number:
        return f"before the normal forms of {number} of {len(diagram.special)} special points"
    if any(tori.interrupted for tori in diagram.tori):
        points = sum(len(tori) for tori in diagram.tori)
        return f"on tori {diagram.tori[-1].id} after {points} of their points in all"
    if diagram.interrupted:
        return "before all checks were done"
    return f"before the extrema and uncertainties of all {points} points were computed"
