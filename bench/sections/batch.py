"""Many motions at once in the report: forcing periods a second and core, and errors."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import Any

from slipfold.interface.paper.tables import table
from wording import magnitude, multiple, verdict

RATE = 500_000
"""Forcing periods a second and core."""

FASTER = 5


def runs(records: dict[str, dict[str, Any]]) -> Iterator[tuple[str, float, float]]:
    """Name, periods a second of processor time, and largest error of the last displacements."""
    exact = records["slipfold"]["final_state"]["reference"]
    for who, record in records.items():
        for task, times in record["processor_seconds"].items():
            ends = record["final_state"][task]
            error = max(abs(end - wanted) for end, wanted in zip(ends, exact, strict=True))
            name = who if who == "slipfold" else f"{who} {task}"
            yield name, record["points"][task] / median(times), error


def section(records: dict[str, dict[str, Any]]) -> list[str]:
    """The part of the report, its heading first."""
    (_, ours, _), *_ = runs(records)
    settings = records["slipfold"]["settings"]
    rows = [
        [name, f"{rate:,.0f}", f"{ours / rate:.2g}", magnitude(error)]
        for name, rate, error in runs(records)
    ]
    return [
        "## Many motions at once",
        f"{settings['motions']} motions of the sliding oscillator for {settings['periods']} "
        "forcing periods each, f = 12.5 Hz, Nd = 0.05 N; one core, processor time. Errors are the "
        "largest of the last x/L and y/L of eight, against Taylor steps at 1e-15. slipfold at its "
        "default tolerance, limits watched; pynamicalsys (numba) with rk45 at 1e-9 and rk4 with "
        "200 steps a period, no limits, its samples interpolated linearly; SciPy's DOP853 at 1e-9, "
        "its right-hand side in Python.",
        table(["", "periods a second", "ratio", "error"], rows),
    ]


def aim_rows(records: dict[str, dict[str, Any]]) -> Iterator[list[str]]:
    """Every aim beside what was measured."""
    (_, ours, _), *others = runs(records)
    yield [
        f"{RATE:,} forcing periods a second and core in batch",
        f"{ours:,.0f}",
        verdict(ours >= RATE),
    ]
    if others:
        name, rate, _ = max(others, key=lambda run: run[1])
        yield [
            f"{FASTER} times the fastest peer in batch",
            f"{ours / rate:.2g} times ({name})",
            verdict(ours / rate >= FASTER),
        ]


def brief(records: dict[str, dict[str, Any]]) -> Iterator[list[str]]:
    """The row for the benchmarks page."""
    (_, ours, error), *others = runs(records)
    shown = [
        f"{name} {rate:,.0f} ({multiple(ours / rate)} times, {magnitude(theirs)})"
        for name, rate, theirs in others
    ]
    yield [
        "many motions at once, periods a second and core (error)",
        f"{ours:,.0f} ({magnitude(error)})",
        "; ".join(shown),
    ]
