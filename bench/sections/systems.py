"""The three systems in the report."""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import Any

from slipfold.interface.paper.tables import table
from systems import SYSTEMS, errors
from wording import magnitude, milliseconds, verdict

FASTER = {"duffing": 2, "vanderpol": 2, "chain": 4}
"""Times as fast as the fastest other program that is right."""

Records = dict[str, dict[str, Any]]


def wall(record: dict[str, Any]) -> float:
    """Median wall time in seconds; AUTO-07p's is that of its process, its start included."""
    return median(record["seconds"]["branch"])


def processor(record: dict[str, Any]) -> float:
    """Median processor time in seconds, by the program's own clock where it has one."""
    clock = record.get("solver_seconds") or record["processor_seconds"]
    return median(clock["branch"])


def error_of(name: str, record: dict[str, Any]) -> float | None:
    """Largest error of the points; None if one is missing or invented."""
    found = errors(name, record["specials"].get("branch", []))
    return None if found is None else max(found)


def rows(name: str, records: Records) -> Iterator[list[str]]:
    """Times, points and errors."""
    ours = processor(records["slipfold"])
    for who, record in records.items():
        error = error_of(name, record)
        yield [
            who,
            str(record["points"]["branch"]),
            milliseconds(wall(record)),
            milliseconds(processor(record)),
            f"{processor(record) / ours:.2g}",
            "a point missed or invented" if error is None else magnitude(error),
        ]


def complete(name: str, records: Records) -> Records:
    """The records of other programs that find every point and invent none."""
    return {
        who: record
        for who, record in records.items()
        if who != "slipfold" and error_of(name, record) is not None
    }


def aim_rows(systems: dict[str, Records]) -> Iterator[list[str]]:
    """Every aim beside what was measured, in processor time."""
    for name, records in systems.items():
        rivals = complete(name, records)
        if not rivals:
            continue
        fastest = min(rivals, key=lambda who: processor(rivals[who]))
        ratio = processor(rivals[fastest]) / processor(records["slipfold"])
        yield [
            f"{SYSTEMS[name].title}: {FASTER[name]} times faster than the fastest",
            f"{ratio:.2g} times ({fastest})",
            verdict(ratio >= FASTER[name]),
        ]


def section(systems: dict[str, Records]) -> list[str]:
    """The part of the report, its heading first."""
    parts = [
        "## Duffing, van der Pol, a chain of ten masses",
        "Branches over the whole span with their bifurcations; errors are distances from the "
        "reference. Times in ms, warm. Processor time is AUTO-07p's own clock, and the ratio is "
        "of it; AUTO-07p's wall time has the start of its process in it. `usual` are the peer's "
        "own defaults for mesh and steps, `large` longer steps on a coarser mesh, `fine` tighter. "
        "slipfold has its default settings, and its times include normal forms and uncertainties. "
        "pyHarm locates no fold: a parabola through three of its points does.",
    ]
    for name, records in systems.items():
        system = SYSTEMS[name]
        points = ", ".join(f"{kind} {value:.10g} {system.unit}" for kind, value in system.specials)
        span = f"{system.parameter} from {system.span[0]:g} to {system.span[1]:g} {system.unit}"
        parts += [
            f"### {system.title}",
            f"{span}; {points}.",
            table(["", "points", "wall", "processor", "ratio", "error"], list(rows(name, records))),
        ]
    return parts


def brief(systems: dict[str, Records]) -> Iterator[list[str]]:
    """Rows for the benchmarks page: slipfold and the fastest that finds every point."""
    for name, records in systems.items():
        ours, rivals = records["slipfold"], complete(name, records)
        fastest = min(rivals, key=lambda who: processor(rivals[who]), default=None)
        theirs = rivals.get(fastest or "")
        yield [
            SYSTEMS[name].title,
            f"{milliseconds(processor(ours))} ms",
            "none" if theirs is None else f"{milliseconds(processor(theirs))} ms ({fastest})",
            magnitude(error_of(name, ours) or 0.0),
            "" if theirs is None else magnitude(error_of(name, theirs) or 0.0),
        ]
