"""``slipfold simulate``: a motion over many periods, and what it settles on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from slipfold.cli.carry_out import carry_out
from slipfold.cli.case_file import find_model
from slipfold.cli.options import Friction, Json, ModelName, Out, Sets, States
from slipfold.cli.outputs import Outputs
from slipfold.cli.parsing import parse_assignments, parse_number, parse_states, parse_whole_if_given
from slipfold.cli.status import DONE, FAILED, INTERRUPTED, note

if TYPE_CHECKING:
    from slipfold.results.simulation import Simulation

Periods = Annotated[
    str | None,
    typer.Option(
        metavar="N",
        help="Forcing periods to integrate, 1000 by default; of an autonomous model seconds, or "
        "what --set duration says, by default as long as it takes to settle.",
    ),
]
Tolerance = Annotated[
    str,
    typer.Option(
        metavar="R",
        help="Distance from a periodic response that counts as settled, in scaled states.",
    ),
]


def simulate(
    model: ModelName,
    periods: Periods = None,
    set_: Sets = None,
    friction: Friction = None,
    state: States = None,
    tolerance: Tolerance = "1e-9",
    json: Json = None,
    out: Out = None,
) -> int:
    """Integrate from rest or a given state; say honestly whether the motion has settled.

    Ctrl-C keeps the motion as far as it came. Exit status: 0 done, 2 bad input, 3 the motion became
    singular, 130 interrupted.
    """
    from slipfold.computations.simulate import simulate as compute

    outputs = Outputs(json, out).checked()
    chosen = find_model(model, parse_assignments(set_), friction)
    start = parse_states(state, chosen)
    each = "forcing period" if chosen.forced else "interval"
    count = parse_whole_if_given(periods, "--periods")
    least = parse_number(tolerance, "--tolerance")
    motion = carry_out(
        lambda observer: compute(chosen, count, start, tolerance=least, observer=observer),
        outputs,
    )
    return _conclude(motion, outputs, each)


def _conclude(motion: Simulation, outputs: Outputs, each: str) -> int:
    if motion.interrupted:
        ended = motion.stopped is not None and motion.stopped.kind == "interrupted"
        where = f"after {motion.periods} {each}s" if ended else "before all checks were done"
        note(f"interrupted {where}; {outputs.kept}")
        return INTERRUPTED
    if motion.stopped is None:
        return DONE
    note(f"stopped early: {motion.stopped.reason}")
    return FAILED if motion.stopped.kind in ("singular", "stiff") else DONE
