"""The command line put together."""

from __future__ import annotations

from typing import Annotated

import typer

from slipfold.cli.commands import Commands
from slipfold.cli.explore import explore
from slipfold.cli.locus import locus
from slipfold.cli.lyapunov import lyapunov
from slipfold.cli.models import models
from slipfold.cli.paper import paper
from slipfold.cli.plot import plot
from slipfold.cli.response import response
from slipfold.cli.simulate import simulate
from slipfold.cli.status import say

__all__ = ["app"]

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


for command in (response, locus, simulate, lyapunov, paper, models, plot, explore):
    app.command()(command)
