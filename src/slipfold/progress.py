"""The state of a computation, as it is reported to the caller."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Progress:
    """State of a computation.

    Parameters
    ----------
    stage
        What is computed, e.g. ``"branches"``, ``"loci"``, ``"periods"``, ``"checks"``.
    done, total
        How much of it is finished, and how much there will be; None while that is not known.
    text
        Where the computation is, e.g. ``"branch 1 (period 1)  12 points  Nd = 0.1 N"``.
    values
        The same as data, by name: of branches ``branch``, ``period``, ``points``, ``parameter`` and
        ``special``, before gaps are filled and before checks ``branches``; of loci ``place``,
        ``line`` and ``loci``; of many cases ``failures``.

    Examples
    --------
    >>> print(Progress("starts", 12, 256, "found: period 1"))
    starts: 12 of 256 done  found: period 1
    """

    stage: str
    done: int
    total: int | None = None
    text: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        total = "" if self.total is None else f" of {self.total}"
        return f"{self.stage}: {self.done}{total} done  {self.text}".rstrip()


Observer = Callable[[Progress], None]
"""Receives the state of a computation; it may raise `KeyboardInterrupt` to stop it."""


def duration_text(seconds: float) -> str:
    """Return a duration in words.

    >>> duration_text(42.3), duration_text(4020)
    ('42 s', '1 h 07 min')
    """
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 1:
        return f"{rest} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {rest:02} s"
