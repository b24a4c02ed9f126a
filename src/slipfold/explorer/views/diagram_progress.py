"""A response while it is followed: how far it has come."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

from slipfold.explorer.views.numbers import number
from slipfold.progress import Progress

BETWEEN = 0.25
"""Least time between two notes of progress, in s: no reader follows more."""


class DiagramProgress:
    """Tells of a response now and then; an observer of its computation.

    `tell` takes each note: ``progress``, in words, and ``value`` of the parameter at the last
    point.
    """

    def __init__(self, tell: Callable[[dict[str, Any]], None]) -> None:
        self._tell = tell
        self._told = perf_counter()

    def __call__(self, progress: Progress) -> None:
        """Take a note of the computation."""
        if perf_counter() - self._told < BETWEEN:
            return
        self._told = perf_counter()
        values = progress.values
        words = f"branch {values['branch']}, {values['points']} points"
        if progress.stage != "branches":
            words += f", {progress.stage}: {progress.done} done"
        self._tell({"progress": words, "value": number(values["parameter"]), "done": False})
