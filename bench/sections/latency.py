"""The explorer's sliders in the report."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import Any

from slipfold.interface.paper.tables import table
from wording import verdict

MILLISECONDS = 50


def section(record: dict[str, Any]) -> list[str]:
    """The part of the report, its heading first."""
    first, followed = sorted(record["seconds"]["first"]), record["seconds"]["followed"]
    row = [f"{1e3 * median(first):.0f}", f"{1e3 * first[int(0.95 * len(first))]:.0f}",
           f"{1e3 * first[-1]:.0f}", f"{1e3 * median(followed):.0f}"]  # fmt: skip
    return [
        "## From a slider to the curve",
        f"The base case with all special points in headless Chromium, {len(first)} moves of "
        f"{', '.join(record['sliders'])}; {record['moved']} moved from the curve before.",
        table(["median ms", "95th percentile", "longest", "followed after"], [row]),
    ]


def aim_rows(record: dict[str, Any]) -> Iterator[list[str]]:
    """The aim beside what was measured, for the first curve and for the followed one."""
    for which, curve in (("first", "first"), ("followed", "exact")):
        took = 1e3 * median(record["seconds"][which])
        yield [
            f"from a slider to the {curve} curve in {MILLISECONDS} ms",
            f"{took:.0f} ms",
            verdict(took < MILLISECONDS),
        ]


def brief(record: dict[str, Any]) -> Iterator[list[str]]:
    """The row for the benchmarks page."""
    times = {name: f"{1e3 * median(found):.0f} ms" for name, found in record["seconds"].items()}
    yield [
        "from a slider of the explorer to the curve",
        times["first"],
        f"{record['moved']} of {len(record['seconds']['first'])} moved; "
        f"followed after {times['followed']}",
    ]
