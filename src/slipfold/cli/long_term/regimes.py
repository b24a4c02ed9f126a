"""``slipfold regimes``: what motions do over a plane of two parameters."""

from __future__ import annotations

from typing import Annotated

import typer

from slipfold.cli.carry_out import carry_out
from slipfold.cli.case_file import find_model
from slipfold.cli.options import Csv, Friction, Json, ModelName, Out, Sets, States
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import (
    parse_assignments,
    parse_points,
    parse_states,
    parse_whole,
    parse_window,
    refuse_varied,
)

Vary = Annotated[
    list[str],
    typer.Option(
        "--vary",
        metavar="NAME=FIRST:LAST",
        help="A parameter and its ends; give two. Sweeps go along the second.",
    ),
]
Points = Annotated[str, typer.Option(metavar="N1xN2", help="Values of each parameter.")]
Transient = Annotated[
    str,
    typer.Option(metavar="N", help="Forcing periods after which is seen whether a motion repeats."),
]


def regimes(
    model: ModelName,
    vary: Vary,
    points: Points = "60x50",
    transient: Transient = "400",
    set_: Sets = None,
    friction: Friction = None,
    state: States = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
) -> int:
    """Map where motions repeat and how soon, where they are tori, chaotic, or stick.

    Exit status: 0 done, 2 bad input, 130 interrupted; what was known by then is kept.
    """
    from slipfold.computations.regimes import regimes as compute

    outputs = Outputs(json, out, csv).checked()
    given = parse_assignments(set_)
    chosen = find_model(model, given, friction)
    names, spans = parse_window(vary, chosen, "a map of regimes")
    refuse_varied(given, names)
    found = carry_out(
        lambda observer: compute(
            chosen,
            dict(zip(names, spans, strict=True)),
            points=parse_points(points),
            state=parse_states(state, chosen),
            transient=parse_whole(transient, "--transient"),
            observer=observer,
        ),
        outputs,
    )
    return outputs.status(found.interrupted)
