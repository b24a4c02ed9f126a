"""Cost by the number of degrees of freedom in the report."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import Any

import numpy as np

from slipfold.interface.paper.tables import table
from wording import milliseconds, verdict

COMPILE_SECONDS = 10
"""What «compile times in seconds» means."""

LARGE = 5
"""Degrees of freedom from which the exponent is fitted: below, what does not grow rules."""


def exponent(record: dict[str, Any]) -> float:
    """Slope of the time of an orbit over the degrees of freedom, both logarithmic."""
    some = [item for item in record["sizes"] if item["size"] >= LARGE]
    sizes = np.log([item["size"] for item in some])
    times = np.log([median(item["seconds"]) for item in some])
    return float(np.polyfit(sizes, times, 1)[0])


def rows(record: dict[str, Any]) -> Iterator[list[str]]:
    """One row for each size."""
    for item in record["sizes"]:
        yield [
            str(item["size"]),
            str(item["states"]),
            f"{item['compile_seconds']:.2g}",
            milliseconds(median(item["seconds"])),
        ]


def beam_rows(record: dict[str, Any]) -> Iterator[list[str]]:
    """One row for each beam."""
    for item in record["beams"]:
        each = item["seconds"] / item["points"]
        yield [
            str(item["elements"]),
            str(4 * item["elements"]),
            str(item["points"]),
            f"{item['compile_seconds']:.2g}",
            f"{item['seconds']:.2g}",
            milliseconds(each),
        ]


def section(record: dict[str, Any]) -> list[str]:
    """The section of the report."""
    heads = ["DOF", "states", "compile s", "orbit ms"]
    return [
        "## Cost by size",
        "A chain of masses with a cubic spring and a friction contact: one period with the "
        "derivatives with respect to the start and one parameter, eight segments side by side, one "
        "thread, processor time.",
        table(heads, list(rows(record))),
        f"From {LARGE} degrees of freedom the time of an orbit grows with the power "
        f"{exponent(record):.2f} of their number.",
        "A beam of finite elements on a belt: the equilibrium, its Hopf point, the whole branch of "
        "cycles with all that is stated of it. The highest mode of 3 elements turns 150 times in a "
        "round of the lowest, that of 15 elements 3,800 times.",
        table(
            ["elements", "states", "points", "compile s", "branch s", "a point, ms"],
            list(beam_rows(record)),
        ),
    ]


def aim_rows(record: dict[str, Any]) -> Iterator[list[str]]:
    """The aim beside what was measured."""
    largest = record["sizes"][-1]
    took = largest["compile_seconds"]
    yield [
        f"{largest['size']} degrees of freedom compile in seconds",
        f"{took:.2g} s",
        verdict(took < COMPILE_SECONDS),
    ]


def brief(record: dict[str, Any]) -> Iterator[list[str]]:
    """The row for the benchmarks page."""
    largest = record["sizes"][-1]
    yield [
        f"a structure of {largest['size']} masses: compiled, then an orbit with derivatives",
        f"{largest['compile_seconds']:.2g} s, {milliseconds(median(largest['seconds']))} ms",
        f"time grows with the power {exponent(record):.1f} of the masses",
    ]
