"""The group of all commands: whatever goes wrong becomes one sentence and an exit status."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from slipfold.cli.status import BAD_INPUT, DONE, INTERRUPTED, note
from slipfold.errors import InputError

__all__ = ["Commands"]

# The base of typer's own errors about arguments; where it lives depends on the version of typer.
UsageError: Any = typer.BadParameter.__mro__[1]


class Commands(TyperGroup):
    """Commands with errors as sentences; a defect of the program still shows its traceback."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        **extra: Any,
    ) -> NoReturn:
        """Run and exit.

        Parameters
        ----------
        args
            Arguments; those of the process if None.
        prog_name
            Name of the program in messages.
        **extra
            As `typer.core.TyperGroup.main`.
        """
        extra["standalone_mode"] = False
        try:
            status = super().main(args, prog_name, **extra)
            sys.stdout.flush()
        except InputError as error:
            status = _fail(str(error))
        except UsageError as error:
            status = _fail(_usage_sentence(error, prog_name or "slipfold"))
        except KeyboardInterrupt:
            note("interrupted; nothing was written")
            status = INTERRUPTED
        except BrokenPipeError:
            # The reader has seen enough. Python flushes once more at exit: into nothing.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            status = DONE
        except OSError as error:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            why = (error.strerror or str(error)).lower()
            status = _fail(f"standard output cannot be written ({why}); send it elsewhere")
        sys.exit(status if isinstance(status, int) else DONE)

    def invoke(self, ctx: Any) -> Any:
        """Run the command.

        Parameters
        ----------
        ctx
            Context of typer.
        """
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:  # typer would exit without a word
            note("interrupted; nothing was written")
            raise typer.Exit(INTERRUPTED) from None


def _fail(sentence: str) -> int:
    note(sentence)
    return BAD_INPUT


def _usage_sentence(error: Any, program: str) -> str:
    message = " ".join(error.format_message().split()).rstrip(".?")
    context = getattr(error, "ctx", None)
    command = context.command_path if context is not None else program
    return f"{message}; see {command} --help"
