"""What was measured, as Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import machine
import reference
from contenders import CYCLES, SYSTEMS
from sections import (
    after_the_hopf,
    batch,
    cycles,
    ensemble,
    latency,
    locus,
    size,
    stick,
    structures,
    study,
    systems,
    threshold_map,
)
from slipfold.interface.paper.tables import table
from wording import magnitude, milliseconds, multiple, task_seconds, verdict

if TYPE_CHECKING:
    from measured import Measured
    from processes import Usage

BEGIN = "<!-- bench: written by `python bench/run.py --docs` -->"
END = "<!-- /bench -->"

FASTER = {"reliable": 6, "largest": 2.5, "fine": 20}
"""Times as fast as the faster peer, by its settings."""

FIRST_SECONDS, CACHED_SECONDS, PAPER_SECONDS = 2.5, 0.8, 20


def together(record: dict[str, Any]) -> float:
    """Time for the same work everywhere: period 1 to 0.375 N and period 2 to 0.98 N."""
    return task_seconds(record, "period1") + task_seconds(record, "period2")


def megabytes(usages: Sequence[Usage]) -> str:
    """Median memory."""
    return f"{median(usage.memory for usage in usages) / 1e6:.0f} MB"


def seconds(usages: Sequence[Usage]) -> float:
    """Median time."""
    return median(usage.seconds for usage in usages)


def errors_of(record: dict[str, Any]) -> list[float] | None:
    """Errors of PD and both NS in N, None if a point is missing or invented."""
    return reference.special_errors(record["specials"])


def largest_error(record: dict[str, Any]) -> str:
    """Largest error of the three points."""
    errors = errors_of(record)
    return "a point missed or invented" if errors is None else magnitude(max(errors))


def followers(measured: Measured) -> dict[str, dict[str, Any]]:
    """The records of programs that follow branches, slipfold first."""
    records = measured.of("responses")
    return {name: record for name, record in records.items() if record.get("specials")}


def response_rows(measured: Measured) -> Iterator[list[str]]:
    """Times, points and errors."""
    ours = together(measured.ours("responses"))
    for name, record in followers(measured).items():
        errors = errors_of(record)
        shown = ["?"] * 3 if errors is None else [*map(magnitude, errors)]
        yield [
            name,
            milliseconds(task_seconds(record, "period1")),
            milliseconds(task_seconds(record, "period2")),
            milliseconds(together(record)),
            multiple(together(record) / ours),
            f"{record['points']['period1']} + {record['points']['period2']}",
            *shown,
        ]


def simulation_rows(measured: Measured) -> Iterator[list[str]]:
    """Times and errors of 1000 forcing periods."""
    ours = measured.ours("responses")
    runs = [("slipfold", ours, "simulate")]
    if "SciPy" in measured.of("responses"):
        scipy = measured.of("responses")["SciPy"]
        runs += [(f"SciPy {method}", scipy, method) for method in scipy["seconds"]]
    for name, record, task in runs:
        yield [
            name,
            milliseconds(task_seconds(record, task)),
            multiple(task_seconds(record, task) / task_seconds(ours, "simulate")),
            f"{reference.displacement_error(record['final_state'][task]):.0e}",
        ]


COMMANDS = {
    "first": ("`slipfold response`, first ever", FIRST_SECONDS),
    "cached": ("`slipfold response`, flows cached", CACHED_SECONDS),
    "paper": ("`slipfold paper`, first ever", PAPER_SECONDS),
}
"""Commands by what was measured of them: name, and seconds aimed at."""


def process_rows(measured: Measured) -> list[list[str]]:
    """Time and memory of commands."""
    return [
        [name, f"{seconds(usages):.2f} s", megabytes(usages)]
        for what, (name, _) in COMMANDS.items()
        if (usages := measured.usages.get(what))
    ]


def response_aims(measured: Measured) -> Iterator[list[str]]:
    """Aims of the force response, one pair for each of the peers' settings."""
    ours = measured.ours("responses")
    errors = errors_of(ours)
    for settings, faster in FASTER.items():
        rivals = {
            name: record
            for name, record in followers(measured).items()
            if name.endswith(settings) and errors_of(record) is not None
        }
        if not rivals:
            continue
        name = min(rivals, key=lambda name: together(rivals[name]))
        ratio = together(rivals[name]) / together(ours)
        yield [
            f"{faster} times faster than the faster peer, {settings} settings",
            f"{ratio:.2g} times ({name})",
            verdict(ratio >= faster),
        ]
        best = min(max(errors_of(record) or ()) for record in rivals.values())
        yield [
            f"closer to the reference than the closest peer, {settings} settings",
            f"{largest_error(ours)} N against {magnitude(best)} N",
            verdict(errors is not None and max(errors) < best),
        ]


def command_aims(measured: Measured) -> Iterator[list[str]]:
    """Aims of commands."""
    for what, (name, aim) in COMMANDS.items():
        if usages := measured.usages.get(what):
            took = seconds(usages)
            yield [f"{name}, under {aim} s", f"{took:.2f} s", verdict(took < aim)]


def aim_rows(measured: Measured) -> Iterator[list[str]]:
    """Every aim beside what was measured."""
    if measured.of("responses"):
        yield from response_aims(measured)
    yield from command_aims(measured)
    for module, record in parts_of(measured):
        yield from module.aim_rows(record)


def parts_of(measured: Measured) -> list[tuple[Any, Any]]:
    """What was measured besides, with the module that reports it."""
    parts = (
        (locus, measured.of("locus")),
        (threshold_map, measured.of("thresholds")),
        (ensemble, measured.ours("ensemble")),
        (study, measured.ours("study")),
        (size, measured.ours("size")),
        (structures, measured.of("structures")),
        (systems, measured.several(SYSTEMS)),
        (cycles, measured.several(CYCLES)),
        (stick, measured.of("stick")),
        (batch, measured.of("batch")),
        (after_the_hopf, measured.ours("after-the-hopf")),
        (latency, measured.of("latency").get("explorer", {})),
    )
    return [(module, record) for module, record in parts if record]


def left_out(measured: Measured) -> list[str]:
    """A sentence for each reason why programs, or slipfold, did not end."""
    by_reason: dict[str, list[str]] = {}
    for (part, name), why in measured.absent.items():
        by_reason.setdefault(why, []).append(f"{name} ({part})")
    told = [f"Left out, {', '.join(names)}: {why}" for why, names in by_reason.items()]
    return [*told, *(f"slipfold failed ({part}): {why}" for part, why in measured.failed.items())]


def response_section(measured: Measured) -> list[str]:
    """The force response and a simulation in the report."""
    ours = measured.ours("responses")
    return [
        "## The force response at 12.5 Hz",
        "Period 1 from Nd = 0 to 0.375 N with its PD; period 2 from that PD to 0.98 N with two NS. "
        "Errors are distances from the reference in N. Times in ms, warm; AUTO-07p's by its own "
        "clock.",
        table(
            ["", "period 1", "period 2", "both", "ratio", "points", "PD", "NS", "NS"],
            list(response_rows(measured)),
        ),
        "`reliable`: the longest steps with which the peer finds every point whatever its first "
        "step. `largest`: the longest with which it does for one first step, by luck. `fine`: mesh "
        "and tolerances for accuracy. slipfold has its default settings, and its times include "
        "normal forms and uncertainties.",
        f"slipfold's period 1 on to where the model ends, {ours['reached']['limit']:.7g} N: "
        f"{milliseconds(task_seconds(ours, 'limit'))} ms; both branches in one call: "
        f"{milliseconds(task_seconds(ours, 'both'))} ms.",
        "## 1000 forcing periods from rest, f = 12.5 Hz, Nd = 0.1 N",
        table(["", "ms", "ratio", "error of x/L, y/L"], list(simulation_rows(measured))),
        "SciPy at rtol 1e-10 and atol 1e-12, its right-hand side in plain Python.",
    ]


def command_section(measured: Measured) -> list[str]:
    """Commands in the report."""
    rows = process_rows(measured)
    heading = ["## Commands", table(["", "time", "largest process"], rows)] if rows else []
    return [*heading, *["First ever: no compiled flows, no font list."] * bool(rows)]


def report(measured: Measured) -> str:
    """The whole report."""
    parts = [
        "# slipfold beside other programs",
        f"Measured with {machine.description()}. Times are medians; the programs took turns.",
        *left_out(measured),
        *(response_section(measured) if measured.of("responses") else []),
        *(line for module, record in parts_of(measured) for line in module.section(record)),
        *command_section(measured),
        "## Aims",
        table(["aim", "measured", ""], list(aim_rows(measured))),
    ]
    return "\n\n".join(parts)


def response_brief(measured: Measured) -> list[str]:
    """The tables of the force response and the simulation for docs/reference/benchmarks.md."""
    ours = together(measured.ours("responses"))
    rows = [
        [
            name,
            f"{milliseconds(together(record))} ms",
            multiple(together(record) / ours),
            f"{largest_error(record)} N",
        ]
        for name, record in followers(measured).items()
    ]
    runs = [
        [name, f"{time} ms", ratio, error] for name, time, ratio, error in simulation_rows(measured)
    ]
    return [
        table(["force response", "time", "ratio", "largest error"], rows),
        table(["1000 periods from rest", "time", "ratio", "error of x/L, y/L"], runs),
    ]


BESIDES = (threshold_map, ensemble, study, stick, batch, after_the_hopf, size, latency)
"""What has a row or two in the last table of docs/reference/benchmarks.md."""


def brief(measured: Measured) -> str:
    """The tables for docs/reference/benchmarks.md, as far as there is something in them."""
    parts = dict(parts_of(measured))
    branches = [row for module in (systems, cycles) for row in module.brief(parts.get(module, {}))]
    besides = [row for module in BESIDES if module in parts for row in module.brief(parts[module])]
    commands = [[name, time, memory] for name, time, memory in process_rows(measured)]
    heads = ["whole branches", "slipfold", "fastest other program that finds every point"]
    return "\n\n".join(
        [
            *(response_brief(measured) if measured.of("responses") else []),
            *([locus.brief(measured.of("locus"))] if measured.of("locus") else []),
            table([*heads, "largest error", "its error"], branches),
            *(structures.tables(measured.of("structures")) if measured.of("structures") else []),
            table(["besides", "slipfold", "beside it"], [*besides, *commands]),
            *left_out(measured),
            f"On {machine.description()}. Times are medians of one run.",
        ]
    )


def renew(text: str, block: str) -> str:
    """Replace what stands between the marks."""
    before, _, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not end:
        raise SystemExit(f"docs/reference/benchmarks.md lacks the marks {BEGIN} and {END}")
    return f"{before}{BEGIN}\n\n{block}\n\n{END}{after}"
