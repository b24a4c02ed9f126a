"""``slipfold design``: parameters chosen so that a threshold lies where it is wanted."""

from __future__ import annotations

from typing import Annotated

import typer

from slipfold.cli.case_file import find_varied
from slipfold.cli.design_space.threshold import Period, Type, Vary, carry_out_on_response
from slipfold.cli.options import Csv, Friction, Json, ModelName, Out, Sets
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import parse_assignments, parse_whole, parse_whole_if_given
from slipfold.errors import InputError

Chosen = Annotated[
    list[str],
    typer.Option(
        "--choose",
        metavar="NAME=LEAST:LARGEST",
        help="Parameter to choose, within bounds, e.g. alpha=50deg:70deg. Repeatable.",
    ),
]
Load = Annotated[
    str, typer.Option(metavar="VALUE", help="Where the vibration is measured, below the threshold.")
]
Above = Annotated[
    list[str] | None,
    typer.Option(metavar="VALUE", help="What the threshold is to exceed. Repeatable: a curve."),
]
Outside = Annotated[
    str | None,
    typer.Option(metavar="FROM:TO", help="A window that the threshold is to leave."),
]
Kept = Annotated[
    list[str] | None,
    typer.Option(
        "--keep",
        metavar="TYPE:PERIOD=VALUE",
        help="A further threshold on the way and what it is to stay above, e.g. PD:1=40mN. "
        "Repeatable.",
    ),
]
State = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="State that is to vibrate least; by default the first."),
]


def design(
    model: ModelName,
    vary: Vary,
    choose: Chosen,
    load: Load,
    above: Above = None,
    outside: Outside = None,
    keep: Kept = None,
    state: State = None,
    type_: Type = None,
    period: Period = None,
    set_: Sets = None,
    friction: Friction = None,
    json: Json = None,
    out: Out = None,
    csv: Csv = None,
) -> int:
    """Choose parameters so that a threshold lies where it is wanted, at the least vibration.

    Exit status: 0 done, 2 bad input, 3 nothing found, 130 interrupted; what was known is kept.
    """
    from slipfold.cli.special_points import first_point
    from slipfold.computations.design import design as compute

    outputs = Outputs(json, out, csv).checked()
    of = find_varied(model, vary, set_, friction)
    bounds = {
        each: _pair(text, f"--choose {each}")
        for each, text in parse_assignments(choose, "--choose").items()
    }
    others = {
        each: (*_type_and_period(each), least)
        for each, least in parse_assignments(keep, "--keep").items()
    }
    window = None if outside is None else _pair(outside, "--outside")
    rounds = parse_whole_if_given(period, "--period")
    found = carry_out_on_response(
        of,
        lambda diagram, observer: compute(
            first_point(diagram, type_, rounds),
            bounds,
            load=load,
            above=above or None,
            outside=window,
            keep={
                each: (first_point(diagram, kind, turns), least)
                for each, (kind, turns, least) in others.items()
            },
            state=state,
            observer=observer,
        ),
        outputs,
    )
    return outputs.status(found.interrupted, bool(found.reasons.any()))


def _pair(text: str, option: str) -> tuple[str, str]:
    least, colon, most = text.partition(":")
    if not colon:
        raise InputError(f"{option}={text} has no two ends; give LEAST:LARGEST")
    return least, most


def _type_and_period(text: str) -> tuple[str, int]:
    kind, colon, period = text.partition(":")
    if not colon:
        raise InputError(f"--keep {text} has no period; give TYPE:PERIOD=VALUE, e.g. PD:1=40mN")
    return kind, parse_whole(period, f"--keep {kind}:")
