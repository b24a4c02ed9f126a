"""The paper reproduced, and its planes mapped: all computed, drawn, tabulated and judged."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slipfold.branches.settings import Settings
from slipfold.computations.loci import bifurcation_set
from slipfold.computations.response import response
from slipfold.errors import InputError
from slipfold.flow.simulate import simulate
from slipfold.long_term.spectrum import find_spectrum
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES, CODIMENSION_TWO
from slipfold.paper.cases import (
    AnyFigure,
    Case,
    Cases,
    CurveCase,
    MotionFigure,
    Motions,
    PlaneCase,
    Steady,
    motion_figures,
    read_cases,
)
from slipfold.paper.claims import Claim, Findings, claims_markdown, judge_claims
from slipfold.paper.drawing import render
from slipfold.paper.tables import planes_markdown, thresholds_csv
from slipfold.progress import Observer, Progress
from slipfold.results.diagram import Diagram
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.result import Result
from slipfold.results.writing import check_writable, write_file
from slipfold.studies.executors import open_executor

PERIODS = 1500
"""Forcing periods from rest until the response is taken as steady."""

WITH_TORI = (2, 3)
"""Figures that get the tori that the paper leaves out, on request."""

ROOM = 16_000_000
"""Bytes that the files may need; twice what they do."""


@dataclass(frozen=True)
class Reproduction:
    """The files written, and the results missing.

    Parameters
    ----------
    out
        The folder.
    written
        Files, in the order in which they were written.
    claims
        The paper's claims, judged.
    stopped
        A sentence for each branch or locus that could not be followed to its end.
    missing
        Names of what was not finished; empty unless interrupted.
    """

    out: Path
    written: tuple[Path, ...]
    claims: tuple[Claim, ...]
    stopped: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()

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
    settings: Settings | None = None,
    measure: str = "max",
    tori: bool = False,
    motions: bool = False,
) -> Reproduction:
    """Compute and draw what the source paper shows, and judge what it claims.

    Writes ``figure2.pdf`` ... ``figure7.png``, ``thresholds.csv``, ``claims.md``, beyond the paper
    ``bifurcation_set_*.pdf`` and ``.png`` with ``bifurcation_sets.md``, and all that was computed,
    ``data/*.nc``. With `tori` figures 2 and 3 have them, too, and with `motions`, which adds
    figures of the long-term behavior: ``figure2_completed``, ``figure3_completed``,
    ``hysteresis`` and ``regimes_f_Nd``. Ctrl-C ends it and keeps what is finished.
    """
    if processes < 1:
        raise InputError(f"processes = {processes} is less than 1; give at least 1")
    folder = _prepare(Path(out))
    cases = read_cases() if cases is None else cases
    beyond = motion_figures(cases) if motions else ()
    run = _Run(folder, cases, settings, measure, on_progress, tori or motions, beyond)
    with open_executor(None if processes == 1 else processes) as opened:
        tasks = Tasks(opened.executor, processes)
        try:
            run.compute(tasks)
        except KeyboardInterrupt:
            run.rescue(tasks)
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


class Tasks:
    """Functions that wait for a free process; no more are handed over than processes are free."""

    def __init__(self, executor: Executor, processes: int) -> None:
        self._executor = executor
        self._processes = processes
        self._waiting: list[tuple[Any, Callable[..., Any], tuple[Any, ...]]] = []
        self._running: dict[Future[Any], Any] = {}

    def add(self, name: Any, function: Callable[..., Any], *arguments: Any) -> None:
        """Put a function in the queue."""
        self._waiting.append((name, function, arguments))

    def finished(self) -> Iterator[tuple[Any, Any]]:
        """Yield name and result of each function as it ends, until none is left.

        Functions may be added meanwhile.
        """
        while self._waiting or self._running:
            while self._waiting and len(self._running) < self._processes:
                name, function, arguments = self._waiting.pop(0)
                self._running[self._executor.submit(function, *arguments)] = name
            done, _ = wait(self._running, return_when=FIRST_COMPLETED)
            for future in [item for item in self._running if item in done]:
                yield self._running.pop(future), future.result()

    def stop(self) -> Iterator[tuple[Any, Any]]:
        """Drop waiting functions, and yield name and result of those running until they end."""
        self._waiting.clear()
        yield from self.finished()


class _Run:
    """One reproduction while it runs."""

    def __init__(
        self,
        folder: Path,
        cases: Cases,
        settings: Settings | None,
        measure: str,
        on_progress: Observer | None,
        tori: bool,
        beyond: tuple[MotionFigure, ...] = (),
    ) -> None:
        self.tori = tori
        self.beyond = beyond
        self.folder = folder
        self.cases = cases
        self.settings = settings
        self.measure = measure
        self.on_progress = on_progress
        self.found: dict[Any, Any] = {}  # spectra and results by case
        self.drawn: set[AnyFigure] = set()
        self.queued: set[AnyFigure] = set()
        self.written: list[Path] = []

    def compute(self, tasks: Tasks) -> None:
        """Compute everything; draw each figure as soon as its curves are there."""
        for case in self.needs:
            shown = self.cases.shown_in(case) if isinstance(case, CurveCase) else ()
            tori = self.tori and not set(WITH_TORI).isdisjoint(shown)
            tasks.add(case, _compute, case, self.settings, tori)
        for name, result in tasks.finished():
            self.take(name, result)
            for figure in self.complete():
                if figure not in self.queued:
                    self.queued.add(figure)
                    tasks.add(figure, *self.drawing(figure))

    @property
    def needs(self) -> tuple[Case | Motions, ...]:
        """All that is computed, each once."""
        further = [case for figure in self.beyond for case in figure.needs]
        return tuple(dict.fromkeys([*self.cases.needs, *further]))

    @property
    def figures(self) -> tuple[AnyFigure, ...]:
        """All that are drawn."""
        return (*self.cases.all_figures, *self.beyond)

    def rescue(self, tasks: Tasks) -> None:
        """After Ctrl-C: take the results of running tasks, and draw complete figures."""
        self.on_progress = None
        with suppress(BrokenExecutor):  # a signal to all processes ends those at work
            for name, result in tasks.stop():
                self.take(name, result)
        for figure in self.complete():
            if figure not in self.drawn:
                draw, *arguments = self.drawing(figure)
                self.take(figure, draw(*arguments))

    def take(self, name: Any, result: Any) -> None:
        """Keep and save one result."""
        found: tuple[str, ...] = ()
        if isinstance(name, AnyFigure):
            for file, content in result.items():
                self.write(file, content)
            self.drawn.add(name)
        elif isinstance(name, Steady):
            self.found[name] = result
        else:
            diagram, content = result
            if diagram.interrupted:
                raise KeyboardInterrupt
            self.write(f"data/{name.key}.nc", content)
            self.found[name] = diagram
            found = _found(diagram)
        if self.on_progress is not None:
            done = sum(case in self.found for case in self.needs) + len(self.drawn)
            total = len(self.needs) + len(self.figures)
            text = f"{name.key}  found: {', '.join(found)}" if found else name.key
            self.on_progress(Progress("results", done, total, text, {"name": name.key}))

    def complete(self) -> Iterator[AnyFigure]:
        """Yield the figures for which everything is computed."""
        for figure in self.figures:
            if self.found.keys() >= set(figure.needs):
                yield figure

    def drawing(self, figure: AnyFigure) -> tuple[Any, ...]:
        """Return the function that draws a figure, and its arguments."""
        needed = {case: self.found[case] for case in figure.needs}
        return render, figure, needed, self.measure

    def write(self, name: str, content: bytes) -> None:
        write_file(self.folder / name, content)
        self.written.append(self.folder / name)

    def conclude(self) -> Reproduction:
        """Tabulate and judge."""
        diagrams = self.of_kind(CurveCase)
        claims = judge_claims(Findings(self.cases, diagrams, self.of_kind(Steady)))
        self.write("thresholds.csv", thresholds_csv(self.cases, diagrams).encode())
        self.write("claims.md", claims_markdown(claims).encode())
        if self.cases.planes:
            text = planes_markdown(self.cases.planes, self.of_kind(PlaneCase))
            self.write("bifurcation_sets.md", text.encode())
        missing = [case.key for case in self.needs if case not in self.found]
        missing += [figure.key for figure in self.figures if figure not in self.drawn]
        return Reproduction(
            self.folder, tuple(self.written), claims, tuple(sorted(self.stopped())), tuple(missing)
        )

    def stopped(self) -> Iterator[str]:
        """Yield a sentence for each branch and each locus that was given up."""
        for curve, diagram in self.of_kind(CurveCase).items():
            for branch in diagram.branches:
                reasons = [end.reason for end in branch.ends if end.early]
                yield from (f"{curve.key}, branch {branch.id}: {reason}" for reason in reasons)
            for tori in diagram.tori:
                if tori.stopped.early:
                    yield f"{curve.key}, tori {tori.id}: {tori.stopped.reason}"
        for plane, found in self.of_kind(PlaneCase).items():
            for locus in found.loci:
                for end in (locus.started, locus.stopped):
                    if end.early:
                        yield f"{plane.key}, locus {locus.id}: {end.reason}"

    def of_kind(self, kind: type) -> dict[Any, Any]:
        """Return what was computed for one kind of case."""
        return {case: found for case, found in self.found.items() if isinstance(case, kind)}


def _found(diagram: Result) -> tuple[str, ...]:
    """Return what was found, as progress shows it."""
    if isinstance(diagram, LocusDiagram):
        return tuple(
            f"{point.type} {point.values[0]:.6g} {point.values[1]:.6g}"
            for _, point in diagram.special
            if point.type in CODIMENSION_TWO
        )
    if not isinstance(diagram, Diagram):
        return ()
    return tuple(
        f"{point.type} {point.value:.6g}"
        for _, point in diagram.special
        if point.type in BIFURCATION_TYPES
    )


def _compute(case: Case | Motions, settings: Settings | None, tori: bool) -> Any:
    """Compute one spectrum, or anything else and its file; may run in a process of its own."""
    if isinstance(case, Steady):
        return find_spectrum(simulate(case.model, PERIODS))
    if isinstance(case, PlaneCase):
        found = bifurcation_set(case.model, case.vary, case.window, settings=settings)
        return found, found._table().to_netcdf()
    if not isinstance(case, CurveCase):
        motions = case.compute()
        return motions, motions._table().to_netcdf()
    diagram = response(case.model, case.vary, case.span, settings=settings, tori=tori)
    # The file asks for extrema and uncertainties, which the branches keep: they are computed here
    # rather than in the process that waits, and once for all drawings.
    return diagram, diagram._table().to_netcdf()
