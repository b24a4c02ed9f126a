"""A computation on the command line, from its first progress to its files and its exit status."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import monotonic
from typing import TYPE_CHECKING, Any, Self

from slipfold.errors import InputError
from slipfold.interface.cli.interruption import deferred_interrupts
from slipfold.progress import Observer, Progress, duration_text

if TYPE_CHECKING:
    from slipfold.results.result import Result

DONE, BAD_INPUT, FAILED, INTERRUPTED = 0, 2, 3, 130

FAILURES = {
    "response": "a branch ended before an end of its own",
    "backbone": "a branch ended before an end of its own",
    "locus": "a locus ended before an end of its own",
    "simulate": "the solution became singular or too stiff",
    "design": "no design was found for a bound",
    "measure": "the solution ended at a limit",
    "paper": "a branch ended before an end of its own",
}
"""What exit status 3 means, by command. A curve ends on its own at the end of its span or window,
at a limit of the model, at an event, where it closes, or at another bifurcation; not where no
solution was found beyond, where its points ran out, or where what was computed is contradictory.
The results up to there are written."""


def exit_statuses(home: str) -> str:
    """Say what the exit statuses of a command mean."""
    failure = FAILURES.get(home.partition(":")[2], "")
    middle = f"3 {failure}, " if failure else ""
    return (
        f"Exit status: 0 done, 2 bad input, {middle}130 interrupted. Ctrl-C keeps what is finished."
    )


INTERVAL = 5.0
"""Seconds between the lines on a terminal that cannot rewrite a line."""


def note(sentence: str) -> None:
    """Print what is not a result, on standard error."""
    first, *excerpt = sentence.split("\n")
    print("slipfold:", "\n".join([" ".join(first.split()), *excerpt]), file=sys.stderr)


def say(text: str) -> None:
    """Print a result on standard output."""
    try:
        print(text)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader has seen enough, which is no failure.
        _discard()
    except OSError as error:
        _discard()
        why = (error.strerror or str(error)).lower()
        raise InputError(
            f"standard output cannot be written ({why}); free some space or send it elsewhere"
        ) from error


def _discard() -> None:
    """Discard what is still to be printed: Python tries again when it exits."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextmanager
def live_line() -> Iterator[Callable[[str], None]]:
    """Show elapsed time and a changing text on a terminal; nothing elsewhere."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if console.is_dumb_terminal:  # rich shows nothing where a line cannot be rewritten
        yield _new_lines()
        return
    columns = (SpinnerColumn(), TimeElapsedColumn(), TextColumn("{task.description}", markup=False))
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("starting")
        yield lambda text: progress.update(task, description=text)


def _new_lines() -> Callable[[str], None]:
    """Return what prints a text with the elapsed time, now and then."""
    started, printed = monotonic(), -INTERVAL

    def show(text: str) -> None:
        nonlocal printed
        elapsed = monotonic() - started
        if elapsed - printed >= INTERVAL:
            printed = elapsed
            print(f"{duration_text(elapsed)}  {text}", file=sys.stderr, flush=True)

    return show


def reporter(show: Callable[[str], None], check: Callable[[], None]) -> Observer:
    """Return what shows progress and stops at Ctrl-C."""

    def report(progress: Progress) -> None:
        show(str(progress))
        if progress.values.get("points") != 0:  # before the first there is nothing to lose
            check()

    return report


@dataclass(frozen=True)
class Outputs:
    """Where a result goes."""

    json: str | None = None  # file for JSON; ``"-"`` is standard output
    out: str | None = None  # file for netCDF
    csv: str | None = None  # file for comma-separated values

    @property
    def stored(self) -> str:
        """Where to find what an interrupted computation had finished."""
        files = [path for path in (self.out, self.csv, self.json) if path not in (None, "-")]
        if not files:
            return "finished results are printed; --out FILE.nc would keep it"
        return f"finished results are in {' and '.join(map(str, files))}"

    def checked(self) -> Self:
        """Return them, made sure before computing that all files can be written."""
        from slipfold.writing import NETCDF, check_writable

        paths = [path for path in (self.out, self.csv) if path is not None]
        if self.json not in (None, "-"):
            paths.append(str(self.json))
        seen: set[str] = set()
        for path in paths:
            check_writable(path, NETCDF if path == self.out else ())
            real = os.path.realpath(path)
            if real in seen and os.path.isfile(real) | (not os.path.exists(real)):
                raise InputError(f"{path} is given for two outputs; give each a file of its own")
            seen.add(real)
        return self

    def status_of(self, compute: Callable[..., Result]) -> int:
        """Compute, write the result and return the exit status.

        Ctrl-C stops the computation at the next point; during writing it has no effect.
        """
        with deferred_interrupts() as check:
            with live_line() as show:
                result = compute(on_progress=reporter(show, check))
                complete = self._completed(result, show, check)
            self.write(result)
        if not complete or getattr(result, "interrupted", False):
            note(
                f"{' '.join(filter(None, ['interrupted', interrupted_at(result)]))}; {self.stored}"
            )
            return INTERRUPTED
        for sentence in stopped_early(result):
            note(sentence)
        return FAILED if failed(result) else DONE

    def _completed(
        self, result: Any, show: Callable[[str], None], check: Callable[[], None]
    ) -> bool:
        """Compute what the tables of a response have beyond its summary; return whether all is."""
        if type(result).__name__ != "Diagram" or (self.out is None and self.csv is None):
            return True
        from slipfold.bifurcations.branches.make_branch import complete_branches

        def report(done: int, total: int) -> None:
            show(str(Progress("extrema and uncertainties", done, total)))
            if not result.interrupted:
                check()

        return complete_branches(result.branches, report)

    def write(self, result: Result) -> None:
        """Write the files; print the summary, or the JSON if that is requested."""
        writers: list[tuple[str | None, Callable[[str], None]]] = [
            (self.out, result.save),
            (self.csv, result.to_csv),
            (self.json, lambda path: write_json(result.to_json(), path)),
        ]
        failures = []
        for path, write in writers:
            if path is not None:
                try:
                    write(path)
                except InputError as error:
                    failures.append(error)
        if self.json != "-":
            say(result.summary())
        for failure in failures[1:]:
            note(str(failure))
        if failures:
            raise failures[0]


def write_json(record: dict[str, Any], path: str) -> None:
    """Write plain data as JSON."""
    from slipfold.writing import write_file

    text = json.dumps(record, indent=2, allow_nan=False)
    if path == "-":
        say(text)
    else:
        write_file(path, text.encode() + b"\n")


# -- how a computation ended -------------------------------------------------------------------


CURVES = {"branches": "branch", "tori": "tori", "loci": "locus"}
"""Attributes of results that hold curves, and what each of them is."""


def interrupted_at(result: Any) -> str:
    """Return how far a computation came before it was interrupted, empty if it does not count."""
    curves = [curve for name in CURVES for curve in getattr(result, name, ())]
    if curves:
        number = f"{len(curves)} curves" if len(curves) > 1 else "1 curve"
        return f"after {sum(map(len, curves))} points on {number}"
    if type(result).__name__ == "Simulation":
        unit = "forcing period" if result.model.forced else "interval"
        return f"after {result.periods} {unit}s"
    return ""


def stopped_early(result: Any) -> Iterator[str]:
    """Yield what stopped before it was complete, or was not followed at all, with the reasons."""
    for name, one in CURVES.items():
        for curve in getattr(result, name, ()):
            early = (end for end in (curve.started, curve.stopped) if end.early)
            yield from (f"{one} {curve.id} stopped early: {end.reason}" for end in early)
    yield from getattr(result, "missing", ())
    if type(result).__name__ == "Simulation" and result.stopped is not None:
        yield f"stopped early: {result.stopped.reason}"


def failed(result: Any) -> bool:
    """Whether something could not be computed to its end."""
    kind = type(result).__name__
    if kind == "Simulation":
        return result.stopped is not None and result.stopped.kind in ("singular", "stiff")
    if kind == "Design":
        return bool(result.reasons.any())
    return kind in ("Diagram", "LocusDiagram") and bool(result.failed)
