"""``slipfold locus``: bifurcations followed in two parameters, and the regions between them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from slipfold.cli.interruption import deferred_interrupts
from slipfold.cli.options import Csv, Json, MaxPoints, MaxStep, ModelName, Out, Sets, Tolerance
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import (
    parse_assignments,
    parse_whole,
    parse_window,
    refuse_varied,
)
from slipfold.cli.progress import live_line, locus_text
from slipfold.cli.settings import parse_settings
from slipfold.cli.status import DONE, FAILED, INTERRUPTED, note

if TYPE_CHECKING:
    from slipfold.loci.progress import LocusProgress
    from slipfold.results.locus_diagram import LocusDiagram

__all__ = ["locus"]

Vary = Annotated[
    list[str],
    typer.Option(
        metavar="NAME=FIRST:LAST",
        help="One of the two parameters and its range, e.g. f=11.5:13.5Hz; give it twice.",
    ),
]
Types = Annotated[
    list[str] | None,
    typer.Option(
        "--type",
        metavar="LP|PD|NS",
        help="Type of bifurcation to follow: fold, period doubling or Neimark-Sacker; all by "
        "default. Repeatable.",
    ),
]
Periods = Annotated[
    list[str] | None,
    typer.Option(
        "--period",
        metavar="1|2",
        help="Period of the orbits in forcing periods; both by default. Repeatable.",
    ),
]
Regions = Annotated[
    bool,
    typer.Option(
        "--regions",
        help="Find the regions between the loci and the stable responses in each, checked by "
        "simulations; takes all types and both periods.",
    ),
]


def locus(
    model: ModelName,
    vary: Vary,
    set_: Sets = None,
    type_: Types = None,
    period: Periods = None,
    regions: Regions = False,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
    max_step: MaxStep = None,
    tolerance: Tolerance = None,
    max_points: MaxPoints = None,
) -> int:
    """Find all bifurcations in a window of two parameters, and follow them through it.

    Ctrl-C keeps what is finished. Exit status: 0 done, 2 bad input, 3 a locus could not be followed
    to its end, 130 interrupted.
    """
    from slipfold.cli.case_file import find_model
    from slipfold.loci.bifurcation_set import PERIODS
    from slipfold.loci.follow import LOCUS_TYPES
    from slipfold.results.bifurcation_set import bifurcation_set as compute

    outputs = Outputs(json, out, csv)
    outputs.check()
    given = parse_assignments(set_)
    chosen = find_model(model, given)
    plane, window = parse_window(vary, chosen)
    refuse_varied(given, plane)
    types = [text.upper() for text in type_ or LOCUS_TYPES]
    periods = [parse_whole(text, "--period") for text in period or map(str, PERIODS)]
    settings = parse_settings(max_step, tolerance, max_points)
    first, second = (chosen.parameter(name).unit for name in plane)
    words = locus_text(plane, (first, second))
    with deferred_interrupts() as check:
        with live_line() as show:

            def observer(progress: LocusProgress) -> None:
                show(words(progress))
                check()

            diagram = compute(
                chosen,
                plane,
                window,
                types=types,
                periods=periods,
                regions=regions,
                settings=settings,
                observer=observer,
            )
        outputs.write(diagram)
    return _conclude(diagram, outputs)


def _conclude(diagram: LocusDiagram, outputs: Outputs) -> int:
    if diagram.interrupted:
        points = sum(len(item) for item in diagram.loci)
        number = len(diagram.loci)
        loci = "1 locus" if number == 1 else f"{number} loci"
        note(f"interrupted after {points} points on {loci}; {outputs.kept}")
        return INTERRUPTED
    for item in diagram.loci:
        for end in (item.begun, item.stopped):
            if end.early:
                note(f"locus {item.id} stopped early: {end.reason}")
    return FAILED if diagram.failed else DONE
