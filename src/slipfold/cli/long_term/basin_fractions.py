"""``slipfold basin-fractions``: which share of starts each attractor wins along a parameter."""

from __future__ import annotations

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
    SearchPeriods,
    Seed,
    Sets,
    Starts,
    VaryOne,
)
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import (
    parse_box,
    parse_whole,
    parse_whole_if_given,
)


def basin_fractions(
    model: ModelName,
    vary: VaryOne,
    box: Box = None,
    points: PointsOfOne = "20",
    starts: Starts = "256",
    seed: Seed = "0",
    periods: SearchPeriods = None,
    set_: Sets = None,
    friction: Friction = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
) -> int:
    """Tell which share of a box of starts each response, torus or chaos wins along a parameter.

    Draw the result with slipfold plot. Exit status: 0 done, 2 bad input, 130 interrupted; the
    values finished by then are kept.
    """
    from slipfold.computations.basin_fractions import basin_fractions as compute

    outputs = Outputs(json, out, csv).checked()
    chosen, name, span = find_varied(model, vary, set_, friction)
    found = carry_out(
        lambda observer: compute(
            chosen,
            name,
            span,
            parse_box(box),
            points=parse_whole(points, "--points", least=2),
            starts=parse_whole(starts, "--starts"),
            seed=parse_whole(seed, "--seed", least=0),
            periods=parse_whole_if_given(periods, "--periods"),
            observer=observer,
        ),
        outputs,
    )
    return outputs.status(found.interrupted)
