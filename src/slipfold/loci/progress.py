"""What a computation of loci reports of the locus that it follows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from slipfold.progress import Progress


@dataclass(frozen=True)
class LocusLine:
    """The part of a locus that is being followed: from its start in one direction."""

    number: int  # number of the line, from 0
    type: str  # type of the locus, as of `Locus`
    period: int  # period of its orbits
    start: tuple[float, float]  # values of the two parameters at its first point


def locus_progress(
    stage: str,
    done: int,
    total: int | None,
    place: tuple[float, float],
    text: str,
    **values: Any,
) -> Progress:
    """Return the state of a computation of loci at values of the two parameters."""
    return Progress(stage, done, total, text, {"place": place, **values})
