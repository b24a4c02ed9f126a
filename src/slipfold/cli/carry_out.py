"""One computation on the command line, from its first progress to its files."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from slipfold.cli.interruption import deferred_interrupts
from slipfold.cli.outputs import Outputs
from slipfold.cli.progress import live_line

if TYPE_CHECKING:
    from slipfold.results.result import Result

Progress = TypeVar("Progress")
Found = TypeVar("Found", bound="Result")


def carry_out(
    compute: Callable[[Callable[[Progress], None]], Found],
    words: Callable[[Progress], str],
    outputs: Outputs,
) -> Found:
    """Compute, showing progress in words and stopping at Ctrl-C, and hand over what is found.

    Ctrl-C while it is handed over is too late to stop anything, and loses nothing.
    """
    with deferred_interrupts() as check:
        with live_line() as show:

            def observer(progress: Progress) -> None:
                show(words(progress))
                check()

            found = compute(observer)
        outputs.write(found)
    return found
