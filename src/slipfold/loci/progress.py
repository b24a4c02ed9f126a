"""What a computation of loci tells while it runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["LocusObserver", "LocusProgress"]


@dataclass(frozen=True)
class LocusProgress:
    """Where a computation stands.

    Parameters
    ----------
    stage
        ``"responses"``, ``"loci"`` or ``"regions"``.
    done
        How many of them are finished.
    total
        How many there will be; None while that is not known.
    values
        Values of the two parameters where it is at work.
    text
        What it is at, e.g. ``"PD of period 1, 12 points, GPD"``.
    """

    stage: str
    done: int
    total: int | None
    values: tuple[float, float]
    text: str


LocusObserver = Callable[[LocusProgress], None]
"""Called after every point or response; may raise `KeyboardInterrupt` to stop with what is done."""
