"""One computation on the command line, from its first progress to its files."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from slipfold.cli.interruption import deferred_interrupts
from slipfold.cli.outputs import Outputs
from slipfold.cli.progress import live_line
from slipfold.progress import Observer, Progress

if TYPE_CHECKING:
    from slipfold.results.result import Result

AnyResult = TypeVar("AnyResult", bound="Result")


def carry_out(compute: Callable[[Observer], AnyResult], outputs: Outputs) -> AnyResult:
    """Compute, showing progress and stopping at Ctrl-C, and write the result.

    Ctrl-C while it is written is too late to stop anything, and loses nothing.
    """
    with deferred_interrupts() as check:
        with live_line() as show:

            def report(progress: Progress) -> None:
                show(str(progress))
                check()

            result = compute(report)
        outputs.write(result)
    return result
