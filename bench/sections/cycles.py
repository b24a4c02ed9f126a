"""The systems that nothing forces, in the report."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from cycles import OSCILLATORS, errors
from sections.systems import processor, wall
from slipfold.interface.paper.tables import table
from wording import milliseconds, verdict

ARRIVED = 1e-5
"""Share of the span from its end within which a branch has come to it."""

Records = dict[str, dict[str, Any]]


def fault(name: str, record: dict[str, Any]) -> str:
    """What is wrong with a branch besides digits; nothing of a branch that is right."""
    first, last = OSCILLATORS[name].span
    reached = record["reached"]["branch"]
    if abs(reached - last) > ARRIVED * (last - first):
        return f"gives up at {reached:.3g}"
    found = record["specials"].get("branch", [])
    if errors(name, found) is None:
        return f"{len(found)} special points instead of {len(OSCILLATORS[name].specials)}"
    return ""


def largest_error(name: str, record: dict[str, Any]) -> float:
    """Largest error of a right branch: of special points, and of the last duration as a share."""
    last = OSCILLATORS[name].last
    of_points = errors(name, record["specials"].get("branch", [])) or []
    return max([abs(record["reached"]["duration"] - last) / last, *of_points])


def rows(name: str, records: Records) -> Iterator[list[str]]:
    """Times, points and errors."""
    ours = processor(records["slipfold"])
    for who, record in records.items():
        yield [
            who,
            str(record["points"]["branch"]),
            milliseconds(wall(record)),
            milliseconds(processor(record)),
            f"{processor(record) / ours:.2g}",
            fault(name, record) or f"{largest_error(name, record):.0e}",
        ]


def right(name: str, records: Records) -> Records:
    """The records of other programs that have the whole branch, nothing missed or invented."""
    return {
        who: record
        for who, record in records.items()
        if who != "slipfold" and not fault(name, record)
    }


def aim_rows(cycles: dict[str, Records]) -> Iterator[list[str]]:
    """Every aim beside what was measured, in processor time."""
    for name, records in cycles.items():
        title, ours = OSCILLATORS[name].title, records["slipfold"]
        yield [f"{title}: nothing missed or invented", fault(name, ours) or "so it is",
               verdict(not fault(name, ours))]  # fmt: skip
        rivals = right(name, records)
        if not rivals:
            aim = f"{title}: no slower than who is right"
            if len(records) > 1:
                yield [aim, "no other is", verdict(True)]
            else:  # why others are left out is said at the beginning of the report
                yield [aim, "no other ran to its end", "not compared"]
            continue
        fastest = min(rivals, key=lambda who: processor(rivals[who]))
        ratio = processor(rivals[fastest]) / processor(ours)
        yield [
            f"{title}: no slower than who is right",
            f"{ratio:.2g} times as fast ({fastest})",
            verdict(ratio >= 1),
        ]


def section(cycles: dict[str, Records]) -> list[str]:
    """The part of the report, its heading first."""
    parts = [
        "## Relaxation, canards and a beam",
        "Branches of cycles over the whole span; the error is the largest of special points and of "
        "the last duration as a share of it. Times in ms, warm. Processor time is AUTO-07p's own "
        "clock, and the ratio is of it. slipfold has its default settings, but for the duration "
        "that is allowed, and its times include the equilibrium's, normal forms, uncertainties and "
        "checks.",
    ]
    for name, records in cycles.items():
        oscillator = OSCILLATORS[name]
        points = ", ".join(f"{kind} {value:.10g}" for kind, value in oscillator.specials)
        first, last = oscillator.span
        parts += [
            f"### {oscillator.title}",
            f"{oscillator.parameter} from {first:g} to {last:g}; {points or 'no special point'}.",
            table(["", "points", "wall", "processor", "ratio", "error"], list(rows(name, records))),
        ]
    return parts


def brief(cycles: dict[str, Records]) -> Iterator[list[str]]:
    """Rows for the benchmarks page: slipfold and the fastest that is right."""
    for name, records in cycles.items():
        ours, rivals = records["slipfold"], right(name, records)
        fastest = min(rivals, key=lambda who: processor(rivals[who]), default=None)
        others = f"none of {len(records) - 1} is right" if len(records) > 1 else "none ends in time"
        theirs = rivals.get(fastest or "")
        yield [
            OSCILLATORS[name].title,
            f"{milliseconds(processor(ours))} ms",
            others if theirs is None else f"{milliseconds(processor(theirs))} ms ({fastest})",
            fault(name, ours) or f"{largest_error(name, ours):.0e}",
            "" if theirs is None else f"{largest_error(name, theirs):.0e}",
        ]
