"""The command-line application: its commands, error messages and exit statuses."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from slipfold.cli import long_term, measured, thresholds
from slipfold.cli.explore import explore
from slipfold.cli.locus import locus
from slipfold.cli.models import models
from slipfold.cli.plot import plot
from slipfold.cli.response import response
from slipfold.cli.running import BAD_INPUT, DONE, INTERRUPTED, note, say
from slipfold.cli.study import paper, study
from slipfold.errors import InputError

# The base of typer's own errors about arguments; where it lives depends on the version of typer.
UsageError: Any = typer.BadParameter.__mro__[1]


class Commands(TyperGroup):
    """Commands with errors as sentences; a defect of the program still shows its traceback."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> NoReturn:
        """Run and exit."""
        try:
            status = super().main(
                args,
                prog_name,
                complete_var,
                standalone_mode=False,
                windows_expand_args=windows_expand_args,
                **extra,
            )
        except InputError as error:
            status = _fail(str(error))
        except UsageError as error:
            status = _fail(_usage_sentence(error, self._asked_for(prog_name, args)))
        except KeyboardInterrupt:
            note("interrupted; nothing was written")
            status = INTERRUPTED
        sys.exit(status if isinstance(status, int) else DONE)

    def _asked_for(self, program: str | None, args: Sequence[str] | None) -> str:
        """Return the program with the requested command, if there is one."""
        given = sys.argv[1:] if args is None else list(args)
        named = [program or "slipfold", *(name for name in given[:1] if name in self.commands)]
        return " ".join(named)

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:  # typer would exit without a word
            note("interrupted; nothing was written")
            raise typer.Exit(INTERRUPTED) from None


def _fail(sentence: str) -> int:
    note(sentence)
    return BAD_INPUT


def _usage_sentence(error: Any, command: str) -> str:
    message = " ".join(error.format_message().split()).rstrip(".?")
    return f"{message}; see {command} --help"


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
    long_term.simulate,
    long_term.lyapunov,
    long_term.attractors,
    long_term.basins,
    long_term.basin_fractions,
    long_term.sweep,
    long_term.regimes,
    study,
    thresholds.uncertainty,
    thresholds.design,
    measured.measure,
    measured.fit,
    measured.plan,
    paper,
    models,
    plot,
    explore,
)

for command in COMMANDS:
    app.command()(command)
