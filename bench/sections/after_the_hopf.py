"""Tori and basins in the report."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import Any

from slipfold.interface.paper.tables import table
from wording import verdict

TORUS_SECONDS = 0.05
PICTURE_SECONDS, PICTURE_POINTS, PICTURE_CORES = 20, 200, 2


def each_torus(record: dict[str, Any]) -> float:
    """Seconds a torus."""
    return median(record["seconds"]["tori"]) / record["tori"]["points"]


def picture(record: dict[str, Any]) -> float:
    """Seconds a picture of basins."""
    return median(record["seconds"]["basins"])


def section(record: dict[str, Any]) -> list[str]:
    """The part of the report, its heading first."""
    tori, basins = record["tori"], record["basins"]
    points, periods = basins["points"], " and ".join(map(str, basins["periods"]))
    rows = [
        [
            f"{tori['points']} tori on {tori['branches']} branches, f = 12.5 Hz, one thread",
            f"{median(record['seconds']['tori']):.2f} s",
            f"{1e3 * each_torus(record):.0f} ms each",
        ],
        [
            f"basins of {points} x {points} starts, f = 12.2 Hz, {basins['cores']} cores",
            f"{picture(record):.2f} s",
            f"periods {periods}",
        ],
    ]
    return ["## Tori and basins", table(["", "time", ""], rows)]


def aim_rows(record: dict[str, Any]) -> Iterator[list[str]]:
    """Every aim beside what was measured; the picture's only where it is the one aimed at."""
    each, basins = each_torus(record), record["basins"]
    yield [
        f"a torus under {1e3 * TORUS_SECONDS:.0f} ms",
        f"{1e3 * each:.0f} ms",
        verdict(each < TORUS_SECONDS),
    ]
    if basins["points"] == PICTURE_POINTS and basins["cores"] <= PICTURE_CORES:
        took = picture(record)
        yield [
            f"basins of {PICTURE_POINTS} x {PICTURE_POINTS} starts under {PICTURE_SECONDS} s on "
            f"{PICTURE_CORES} cores",
            f"{took:.1f} s",
            verdict(took < PICTURE_SECONDS),
        ]


def brief(record: dict[str, Any]) -> Iterator[list[str]]:
    """Rows for the benchmarks page."""
    points = record["basins"]["points"]
    yield ["a torus, with its stability and surface", f"{1e3 * each_torus(record):.0f} ms", ""]
    yield [
        f"which response wins, from {points} x {points} starts",
        f"{picture(record):.1f} s",
        f"{record['basins']['cores']} cores",
    ]
