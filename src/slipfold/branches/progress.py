"""What a running continuation tells whoever watches it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["Observer", "Progress"]


@dataclass(frozen=True)
class Progress:
    """State of a running continuation.

    Parameters
    ----------
    branch
        Id of the branch being followed.
    period
        Its period in forcing periods.
    points
        Points on it so far.
    parameter
        Value of the parameter at the last point.
    special
        Names of the special points found so far on it, e.g. ``("PD",)``.
    """

    branch: int
    period: int
    points: int
    parameter: float
    special: tuple[str, ...]


Observer = Callable[[Progress], None]
"""Called after every point; may raise `KeyboardInterrupt` to stop with what is done."""
