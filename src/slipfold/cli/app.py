"""The command line put together."""

from __future__ import annotations

from typing import Annotated

import typer

from slipfold.cli.commands import Commands
from slipfold.cli.design_space.design import design
from slipfold.cli.design_space.uncertainty import uncertainty
from slipfold.cli.explore import explore
from slipfold.cli.locus import locus
from slipfold.cli.long_term.attractors import attractors
from slipfold.cli.long_term.basin_fractions import basin_fractions
from slipfold.cli.long_term.basins import basins
from slipfold.cli.long_term.lyapunov import lyapunov
from slipfold.cli.long_term.regimes import regimes
from slipfold.cli.long_term.sweep import sweep
from slipfold.cli.measured import fit, measure, plan
from slipfold.cli.models import models
from slipfold.cli.paper import paper
from slipfold.cli.plot import plot
from slipfold.cli.response import response
from slipfold.cli.simulate import simulate
from slipfold.cli.status import say
from slipfold.cli.studies.study import study

app = typer.Typer(
    name="slipfold",
    cls=Commands,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Version = Annotated[bool, typer.Option("--version", help="Show the version and exit.")]


@app.callback(invoke_without_command=True)
def start(context: typer.Context, version: Version = False) -> None:
    """Vibration of sliding structures with friction, and how it loses stability."""
    if version:
        from slipfold.version import package_version

        say(f"slipfold {package_version()}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        say(context.get_help())
        raise typer.Exit


COMMANDS = (
    response,
    locus,
    simulate,
    lyapunov,
    attractors,
    basins,
    basin_fractions,
    sweep,
    regimes,
    study,
    uncertainty,
    design,
    measure,
    fit,
    plan,
    paper,
    models,
    plot,
    explore,
)

for command in COMMANDS:
    app.command()(command)
