"""A bifurcation set while it is computed: words, and the loci as far as they are followed."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

from slipfold.explorer.views.numbers import short
from slipfold.explorer.views.plane import loci_view
from slipfold.loci.progress import LocusLine
from slipfold.progress import Progress

BETWEEN = 0.1
"""Least time between two notes of progress, in s."""


class PlaneProgress:
    """Tells of a bifurcation set now and then; an observer of its computation.

    `tell` takes each note: ``progress``, a sentence; ``lines``, those that have grown, each with
    all its points so far, by ``number``; and ``loci`` once all are followed.
    """

    def __init__(self, tell: Callable[[dict[str, Any]], None]) -> None:
        self._tell = tell
        self._told = perf_counter()
        self._grown: dict[LocusLine, list[tuple[float, float]]] = {}
        self._last: LocusLine | None = None

    def __call__(self, progress: Progress) -> None:
        """Take a note of the computation."""
        self._grow(progress)
        followed = progress.values.get("loci")
        if perf_counter() - self._told < BETWEEN and not followed:
            return
        self._told = perf_counter()
        total = "" if progress.total is None else f" of {progress.total}"
        sentence = f"{progress.stage}: {progress.done}{total} done, {progress.text}"
        lines = [_line(line, points) for line, points in self._grown.items()]
        loci = {"loci": loci_view(followed)} if followed else {}
        self._tell({"progress": sentence, "lines": lines, **loci, "done": False})
        self._grown = {key: points for key, points in self._grown.items() if key == self._last}

    def _grow(self, progress: Progress) -> None:
        line = self._last = progress.values.get("line")
        if line is not None:
            self._grown.setdefault(line, [line.start]).append(progress.values["place"])


def _line(line: LocusLine, points: list[tuple[float, float]]) -> dict[str, Any]:
    return {
        "number": line.number,
        "type": line.type,
        "period": line.period,
        "x": short([first for first, _ in points]),
        "y": short([second for _, second in points]),
    }
