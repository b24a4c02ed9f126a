"""Stick and slip in the report: simulated periods a second, and errors."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import Any

from peers.stick import FREQUENCY, FRICTION, state_after
from slipfold.interface.paper.tables import table
from wording import multiple, verdict

FASTER = 50


def runs(records: dict[str, dict[str, Any]]) -> Iterator[tuple[str, float, float]]:
    """Name, periods a second of processor time, and error of the last displacement."""
    for who, record in records.items():
        periods = record["settings"]["periods"]
        for task, times in record["processor_seconds"].items():
            name = who if len(record["processor_seconds"]) == 1 else f"{who} {task}"
            error = abs(record["final_state"][task][0] - state_after(periods)[0])
            yield name, periods / median(times), error


def section(records: dict[str, dict[str, Any]]) -> list[str]:
    """The part of the report, its heading first."""
    (_, ours, _), *_ = runs(records)
    rows = [
        [name, f"{rate:.3g}", f"{ours / rate:.2g}", f"{error:.0e}"]
        for name, rate, error in runs(records)
    ]
    return [
        "## Stick and slip",
        f"Den Hartog's oscillator, W = {FREQUENCY:g}, S = {FRICTION:g}, from rest: two stops a "
        "period. Errors are of the last displacement, against the closed form between events. "
        "slipfold at its own tolerance, with works, heats and intervals; SciPy at the rtol named; "
        "solve-nivp, of second order, at rtol 1e-4.",
        table(["", "periods a second", "ratio", "error"], rows),
    ]


def aim_rows(records: dict[str, dict[str, Any]]) -> Iterator[list[str]]:
    """Every aim beside what was measured."""
    (_, ours, _), *others = runs(records)
    for name, rate, _ in others:
        yield [
            f"{FASTER} times faster in stick and slip than {name}",
            f"{ours / rate:.2g} times",
            verdict(ours / rate >= FASTER),
        ]


def brief(records: dict[str, dict[str, Any]]) -> Iterator[list[str]]:
    """The row for the benchmarks page."""
    (_, ours, error), *others = runs(records)
    shown = []
    for name, rate, theirs in sorted(others, key=lambda run: -run[1]):
        if not any(name.split()[0] in other for other in shown):  # the fastest of each program
            shown.append(f"{name} {rate:.3g} ({multiple(ours / rate)} times, {theirs:.0e})")
    yield [
        "stick and slip, periods a second (error)",
        f"{ours:,.0f} ({error:.0e})",
        "; ".join(shown),
    ]
