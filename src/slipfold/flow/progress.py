"""What a running simulation tells whoever watches it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class MotionProgress(NamedTuple):
    """State of a simulation.

    Parameters
    ----------
    stage
        ``"motion"``, then ``"checks"``.
    periods
        Forcing periods that are integrated; of an autonomous model intervals.
    total
        How many there will be; None while that is not known.
    time
        Seconds of the motion so far.
    """

    stage: str
    periods: int
    total: int | None
    time: float


MotionObserver = Callable[[MotionProgress], None]
"""Called every few periods; may raise `KeyboardInterrupt` to stop with what is done."""
