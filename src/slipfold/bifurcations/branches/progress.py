"""What a continuation of branches reports."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from slipfold.models.quantities import Parameter
from slipfold.progress import Observer, Progress
from slipfold.text import parameter_text

SEARCHING = "periods before the first orbit"
"""Stage of a computation that has no orbit yet."""


def branch_progress(
    parameter: Parameter,
    branch: int,
    period: int,
    points: int,
    value: float,
    special: tuple[str, ...],
    stage: str = "branches",
    done: int = 0,
    total: int | None = None,
) -> Progress:
    """Return the state of a computation at a point of a branch.

    >>> print(branch_progress(Parameter("Nd", 0.0, "N", "force"), 2, 2, 14, 0.3, ("PD", "NS")))
    branches: 0 done  branch 2 (period 2)  14 points  Nd = 0.3 N  found: PD NS
    """
    at = parameter_text(parameter, value)
    found = " ".join(special) or "nothing yet"
    text = f"branch {branch} (period {period})  {points} points  {at}  found: {found}"
    values: dict[str, Any] = {"branch": branch, "period": period, "points": points}
    values |= {"parameter": value, "special": special}
    return Progress(stage, done, total, text, values)


def searching(observer: Observer | None, value: float) -> Callable[[int], None]:
    """Return what reports how many periods have led to no first orbit yet."""

    def report(periods: int) -> None:
        if observer is not None:
            values = {"branch": 1, "period": 1, "points": 0, "parameter": value, "special": ()}
            observer(Progress(SEARCHING, periods, values=values))

    return report
