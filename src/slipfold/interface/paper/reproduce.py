"""The paper reproduced, and its planes mapped: all computed, drawn, tabulated and judged."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Annotated, Any

from slipfold.errors import InputError
from slipfold.interface.paper.cases import Case, Cases, Figure, read_cases
from slipfold.interface.paper.claims import Claim, Findings, claims_markdown, judge_claims
from slipfold.interface.paper.tables import planes_markdown, thresholds_csv
from slipfold.progress import Observer, Progress
from slipfold.read_only import Documented
from slipfold.studies.executors import open_executor
from slipfold.text import listed
from slipfold.writing import check_writable, write_file

WITH_TORI = {2, 3}
"""Figures that get the tori that the paper leaves out, on request."""

ROOM = 16_000_000
"""Bytes that the files may need; twice what they do."""

Task = tuple[Any, Callable[..., Any], tuple[Any, ...]]
"""What a function computes, the function, and its arguments."""


@dataclass(frozen=True)
class Reproduction(Documented):
    """The files written, and the results missing."""

    out: Annotated[Path, "The folder."]
    written: Annotated[tuple[Path, ...], "Files, in the order in which they were written."]
    claims: Annotated[tuple[Claim, ...], "The paper's claims, judged."]
    stopped: Annotated[
        tuple[str, ...],
        "A sentence for each branch or locus that could not be followed to its end.",
    ] = ()
    missing: Annotated[
        tuple[str, ...], "Names of what was not finished; empty unless interrupted."
    ] = ()

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended it early."""
        return bool(self.missing)

    @property
    def message(self) -> str:
        """A sentence that says what there is."""
        if not self.interrupted:
            confirmed = sum(claim.verdict is True for claim in self.claims)
            return (
                f"{len(self.written)} files are in {self.out}; "
                f"{confirmed} of {len(self.claims)} claims are confirmed"
            )
        return (
            f"interrupted: {len(self.written)} files with what was finished are in {self.out}; "
            f"missing: {', '.join(self.missing)}"
        )


def reproduce(
    out: str | Path,
    on_progress: Observer | None = None,
    *,
    processes: int = 1,
    cases: Cases | None = None,
    tori: bool = False,
    long_term: bool = False,
) -> Reproduction:
    """Compute and draw what the source paper shows, and judge what it claims.

    Writes ``figure2.pdf`` ... ``figure7.png``, ``thresholds.csv``, ``claims.md``, beyond the paper
    ``bifurcation_set_*.pdf`` and ``.png`` with ``bifurcation_sets.md``, and all that was computed,
    ``data/*.nc``. With `tori` figures 2 and 3 have them, too, and with `long_term`, which adds
    figures of the long-term behavior: ``figure2_completed``, ``figure3_completed``,
    ``hysteresis`` and ``regimes_f_Nd``. Ctrl-C ends it and keeps what is finished.
    """
    if processes < 1:
        raise InputError(f"processes = {processes} is less than 1; give at least 1")
    folder = _prepare(Path(out))
    run = _Run(folder, cases or read_cases(long_term=long_term), on_progress)
    with_tori = WITH_TORI if tori or long_term else set[int]()
    with open_executor(None if processes == 1 else processes) as opened:
        try:
            tasks: Iterable[Task] = (
                (case, _compute, (case, bool(with_tori & {*run.cases.shown_in(case)})))
                for case in run.cases.needs
            )
            for case, result in _finished(opened.executor, processes, tasks):
                run.take_result(case, *result)
            tasks = ((figure, _render, run.drawing(figure)) for figure in run.complete())
            for figure, files in _finished(opened.executor, processes, tasks):
                run.take_figure(figure, files)
        except KeyboardInterrupt:
            for figure in run.complete():
                run.take_figure(figure, _render(*run.drawing(figure)), report=False)
    return run.conclude()


def _prepare(folder: Path) -> Path:
    """Make the folders, and make sure that they can take the files."""
    try:
        (folder / "data").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        why = (error.strerror or str(error)).lower()
        raise InputError(
            f"the folder {folder} cannot be made ({why}); give another one with --out"
        ) from error
    for place in (folder, folder / "data"):
        check_writable(place / "thresholds.csv")
    # A full disk shows only when something is written.
    trial = folder / ".room"
    try:
        write_file(trial, bytes(ROOM))
    finally:
        trial.unlink(missing_ok=True)
    return folder


def _finished(
    executor: Executor, processes: int, tasks: Iterable[Task]
) -> Iterator[tuple[Any, Any]]:
    """Yield the result of each task as it ends; no more of them wait than there are processes."""
    waiting, running = iter(tasks), dict[Future[Any], Any]()
    while True:
        for name, function, arguments in islice(waiting, processes - len(running)):
            running[executor.submit(function, *arguments)] = name
        if not running:
            return
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            yield running.pop(future), future.result()


def _compute(case: Case, tori: bool) -> tuple[Any, bytes | None]:
    """Return a result and its file, which a spectrum has not; may run in a process of its own."""
    result = case.compute(tori=tori)
    if case.kind == "spectrum":
        return result, None
    if result.interrupted:
        raise KeyboardInterrupt
    return result, result._table().to_netcdf()


def _render(figure: Figure, result: Mapping[Case, Any]) -> dict[str, bytes]:
    """Draw a figure; Matplotlib is imported by those who draw, after the first results."""
    from slipfold.interface.paper.drawing import render

    return render(figure, result)


class _Run:
    """One reproduction while it runs: its results and files."""

    def __init__(self, folder: Path, cases: Cases, on_progress: Observer | None) -> None:
        self.folder, self.cases, self.on_progress = folder, cases, on_progress
        self.results: dict[Case, Any] = {}
        self.drawn: list[Figure] = []
        self.written: list[Path] = []

    def take_result(self, case: Case, result: Any, content: bytes | None) -> None:
        """Save a result."""
        if content is not None:
            self.write(f"data/{case.key}.nc", content)
        self.results[case] = result
        special = [point.type for _, point in getattr(result, "special", ())]
        self.report(f"{case.key}  found: {listed(special)}" if special else case.key, case.key)

    def take_figure(self, figure: Figure, files: dict[str, bytes], *, report: bool = True) -> None:
        """Save a figure."""
        for name, content in files.items():
            self.write(name, content)
        self.drawn.append(figure)
        if report:
            self.report(figure.key, figure.key)

    def report(self, text: str, name: str) -> None:
        """Report the progress."""
        if self.on_progress is not None:
            done = len(self.results) + len(self.drawn)
            total = len(self.cases.needs) + len(self.cases.figures)
            self.on_progress(Progress("results", done, total, text, {"name": name}))

    def write(self, name: str, content: bytes) -> None:
        """Write a file."""
        write_file(self.folder / name, content)
        self.written.append(self.folder / name)

    def complete(self) -> list[Figure]:
        """Return the figures that can be drawn and are not yet."""
        return [
            figure
            for figure in self.cases.figures
            if self.results.keys() >= set(figure.needs) and figure not in self.drawn
        ]

    def drawing(self, figure: Figure) -> tuple[Any, ...]:
        """Return the arguments that draw a figure."""
        return figure, {case: self.results[case] for case in figure.needs}

    def conclude(self) -> Reproduction:
        """Tabulate and judge."""
        claims = judge_claims(Findings(self.cases, self.results))
        self.write("thresholds.csv", thresholds_csv(self.cases, self.results).encode())
        self.write("claims.md", claims_markdown(claims).encode())
        if planes := self.cases.of_kind("plane"):
            self.write("bifurcation_sets.md", planes_markdown(planes, self.results).encode())
        missing = [case.key for case in self.cases.needs if case not in self.results]
        missing += [figure.key for figure in self.cases.figures if figure not in self.drawn]
        stopped = sorted(
            sentence for case, result in self.results.items() for sentence in _early(case, result)
        )
        return Reproduction(
            self.folder, tuple(self.written), claims, tuple(stopped), tuple(missing)
        )


def _early(case: Case, result: Any) -> Iterator[str]:
    """Yield a sentence for each branch, locus and torus that stopped early."""
    for what, name in {"branches": "branch", "tori": "tori", "loci": "locus"}.items():
        for curve in getattr(result, what, ()):
            ends = (curve.stopped,) if what == "tori" else curve.ends
            reasons = [end.reason for end in ends if end.early]
            yield from (f"{case.key}, {name} {curve.id}: {reason}" for reason in reasons)
