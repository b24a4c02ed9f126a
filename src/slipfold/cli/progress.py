"""One live line on standard error while something is computed; nothing if that is no terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slipfold.branches.progress import Progress
    from slipfold.flow.progress import MotionProgress
    from slipfold.flow.strobes import StrobeProgress
    from slipfold.loci.progress import LocusProgress
    from slipfold.long_term.exponents import ExponentsProgress
    from slipfold.long_term.search import SearchProgress
    from slipfold.measured.least_squares import FitProgress
    from slipfold.paper.reproduce import PaperProgress
    from slipfold.studies.run import StudyProgress


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


def response_text(vary: str, unit: str = "") -> Callable[[Progress], str]:
    """Return what puts the state of a continuation into words."""
    points: dict[int, int] = {}
    special: dict[int, tuple[str, ...]] = {}
    followed = ""

    def text(progress: Progress) -> str:
        nonlocal followed
        if progress.stage != "branches":
            stage = done_text(progress.stage, progress.done, progress.total)
            return f"{stage}  {followed}"
        points[progress.branch] = progress.points
        special[progress.branch] = progress.special
        found = " ".join(name for names in special.values() for name in names)
        value = f"{vary} = {progress.parameter:.6g} {unit}".rstrip()
        line = f"branch {progress.branch} (period {progress.period})  "
        followed = f"{line}{sum(points.values())} points  {value}  found: {found or 'nothing yet'}"
        return followed

    return text


def locus_text(vary: tuple[str, str], units: tuple[str, str]) -> Callable[[LocusProgress], str]:
    """Return what puts the state of a computation of loci into words."""

    def text(progress: LocusProgress) -> str:
        place = ", ".join(
            f"{name} = {value:.6g} {unit}".rstrip()
            for name, value, unit in zip(vary, progress.values, units, strict=True)
        )
        done = done_text(progress.stage, progress.done, progress.total)
        return f"{done}  {place}  {progress.text}"

    return text


def exponents_text(progress: ExponentsProgress) -> str:
    """Put the state of a computation of Lyapunov exponents into words."""
    known = "  ".join(f"{exponent:.6g}" for exponent in progress.exponents)
    done = done_text("periods", progress.periods, progress.total)
    return f"{done}  exponents a period: {known or 'not yet'}"


def search_text(progress: SearchProgress) -> str:
    """Put the state of a search for attractors into words."""
    done = done_text("starts", progress.done, progress.total)
    found = ", ".join(progress.found) or "nothing yet"
    return f"{done}  {progress.periods} periods  found: {found}"


def fit_text(progress: FitProgress) -> str:
    """Put the state of a fit into words."""
    values = "  ".join(f"{name} = {value:.6g}" for name, value in progress.values.items())
    return f"round {progress.round}  {values}  distance {progress.distance:.3g}"


def strobe_text(progress: StrobeProgress) -> str:
    """Put the state of many motions into words."""
    return done_text("forcing periods", progress.periods, progress.total)


def motion_text(each: str) -> Callable[[MotionProgress], str]:
    """Return what puts the state of a simulation into words, of forcing periods or intervals."""

    def text(progress: MotionProgress) -> str:
        of = "" if progress.total is None else f" of {progress.total}"
        return f"{progress.stage}: {progress.periods}{of} {each}s  {progress.time:.6g} s"

    return text


def done_text(stage: str, done: int, total: int | None = None) -> str:
    """Say how much of a stage is done."""
    return f"{stage}: {done}{'' if total is None else f' of {total}'} done"


def paper_text(progress: PaperProgress) -> str:
    """Put the state of the reproduction of the paper into words."""
    found = f"  found: {', '.join(progress.found)}" if progress.found else ""
    return f"{progress.done} of {progress.total}  {progress.name}{found}"


def study_text(progress: StudyProgress) -> str:
    """Put the state of a study into words."""
    words = [done_text("cases", progress.done, progress.total), f"{progress.failures} failed"]
    if progress.rate is not None and progress.remaining is not None:
        words += [f"{progress.rate:.3g} a second", f"{duration_text(progress.remaining)} to go"]
    return "  ".join(words)


def duration_text(seconds: float) -> str:
    """Say how long something takes.

    >>> duration_text(42.3), duration_text(4020)
    ('42 s', '1 h 07 min')
    """
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 1:
        return f"{rest} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {rest:02} s"
