"""The points of a bifurcation set that get a marker: codimension two, extrema, limits, failures."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from slipfold.loci.locus import CODIMENSION_TWO, Locus
from slipfold.plots.angles import quantity_text
from slipfold.plots.marks import limit_name

SAME = 1e-4
"""Points of one type this near, over the range of each parameter, are one point of two loci."""


@dataclass(frozen=True)
class LocusMark:
    """A marked point."""

    type: str  # ``"GPD"`` and the like, ``"MIN"``, ``"MAX"``, ``"LIMIT"`` or ``"FAILED"``
    name: str  # what stands beside it; empty for nothing
    values: tuple[float, ...]  # where it is


def locus_marks(
    loci: Sequence[Locus],
    window: tuple[tuple[float, float], tuple[float, float]],
    lowest: Collection[str] = (),
) -> tuple[LocusMark, ...]:
    """Return the marks of a bifurcation set, each once, whatever number of loci meets there."""
    found: list[LocusMark] = []
    size = np.ptp(np.array(window), axis=1)
    for mark in (mark for locus in loci for mark in _of_locus(locus, lowest)):
        if not any(
            mark.type == other.type
            and np.all(np.abs(np.subtract(mark.values, other.values)) < SAME * size)
            for other in found
        ):
            found.append(mark)
    return tuple(found)


def _of_locus(locus: Locus, lowest: Collection[str]) -> list[LocusMark]:
    least = _lowest(locus) if locus.type in lowest else None
    marks = []
    for i, point in enumerate(locus.special):
        name = point.type if point.type in CODIMENSION_TWO else ""
        marks.append(LocusMark(point.type, _value(locus, i) if i == least else name, point.values))
    for end in (locus.begun, locus.stopped):
        if end.kind == "limit":
            marks.append(LocusMark("LIMIT", limit_name(locus.model, end.reason), end.values))
        elif end.kind == "failed":
            marks.append(LocusMark("FAILED", "", end.values))
    return marks


def _lowest(locus: Locus) -> int | None:
    """Return which special point is the minimum in the second parameter with the smallest value."""
    minima = [
        i
        for i, point in enumerate(locus.special)
        if point.type == "MIN" and point.name.endswith(f" {locus.vary[1]}")
    ]
    return min(minima, key=lambda i: locus.special[i].values[1], default=None)


def _value(locus: Locus, index: int) -> str:
    """Return e.g. ``"lowest: 0.04008 N at 12.46 Hz"``."""
    first, second = (locus.model.parameter(name) for name in locus.vary)
    values = locus.special[index].values
    return f"lowest: {quantity_text(second, values[1])} at {quantity_text(first, values[0])}"
