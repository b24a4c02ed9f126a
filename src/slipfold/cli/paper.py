"""``slipfold paper``: the source paper's figures, thresholds and claims, and sets beyond it."""

from __future__ import annotations

from typing import Annotated

import typer

from slipfold.cli.parsing import parse_whole
from slipfold.cli.progress import live_line
from slipfold.cli.status import DONE, FAILED, INTERRUPTED, note, say
from slipfold.threads import cores

Folder = Annotated[
    str, typer.Option("--out", metavar="DIR", help="Folder to write to; made if there is none.")
]
Processes = Annotated[
    str | None,
    typer.Option(metavar="N", help="Processes to compute with; one a processor by default."),
]
Tori = Annotated[
    bool,
    typer.Option("--tori", help="Follow the tori, too, and draw them in figures 2 and 3."),
]
Motions = Annotated[
    bool,
    typer.Option(
        "--motions",
        help="Draw what motions do, too: tori in figures 2 and 3 as with --tori, both completed "
        "with chaos, hysteresis with its basins, regimes over the bifurcation set; some ten "
        "minutes more.",
    ),
]


def paper(
    out: Folder = "paper-output",
    processes: Processes = None,
    tori: Tori = False,
    motions: Motions = False,
) -> int:
    """Compute and draw the source paper's figures, thresholds and claims, and bifurcation sets.

    Ctrl-C keeps what is finished. Exit status: 0 done, 2 bad input, 3 a branch could not be
    followed to its end, 130 interrupted.
    """
    from slipfold.paper.reproduce import reproduce

    with live_line() as show:
        made = reproduce(
            out,
            observer=lambda progress: show(str(progress)),
            processes=cores() if processes is None else parse_whole(processes, "--processes"),
            tori=tori,
            motions=motions,
        )
    if made.interrupted:
        note(made.message)
        return INTERRUPTED
    say(made.message)
    for sentence in made.stopped:
        note(f"stopped early: {sentence}")
    return FAILED if made.stopped else DONE
