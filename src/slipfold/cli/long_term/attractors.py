"""``slipfold attractors``: everything that motions from a box of starts settle on."""

from __future__ import annotations

from slipfold.cli.carry_out import carry_out
from slipfold.cli.case_file import find_model
from slipfold.cli.options import (
    Box,
    Csv,
    Friction,
    Json,
    ModelName,
    Out,
    SearchPeriods,
    Seed,
    Sets,
    Starts,
)
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import parse_assignments, parse_box, parse_whole, parse_whole_if_given


def attractors(
    model: ModelName,
    box: Box = None,
    starts: Starts = "256",
    seed: Seed = "0",
    periods: SearchPeriods = None,
    set_: Sets = None,
    friction: Friction = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
) -> int:
    """Find all responses, cycles, equilibria, tori and chaos that a box of starts leads to.

    Exit status: 0 done, 2 bad input, 130 interrupted; what was found by then is kept.
    """
    from slipfold.computations.attractors import attractors as compute

    outputs = Outputs(json, out, csv).checked()
    chosen = find_model(model, parse_assignments(set_), friction)
    found = carry_out(
        lambda observer: compute(
            chosen,
            parse_box(box),
            starts=parse_whole(starts, "--starts"),
            seed=parse_whole(seed, "--seed", least=0),
            periods=parse_whole_if_given(periods, "--periods"),
            observer=observer,
        ),
        outputs,
    )
    return outputs.status(found.interrupted)
