"""Figures in the words of the report."""

from __future__ import annotations

from statistics import median
from typing import Any

import reference


def task_seconds(record: dict[str, Any], task: str) -> float:
    """Median time of a task, by the program's own clock where it has one."""
    return median(record.get("solver_seconds", record["seconds"])[task])


def milliseconds(seconds: float) -> str:
    """Three digits."""
    return f"{1000 * seconds:.3g}" if seconds < 1 else f"{1000 * seconds:.0f}"


def magnitude(error: float) -> str:
    """One digit, as far as the reference is known."""
    return f"{error:.0e}" if error >= reference.PRECISION else f"< {reference.PRECISION:.0e}"


def multiple(ratio: float) -> str:
    """Two digits, or whole ones."""
    return f"{ratio:.2g}" if ratio < 100 else f"{ratio:,.0f}"


def verdict(met: bool) -> str:
    """Whether an aim is met."""
    return "met" if met else "falls short"
