"""One live line on standard error while something is computed; nothing if that is no terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from slipfold.progress import duration_text

INTERVAL = 5.0
"""Seconds between the lines on a terminal that cannot write a line again."""


@contextmanager
def live_line() -> Iterator[Callable[[str], None]]:
    """Show elapsed time and a text that changes."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if console.is_dumb_terminal:  # rich shows nothing where a line cannot be written again
        yield _new_lines()
        return
    columns = (SpinnerColumn(), TimeElapsedColumn(), TextColumn("{task.description}", markup=False))
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("starting")
        yield lambda text: progress.update(task, description=text)


def _new_lines() -> Callable[[str], None]:
    """Return what prints a text with the elapsed time, now and then."""
    begun, shown = monotonic(), -INTERVAL

    def show(text: str) -> None:
        nonlocal shown
        elapsed = monotonic() - begun
        if elapsed - shown >= INTERVAL:
            shown = elapsed
            print(f"{duration_text(elapsed)}  {text}", file=sys.stderr, flush=True)

    return show
