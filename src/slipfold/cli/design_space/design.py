"""``slipfold design``: parameters chosen so that a threshold lies where it is wanted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from slipfold.cli.design_space.uncertainty import Period, Type, Vary
from slipfold.cli.options import Csv, Friction, Json, ModelName, Out, Sets
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import parse_assignments, parse_span, parse_whole, refuse_varied
from slipfold.cli.status import DONE, FAILED, INTERRUPTED, note
from slipfold.errors import InputError

if TYPE_CHECKING:
    from slipfold.computations.design import DesignProgress

__all__ = ["design"]

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
    from slipfold.cli.case_file import find_model
    from slipfold.cli.interruption import deferred_interrupts
    from slipfold.cli.progress import done_text, live_line
    from slipfold.cli.special_points import first_point
    from slipfold.computations.design import design as compute
    from slipfold.computations.response import response

    outputs = Outputs(json, out, csv)
    outputs.check()
    given = parse_assignments(set_)
    chosen = find_model(model, given, friction)
    name, span = parse_span(vary, chosen)
    refuse_varied(given, (name,))
    bounds = {
        each: _pair(text, f"--choose {each}")
        for each, text in parse_assignments(choose, "--choose").items()
    }
    others = {
        each: (*_type_and_period(each), least)
        for each, least in parse_assignments(keep, "--keep").items()
    }
    window = None if outside is None else _pair(outside, "--outside")
    rounds = None if period is None else parse_whole(period, "--period")
    with live_line() as show, deferred_interrupts() as check:
        show("response")
        diagram = response(chosen, name, span, observer=lambda progress: check())
        if diagram.interrupted:
            raise KeyboardInterrupt
        point = first_point(diagram, type_, rounds)
        kept = {
            each: (first_point(diagram, kind, turns), least)
            for each, (kind, turns, least) in others.items()
        }

        def observe(progress: DesignProgress) -> None:
            show(done_text("searches", progress.done, progress.total))
            check()

        found = compute(
            point,
            bounds,
            load=load,
            above=above or None,
            outside=window,
            keep=kept,
            state=state,
            observer=observe,
        )
        outputs.write(found)
    if found.interrupted:
        note(f"interrupted; {outputs.kept}")
        return INTERRUPTED
    return FAILED if found.reasons.any() else DONE


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
