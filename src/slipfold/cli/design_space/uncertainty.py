"""``slipfold uncertainty``: a threshold where parameters scatter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from slipfold.cli.options import Csv, Friction, Json, ModelName, Out, Seed, Sets
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import parse_assignments, parse_span, parse_whole, refuse_varied
from slipfold.cli.status import DONE, INTERRUPTED, note

if TYPE_CHECKING:
    from slipfold.design_space.sampling import SampleProgress

__all__ = ["Period", "Type", "Vary", "uncertainty"]

Vary = Annotated[
    list[str],
    typer.Option(
        metavar="NAME=FIRST:LAST",
        help="Parameter of which the threshold is a value, and where it is looked for.",
    ),
]
Type = Annotated[
    str | None,
    typer.Option("--type", metavar="TYPE", help="Type of the special point; by default the first."),
]
Period = Annotated[
    str | None,
    typer.Option("--period", metavar="K", help="Period of its orbit in forcing periods."),
]
Scatters = Annotated[
    list[str],
    typer.Option(
        "--scatter",
        metavar="NAME=normal:SIZE",
        help="How a parameter scatters: normal (standard deviation), uniform (half the width, or "
        "FROM:TO) or lognormal, e.g. mu=normal:5% or alpha=uniform:58deg:62deg. Repeatable.",
    ),
]
Samples = Annotated[str, typer.Option(metavar="N", help="Number of samples, a power of 2.")]
Loads = Annotated[
    list[str] | None,
    typer.Option(
        "--quiet", metavar="VALUE", help="Tell the probability that this is quiet. Repeatable."
    ),
]
Indices = Annotated[
    bool, typer.Option("--indices", help="Compute Sobol's indices as well; needs SALib.")
]


def uncertainty(
    model: ModelName,
    vary: Vary,
    scatter: Scatters,
    type_: Type = None,
    period: Period = None,
    samples: Samples = "256",
    seed: Seed = "0",
    quiet: Loads = None,
    indices: Indices = False,
    set_: Sets = None,
    friction: Friction = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
) -> int:
    """Tell how a threshold scatters with parameters, by its gradients and by samples.

    Exit status: 0 done, 2 bad input, 130 interrupted; what was known by then is kept.
    """
    from slipfold.cli.case_file import find_model
    from slipfold.cli.interruption import deferred_interrupts
    from slipfold.cli.progress import done_text, live_line
    from slipfold.cli.special_points import first_point
    from slipfold.computations.response import response
    from slipfold.computations.uncertainty import uncertainty as compute

    outputs = Outputs(json, out, csv)
    outputs.check()
    given = parse_assignments(set_)
    chosen = find_model(model, given, friction)
    name, span = parse_span(vary, chosen)
    refuse_varied(given, (name,))
    known = parse_assignments(scatter, "--scatter")
    count, start = parse_whole(samples, "--samples"), parse_whole(seed, "--seed", least=0)
    rounds = None if period is None else parse_whole(period, "--period")
    with live_line() as show, deferred_interrupts() as check:
        show("response")
        diagram = response(chosen, name, span, observer=lambda progress: check())
        if diagram.interrupted:
            raise KeyboardInterrupt
        point = first_point(diagram, type_, rounds)

        def observe(progress: SampleProgress) -> None:
            show(done_text("samples", progress.done, progress.total))
            check()

        found = compute(
            point,
            known,
            samples=count,
            seed=start,
            loads=quiet or (),
            indices=indices,
            observer=observe,
        )
        outputs.write(found)
    if found.interrupted:
        note(f"interrupted; {outputs.kept}")
        return INTERRUPTED
    return DONE
