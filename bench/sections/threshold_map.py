"""The map of thresholds in the report."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import Any

from slipfold.paper.tables import table
from wording import milliseconds, verdict

MILLISECONDS = 1

RUNS = {"cold": "first ever", "warm": "warm"}


def points(record: dict[str, Any]) -> int:
    """Points of the grid."""
    return int(record["size"] ** 2)


def each(record: dict[str, Any], run: str, clock: str = "seconds") -> float:
    """Median time in seconds over the number of points."""
    return median(record[clock][run]) / points(record)


def rows(record: dict[str, Any]) -> Iterator[list[str]]:
    """Times of a first map and of further ones."""
    for run, shown in RUNS.items():
        yield [
            shown,
            f"{median(record['seconds'][run]):.3g}",
            milliseconds(each(record, run)),
            milliseconds(each(record, run, "processor_seconds")),
        ]


def failures(record: dict[str, Any]) -> str:
    """How many points have no threshold, by the reason."""
    counted = [f"{count} {kind}" for kind, count in record["failures"].items()]
    return f"without one: {', '.join(counted)}" if counted else "none failed"


def section(record: dict[str, Any]) -> list[str]:
    """The section of the report."""
    size = record["size"]
    return [
        f"## {points(record):,} thresholds",
        f"Nd at the PD of period 1, f = 12.5 Hz, for {size} values of Vd from 0.3 to 1.2 m/s and "
        f"{size} of alpha from 20 to 80 degrees; many at a time, one thread.",
        table(["", "s", "ms a threshold", "processor ms a threshold"], list(rows(record))),
        f"Thresholds: {record['thresholds']:,}; {failures(record)}. {record['followed']} by the "
        "whole response, the others guessed between neighbours, corrected and checked. The largest "
        f"residual is {record['largest_residual']:.0e}. {record['sample']} picked at random differ "
        f"by at most {record['largest_difference']:.0e} N from the response of each alone, which "
        f"takes {milliseconds(record['response_ms_each'] / 1000)} ms. First ever: no compiled "
        "flows.",
    ]


def aim_rows(record: dict[str, Any]) -> Iterator[list[str]]:
    """The aim beside what was measured."""
    for run, shown in RUNS.items():
        took = each(record, run)
        yield [
            f"under {MILLISECONDS} ms a threshold on one core, {shown}",
            f"{milliseconds(took)} ms",
            verdict(1000 * took < MILLISECONDS),
        ]


def brief(record: dict[str, Any]) -> str:
    """The sentence for README.md."""
    times = ", ".join(f"{milliseconds(each(record, run))} ms {RUNS[run]}" for run in RUNS)
    return (
        f"A map of {points(record):,} thresholds over (Vd, alpha): {times}, each, one thread; "
        f"{failures(record)}; {record['sample']} picked at random differ by at most "
        f"{record['largest_difference']:.0e} N from the response of each alone."
    )
