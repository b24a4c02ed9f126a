"""``slipfold basins``: which attractor each start on a plane of states leads to."""

from __future__ import annotations

from typing import Annotated

import typer

from slipfold.cli.carry_out import carry_out
from slipfold.cli.case_file import find_model
from slipfold.cli.options import Csv, Friction, Json, ModelName, Out, SearchPeriods, Sets, States
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import (
    parse_assignments,
    parse_box,
    parse_points,
    parse_states,
    parse_whole_if_given,
)

Plane = Annotated[
    list[str],
    typer.Option(
        "--plane",
        metavar="NAME=LEAST:LARGEST",
        help="A state and its values at phase zero; give two, the first goes to the right. One may "
        "be phase=0:1, in forcing periods, at which starts are released.",
    ),
]
Points = Annotated[
    str, typer.Option(metavar="N|NxM", help="Starts along both states, or along each: 300x200.")
]


def basins(
    model: ModelName,
    plane: Plane,
    points: Points = "200",
    state: States = None,
    periods: SearchPeriods = None,
    set_: Sets = None,
    friction: Friction = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
) -> int:
    """Tell which response, cycle, equilibrium, torus or chaos wins from where.

    Draw the result with slipfold plot. Exit status: 0 done, 2 bad input, 130 interrupted; what was
    found by then is kept.
    """
    from slipfold.computations.basins import basins as compute

    outputs = Outputs(json, out, csv).checked()
    chosen = find_model(model, parse_assignments(set_), friction)
    found = carry_out(
        lambda observer: compute(
            chosen,
            parse_box(plane, "--plane") or {},
            parse_states(state, chosen),
            points=parse_points(points),
            periods=parse_whole_if_given(periods, "--periods"),
            observer=observer,
        ),
        outputs,
    )
    return outputs.status(found.interrupted)
