"""The map of thresholds in the report."""

from __future__ import annotations

import math
from collections.abc import Iterator
from statistics import median
from typing import Any

from slipfold.interface.paper.tables import table
from wording import magnitude, milliseconds, multiple, verdict

MILLISECONDS = 0.3
LOOP = 250
"""Times as fast as the other program in a loop."""

Records = dict[str, dict[str, Any]]

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


def loop_rows(records: Records) -> Iterator[tuple[str, float, int, int, float]]:
    """Other programs: name, seconds a point, points, how many have their threshold, error."""
    ours = records["slipfold"]["picked"]
    for name, record in records.items():
        if name != "slipfold":
            found = [value for _, value in record["specials"]["each"]]
            pairs = zip(found, ours, strict=False)
            distances = [abs(value - exact) for value, exact in pairs if value == value]
            took = median(record["solver_seconds"]["each"])
            yield name, took, len(found), len(distances), max(distances, default=math.nan)


def section(records: Records) -> list[str]:
    """The section of the report."""
    record = records["slipfold"]
    size, ours = record["size"], each(record, "warm", "processor_seconds")
    loops = [
        f"{name} in a loop over {count} of them: {milliseconds(took)} ms each by its own clock "
        f"(median), {multiple(took / ours)} times as long as slipfold's processor time; {right} "
        f"found, at most {magnitude(error)} N apart."
        for name, took, count, right, error in loop_rows(records)
    ]
    return [
        f"## {points(record):,} thresholds",
        f"Nd at the PD of period 1, f = 12.5 Hz, for {size} values of Vd from 0.3 to 1.2 m/s and "
        f"{size} of alpha from 20 to 80 degrees; many at a time, one thread.",
        table(["", "s", "ms a threshold", "processor ms a threshold"], list(rows(record))),
        f"Thresholds: {record['thresholds']:,}; {failures(record)}. {record['followed']} by the "
        "whole response, the others guessed between neighbors, corrected and checked. The largest "
        f"residual is {record['largest_residual']:.0e}. {record['sample']} picked at random differ "
        f"by at most {record['largest_difference']:.0e} N from the response of each alone, which "
        f"takes {milliseconds(record['response_ms_each'] / 1000)} ms. First ever: no compiled "
        "flows.",
        *loops,
    ]


def aim_rows(records: Records) -> Iterator[list[str]]:
    """The aims beside what was measured."""
    record = records["slipfold"]
    for run, shown in RUNS.items():
        took = each(record, run)
        yield [
            f"under {MILLISECONDS} ms a threshold on one core, {shown}",
            f"{milliseconds(took)} ms",
            verdict(1000 * took < MILLISECONDS),
        ]
    for name, took, *_ in loop_rows(records):
        ratio = took / each(record, "warm", "processor_seconds")
        yield [
            f"a threshold {LOOP} times faster than {name} in a loop",
            f"{multiple(ratio)} times",
            verdict(ratio >= LOOP),
        ]


def brief(records: Records) -> Iterator[list[str]]:
    """The row for the benchmarks page."""
    record = records["slipfold"]
    ours = each(record, "warm", "processor_seconds")
    loops = [
        f"{name} in a loop over {count}: {milliseconds(took)} ms ({multiple(took / ours)} times), "
        f"{right} found, {magnitude(error)} N off"
        for name, took, count, right, error in loop_rows(records)
    ]
    yield [
        f"a map of {points(record):,} PD thresholds over (Vd, alpha), one core, each",
        ", ".join(f"{milliseconds(each(record, run))} ms {RUNS[run]}" for run in RUNS),
        "; ".join(
            [
                f"{failures(record)}; {record['sample']} picked at random are at most "
                f"{record['largest_difference']:.0e} N off each response alone",
                *loops,
            ]
        ),
    ]
