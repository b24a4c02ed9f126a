"""``slipfold response``: the periodic response over a parameter, with its bifurcations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from slipfold.cli.case_file import find_varied
from slipfold.cli.interruption import deferred_interrupts
from slipfold.cli.options import (
    Box,
    Csv,
    Friction,
    Json,
    MaxPoints,
    MaxStep,
    ModelName,
    Out,
    Sets,
    Start,
    Tolerance,
)
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import (
    parse_assignments,
    parse_box,
    parse_event,
)
from slipfold.cli.progress import live_line
from slipfold.cli.settings import parse_settings
from slipfold.cli.status import DONE, FAILED, INTERRUPTED, note
from slipfold.progress import Progress

if TYPE_CHECKING:
    from slipfold.results.diagram import Diagram

Vary = Annotated[
    list[str],
    typer.Option(
        metavar="NAME=FIRST:LAST",
        help="Parameter to follow and its first and last value, e.g. Nd=0:0.98 or f=14:11Hz.",
    ),
]
Events = Annotated[
    list[str] | None,
    typer.Option(
        "--event",
        metavar="[MEASURE](NAME)=VALUE",
        help="Locate where the maximum (or min, peak_to_peak) of an output takes a value: "
        'x=0.3, "min(Vrel)=0.2"; or where the parameter does. Repeatable.',
    ),
]
Stops = Annotated[
    list[str] | None,
    typer.Option("--stop-at", metavar="EVENT", help="As --event, and end the branch there."),
]
LargestPeriod = Annotated[
    str | None,
    typer.Option(metavar="K", help="Follow doubled branches up to this many forcing periods."),
]
Discretisation = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="Compute orbits by shooting, by collocation, or (automatic) by collocation where "
        "shooting cannot go on.",
    ),
]
Gradients = Annotated[
    bool,
    typer.Option(
        "--gradients",
        help="Tell of every special point how it moves with every other parameter.",
    ),
]
Tori = Annotated[
    bool,
    typer.Option(
        "--tori",
        help="Follow the quasi-periodic tori born at Neimark-Sacker points, too; with --settled "
        "the one that a motion settles on.",
    ),
]
Settled = Annotated[
    bool,
    typer.Option(
        "--settled",
        help="Follow what a motion settles to at the start of the span, instead of the response "
        "(of an autonomous system: the equilibrium).",
    ),
]
Search = Annotated[
    bool,
    typer.Option(
        "--search",
        help="Then start motions at four values of the span and follow what they settle on where "
        "no branch leads to it; of an autonomous system all equilibria, too. From --box if given.",
    ),
]


def response(
    model: ModelName,
    vary: Vary,
    set_: Sets = None,
    friction: Friction = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
    event: Events = None,
    stop_at: Stops = None,
    max_step: MaxStep = None,
    tolerance: Tolerance = None,
    max_points: MaxPoints = None,
    largest_period: LargestPeriod = None,
    start: Start = None,
    settled: Settled = False,
    gradients: Gradients = False,
    search: Search = False,
    box: Box = None,
    tori: Tori = False,
    discretisation: Discretisation = None,
) -> int:
    """Follow the periodic response over a parameter; find every bifurcation and go on past it.

    Ctrl-C keeps what is finished. Exit status: 0 done, 2 bad input, 3 a branch could not be
    followed to its end, 130 interrupted.
    """
    from slipfold.branches.complete import complete_branches
    from slipfold.computations.response import response as compute

    outputs = Outputs(json, out, csv).checked()
    chosen, name, span = find_varied(model, vary, set_, friction)
    events = [parse_event(text, chosen, name) for text in event or ()]
    events += [parse_event(text, chosen, name, stop=True) for text in stop_at or ()]
    settings = parse_settings(max_step, tolerance, max_points, largest_period, discretisation)
    begin = parse_assignments(start, "--start") or None
    where = parse_box(box)
    with deferred_interrupts() as check:
        with live_line() as show:

            def observer(progress: Progress) -> None:
                show(str(progress))
                if progress.values["points"]:  # before the first there is nothing to lose
                    check()

            diagram = compute(
                chosen,
                name,
                span,
                start=begin,
                settled=settled,
                gradients=gradients,
                search=where or search,
                tori=tori,
                settings=settings,
                events=events,
                observer=observer,
            )

            def tell(done: int, total: int) -> None:
                show(str(Progress("extrema and uncertainties", done, total)))
                if not diagram.interrupted:
                    check()

            tabled = outputs.out is not None or outputs.csv is not None
            whole = not tabled or complete_branches(diagram.branches, tell)
        outputs.write(diagram)
    return _conclude(diagram, outputs, whole)


def _conclude(diagram: Diagram, outputs: Outputs, whole: bool) -> int:
    if diagram.interrupted or not whole:
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
    """Say how far a computation had come when it was interrupted."""
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
