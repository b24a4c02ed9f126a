"""What a computation of loci tells while it runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slipfold.loci.locus import Locus


@dataclass(frozen=True)
class LocusLine:
    """The part of a locus that is being followed: from its start in one direction."""

    number: int  # number of the line, from 0
    type: str  # type of the locus, as of `Locus`
    period: int  # period of its orbits
    start: tuple[float, float]  # values of the two parameters at its first point


@dataclass(frozen=True)
class LocusProgress:
    """Where a computation stands.

    Parameters
    ----------
    stage
        ``"responses"``, ``"loci"``, ``"normal forms"`` along them, ``"regions"``,
        ``"regimes"`` of motions in them, or ``"checks"``.
    done
        How many of them are finished.
    total
        How many there will be; None while that is not known.
    values
        Values of the two parameters where it is at work.
    text
        What it is at, e.g. ``"PD of period 1, 12 points, GPD"``.
    line
        What is followed, of which `values` is the last point; None where nothing is.
    loci
        The loci of a bifurcation set, told once, when all are followed and regions remain.
    """

    stage: str
    done: int
    total: int | None
    values: tuple[float, float]
    text: str
    line: LocusLine | None = None
    loci: tuple[Locus, ...] = ()


LocusObserver = Callable[[LocusProgress], None]
"""Called after every point and response, and at each normal form and check; may raise
`KeyboardInterrupt` to stop with what is done."""
