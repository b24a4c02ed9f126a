"""``slipfold lyapunov``: how fast nearby motions part, and what that makes of a motion."""

from __future__ import annotations

from typing import Annotated

import typer

from slipfold.cli.carry_out import carry_out
from slipfold.cli.case_file import find_model
from slipfold.cli.options import Csv, Friction, Json, ModelName, Out, Sets, States
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import parse_assignments, parse_number, parse_states, parse_whole_if_given

Periods = Annotated[
    str | None,
    typer.Option(
        metavar="N",
        help="Forcing periods to follow, of an autonomous model intervals of its duration; by "
        "default as many as it takes, 128,000 at most.",
    ),
]
Tolerance = Annotated[
    str,
    typer.Option(metavar="R", help="Error of the exponents, per period, at which it ends."),
]


def lyapunov(
    model: ModelName,
    periods: Periods = None,
    set_: Sets = None,
    friction: Friction = None,
    state: States = None,
    tolerance: Tolerance = "1e-8",
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
) -> int:
    """Tell periodic, quasi-periodic and chaotic motions apart by their Lyapunov exponents.

    Exit status: 0 done, 2 bad input, 130 interrupted; what was known by then is kept.
    """
    from slipfold.computations.lyapunov import lyapunov as compute

    outputs = Outputs(json, out, csv).checked()
    chosen = find_model(model, parse_assignments(set_), friction)
    start = parse_states(state, chosen)
    found = carry_out(
        lambda observer: compute(
            chosen,
            parse_whole_if_given(periods, "--periods"),
            start,
            tolerance=parse_number(tolerance, "--tolerance"),
            observer=observer,
        ),
        outputs,
    )
    return outputs.status(found.interrupted)
