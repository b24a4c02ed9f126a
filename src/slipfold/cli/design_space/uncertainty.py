"""``slipfold uncertainty``: a threshold where parameters scatter."""

from __future__ import annotations

from typing import Annotated

import typer

from slipfold.cli.case_file import find_varied
from slipfold.cli.design_space.threshold import Period, Type, Vary, carry_out_on_response
from slipfold.cli.options import Csv, Friction, Json, ModelName, Out, Seed, Sets
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import parse_assignments, parse_whole, parse_whole_if_given

Scatters = Annotated[
    list[str],
    typer.Option(
        "--scatter",
        metavar="NAME=normal:SIZE",
        help="How a parameter scatters: normal (standard deviation), uniform (half the width, or "
        "FROM:TO) or lognormal, e.g. mu=normal:5% or alpha=uniform:58deg:62deg. Repeatable.",
    ),
]
Correlations = Annotated[
    list[str] | None,
    typer.Option(
        "--correlation",
        metavar="NAME,NAME=R",
        help="Correlation of two parameters that scatter, e.g. mu,Vd=0.5. Repeatable.",
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
    correlation: Correlations = None,
    type_: Type = None,
    period: Period = None,
    samples: Samples = "1024",
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
    from slipfold.cli.special_points import first_point
    from slipfold.computations.uncertainty import uncertainty as compute

    outputs = Outputs(json, out, csv).checked()
    of = find_varied(model, vary, set_, friction)
    known = parse_assignments(scatter, "--scatter")
    pairs = parse_assignments(correlation, "--correlation")
    count, start = parse_whole(samples, "--samples"), parse_whole(seed, "--seed", least=0)
    rounds = parse_whole_if_given(period, "--period")
    found = carry_out_on_response(
        of,
        lambda diagram, observer: compute(
            first_point(diagram, type_, rounds),
            known,
            correlation=pairs,
            samples=count,
            seed=start,
            loads=quiet or (),
            indices=indices,
            observer=observer,
        ),
        outputs,
    )
    return outputs.status(found.interrupted)
