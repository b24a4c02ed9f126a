"""``slipfold sweep``: motions at many values of a parameter, once a forcing period."""

from __future__ import annotations

from typing import Annotated

import typer

from slipfold.cli.carry_out import carry_out
from slipfold.cli.case_file import find_varied
from slipfold.cli.options import (
    Box,
    Csv,
    Friction,
    Json,
    ModelName,
    Out,
    PointsOfOne,
    Seed,
    Sets,
    States,
    VaryOne,
)
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import (
    parse_box,
    parse_states,
    parse_whole,
)
from slipfold.errors import InputError

RUNS = {"both": ("up", "down"), "up": ("up",), "down": ("down",), "none": ()}

Runs = Annotated[
    str,
    typer.Option(
        metavar="|".join(RUNS),
        help="Sweeps, in which each value begins with the last state of the one before.",
    ),
]
Starts = Annotated[
    str, typer.Option(metavar="N", help="Motions that begin anew at each value, from a box.")
]
Transient = Annotated[str, typer.Option(metavar="N", help="Forcing periods left out first.")]
Periods = Annotated[str, typer.Option(metavar="N", help="Forcing periods kept after them.")]


def sweep(
    model: ModelName,
    vary: VaryOne,
    points: PointsOfOne = "200",
    runs: Runs = "both",
    starts: Starts = "8",
    box: Box = None,
    seed: Seed = "0",
    transient: Transient = "500",
    periods: Periods = "64",
    set_: Sets = None,
    friction: Friction = None,
    state: States = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
) -> int:
    """Sweep a parameter up and down, and start anew at each value; keep a state each period.

    Exit status: 0 done, 2 bad input, 130 interrupted; what was finished by then is kept.
    """
    from slipfold.computations.sweep import sweep as compute

    outputs = Outputs(json, out, csv).checked()
    chosen, name, span = find_varied(model, vary, set_, friction)
    if runs not in RUNS:
        raise InputError(f"--runs {runs} is unknown; give {', '.join(RUNS)}")
    found = carry_out(
        lambda observer: compute(
            chosen,
            name,
            span,
            points=parse_whole(points, "--points", least=2),
            runs=RUNS[runs],
            starts=parse_whole(starts, "--starts", least=0),
            box=parse_box(box),
            seed=parse_whole(seed, "--seed", least=0),
            state=parse_states(state, chosen),
            transient=parse_whole(transient, "--transient", least=0),
            periods=parse_whole(periods, "--periods", least=2),
            observer=observer,
        ),
        outputs,
    )
    return outputs.status(found.interrupted)
