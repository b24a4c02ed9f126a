"""Responses with random parameters in the report."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import Any

from slipfold.interface.paper.tables import table
from wording import magnitude, milliseconds, verdict

MILLISECONDS = 20


def each(record: dict[str, Any], clock: str = "seconds") -> float:
    """Median time in seconds of one case."""
    return median(record[clock]["warm"]) / record["cases"]


def section(record: dict[str, Any]) -> list[str]:
    """The section of the report."""
    row = [milliseconds(each(record)), milliseconds(each(record, "processor_seconds"))]
    return [
        f"## {record['cases']} responses with random parameters",
        "Vd from 0.4 to 1.2 m/s, mu from 0.2 to 0.6, alpha from 25 to 70 degrees; Nd from 0 to "
        "0.98 N, all branches and special points with normal forms, in one call, one thread.",
        table(["ms a response", "processor ms a response"], [row]),
        f"{record['failures']} failed; {record['special']} special points, the least certain to "
        f"{magnitude(record['largest_uncertainty'])} N. Of {record['agree']} responses all that "
        "was computed again by collocation agrees.",
    ]


def aim_rows(record: dict[str, Any]) -> Iterator[list[str]]:
    """The aim beside what was measured."""
    took = each(record)
    yield [
        f"{record['cases']} random responses, all special points, each in {MILLISECONDS} ms",
        f"{milliseconds(took)} ms",
        verdict(1000 * took < MILLISECONDS),
    ]


def brief(record: dict[str, Any]) -> Iterator[list[str]]:
    """The row for the benchmarks page."""
    yield [
        f"{record['cases']} responses with random parameters in one call, one core, each",
        f"{milliseconds(each(record))} ms",
        f"{record['special']} special points, {record['failures']} failed",
    ]
