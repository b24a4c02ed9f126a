"""What a running continuation tells whoever watches it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

SEARCHING = "periods before the first orbit"
"""Stage of a computation that has no orbit yet."""


@dataclass(frozen=True)
class Progress:
    """State of a computation of branches.

    Parameters
    ----------
    branch
        Id of the branch it is at.
    period
        Its period in forcing periods.
    points
        Points on it so far.
    parameter
        Value of the parameter at the last point.
    special
        Names of the special points found so far on it, e.g. ``("PD",)``.
    stage
        ``"periods before the first orbit"`` while motion leads to that; ``"branches"``; once all
        are followed ``"normal forms"``, ``"orbits"`` while their states at equidistant phases are
        found, ``"gradients"`` if they are asked for, then ``"checks"``.
    done
        How many periods, normal forms, orbits, gradients or checks are finished.
    total
        How many there will be; None while that is not known.
    """

    branch: int
    period: int
    points: int
    parameter: float
    special: tuple[str, ...]
    stage: str = "branches"
    done: int = 0
    total: int | None = None


Observer = Callable[[Progress], None]
"""Called after every point, and at each normal form and check; may raise `KeyboardInterrupt` to
stop with what is done."""


def searching(observer: Observer | None, value: float) -> Callable[[int], None]:
    """Return what tells how many periods of a motion have led to no first orbit yet."""

    def tell(periods: int) -> None:
        if observer is not None:
            observer(Progress(1, 1, 0, value, (), SEARCHING, periods))

    return tell
