"""Studies in the report."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from slipfold.interface.paper.tables import table
from wording import milliseconds, multiple, verdict

SCALING = 1.8
RATIO = 100
FLAT = 1.2
"""Memory of the most cases over that of the fewest."""

AT_WORK = {"computing": "while it computes", "saving": "while it saves"}


def scaling(record: dict[str, Any]) -> float:
    """How many times faster several processes are than one."""
    return record["one"] / record["several"]


def growth(record: dict[str, Any], work: str) -> float:
    """How many times more memory the most cases take than the fewest."""
    return record["memory"][-1][work] / record["memory"][0][work]


def section(record: dict[str, Any]) -> list[str]:
    """The section of the report."""
    cases, processes = record["cases"], record["processes"]
    rate = cases / record["seconds"]
    rows = [
        [
            f"{item['cases']:,}",
            *(f"{item[key] / 1e6:.0f} MB" for key in AT_WORK),
            *(f"{item[key] / item['cases']:.0f}" for key in ("store", "file")),
        ]
        for item in record["memory"]
    ]
    heads = ["cases", "memory, computing", "and saving", "bytes a case, store", "netCDF"]
    return [
        f"## A study of {cases:,} force responses",
        "Vd from 0.4 to 1.2 m/s, mu from 0.2 to 0.6, alpha from 25 to 70 degrees; Nd from 0 to "
        "0.98 N, all branches and special points, each case kept on disk.",
        f"{rate:.3g} cases a second on {processes} processes, {milliseconds(1 / rate)} ms a case; "
        f"{record['special']:,} special points, {record['failures']} cases failed. "
        f"{record['few']} of them in one process: {record['one']:.3g} s, in {processes}: "
        f"{record['several']:.3g} s, begun before.",
        *cluster_lines(record["cluster"]),
        "Motions of one period, for what a case costs besides its computation:",
        table(heads, rows),
    ]


def cluster_lines(found: dict[str, Any] | None) -> list[str]:
    """What a cluster adds."""
    if found is None:
        return ["Dask is not installed, so no cluster was measured."]
    share = found["cluster"] / found["processes"] - 1
    return [
        f"{found['cases']:,} motions of one period: {found['processes']:.3g} s in processes, "
        f"{found['cluster']:.3g} s on a Dask cluster of as many ({100 * share:+.0f} %); its "
        f"scheduler takes {found['tasks']:.0f} tasks a second."
    ]


def aim_rows(record: dict[str, Any]) -> Iterator[list[str]]:
    """The aims beside what was measured."""
    yield [
        f"a study {SCALING} times faster in two processes than in one",
        f"{scaling(record):.2f}",
        verdict(scaling(record) >= SCALING),
    ]
    if record["auto"] is not None:
        ratio = record["auto"] * record["cases"] / record["seconds"]
        yield [
            f"a case {RATIO} times faster than AUTO-07p's engine in a loop, on two cores",
            f"{ratio:.2g}",
            verdict(ratio >= RATIO),
        ]
    for work, when in AT_WORK.items() if len(record["memory"]) > 1 else ():
        yield [
            f"memory of a study flat in the number of cases {when} (less than {FLAT} times)",
            f"{growth(record, work):.2f}",
            verdict(growth(record, work) < FLAT),
        ]


def brief(record: dict[str, Any]) -> Iterator[list[str]]:
    """The row for the benchmarks page."""
    rate, auto = record["cases"] / record["seconds"], record["auto"]
    beside = f"{record['failures']} failed"
    if auto is not None:
        beside += f"; {multiple(auto * rate)} times AUTO-07p's engine in a loop at its fastest"
    yield [
        f"a study of {record['cases']:,} force responses on {record['processes']} cores, each",
        f"{milliseconds(1 / rate)} ms",
        beside,
    ]
