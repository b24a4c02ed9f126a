"""slipfold beside other programs: time, memory and error, measured in one run.

    python bench/run.py [PART ...] [--rounds N] [--cases 512] [--write FILE.md] [--docs]

Parts are named below; without any, all are measured, which takes a quarter of an hour of a quiet
machine with two cores. Every program runs in its own process, one after the other, round after
round, so that all of them see the same machine; figures are medians. A program that is not
installed, fails, or does not end within its budget is named with the reason and left out. The
report is Markdown, on standard output; `--write` keeps it, `--docs` renews the tables in
docs/reference/benchmarks.md.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from statistics import median
from typing import Any

import contenders
import processes
from measured import Measured, Records
from processes import Absent, Usage

PAGE = processes.BENCH.parent / "docs" / "reference" / "benchmarks.md"

STUDY_CASES = 512
"""Responses of the study where no number is requested."""

WHOLE_STUDY = 2000
"""Responses of the study that the aims are about, for which memory is measured to 100,000 cases."""

CLOCKS = ("seconds", "solver_seconds", "processor_seconds")

GROUPS: dict[str, contenders.Contenders] = {
    "responses": contenders.RESPONSES,
    "locus": contenders.LOCUS,
    "thresholds": contenders.THRESHOLDS,
    "ensemble": contenders.ENSEMBLE,
    **contenders.SYSTEMS,
    "stick": contenders.STICK,
    "batch": contenders.BATCH,
    **contenders.CYCLES,
    "size": contenders.SIZE,
    "structures": contenders.STRUCTURES,
    "after-the-hopf": contenders.AFTER_THE_HOPF,
    "latency": contenders.LATENCY,
}
"""Parts in which programs take turns."""

COMPILED_ANEW = ("thresholds", "size", "structures")
"""Parts that begin with an empty cache, so that compiling is seen."""

PARTS = (*GROUPS, "study", "commands", "paper")


class Failed(Exception):
    """slipfold did not do its part of a comparison."""


def note(sentence: str) -> None:
    """Say how far it is, where that is not part of the report."""
    print(sentence, file=sys.stderr, flush=True)


def merge(record: dict[str, Any], other: dict[str, Any]) -> None:
    """Add the times of another round to a record."""
    for clock in CLOCKS:
        for task, seconds in other.get(clock, {}).items():
            record[clock][task] += seconds
    times = record.get("solver_seconds", record.get("seconds"))
    for task in record.get("seconds_per_point", {}):
        record["seconds_per_point"][task] = median(times[task]) / record["points"][task]


def collect(records: Records, name: str, answer: dict[str, Any]) -> None:
    """Keep a record, or add its times to those kept."""
    if name in records:
        merge(records[name], answer)
    else:
        records[name] = answer


def compete(
    rounds: int,
    group: Mapping[str, tuple[str, ...]],
    budget: float = contenders.BUDGET,
    **environment: str,
) -> tuple[Records, dict[str, str]]:
    """Let all programs work in turn; return their records, and why others did not work."""
    records: Records = {}
    absent: dict[str, str] = {}
    for number in range(1, rounds + 1):
        for name, (script, *arguments) in group.items():
            if name in absent:
                continue
            note(f"round {number} of {rounds}: {name}, {script}")
            seconds = processes.TIMEOUT if name == "slipfold" else budget
            answer = processes.ask(script, *arguments, seconds=seconds, **environment)
            if not isinstance(answer, Absent):
                collect(records, name, answer)
            elif name == "slipfold":
                raise Failed(f"{script} did not run: {answer.reason}")
            else:
                absent[name] = answer.reason
    return records, absent


def compared(part: str, rounds: int | None) -> tuple[Records, dict[str, str]]:
    """What programs did in a part, and why some did not."""
    times = rounds or contenders.ROUNDS.get(part, 1)
    budget = contenders.BUDGETS.get(part, contenders.BUDGET)
    # The threads of linear algebra are those a user has where one response is timed.
    environment = {} if part == "responses" else dict(processes.ONE_THREAD)
    if part not in COMPILED_ANEW:
        return compete(times, GROUPS[part], budget, **environment)
    with tempfile.TemporaryDirectory() as folder:
        return compete(times, GROUPS[part], budget, SLIPFOLD_CACHE_DIR=folder, **environment)


def study(cases: int, responses: Records) -> dict[str, Any]:
    """The record of a study, beside what AUTO's engine takes for one of its cases."""
    few = () if cases >= WHOLE_STUDY else ("--largest", str(max(10 * cases, 100)))
    contender = {"slipfold": (contenders.STUDY, "--cases", str(cases), *few)}
    record = compete(1, contender, **processes.ONE_THREAD)[0]["slipfold"]
    peers = [times for name, times in responses.items() if name.startswith("AUTO-07p")]
    each = [
        sum(median(times["solver_seconds"][task]) for task in ("period1", "period2"))
        for times in peers
        if "solver_seconds" in times
    ]
    return {**record, "auto": min(each, default=None)}


def repeated(rounds: int, name: str, work: Callable[[Path], Usage]) -> list[Usage]:
    """Measure a command with empty caches."""
    usages = []
    for number in range(1, rounds + 1):
        note(f"{name}, {number} of {rounds}")
        with tempfile.TemporaryDirectory() as folder:
            usages.append(work(Path(folder)))
    return usages


def commands(rounds: int) -> dict[str, list[Usage]]:
    """The force response as a command, with empty caches and with filled ones."""
    first = repeated(rounds, "first process ever", processes.response_process)
    with tempfile.TemporaryDirectory() as folder:
        processes.response_process(Path(folder))
        cached = [processes.response_process(Path(folder)) for _ in range(rounds)]
    return {"first": first, "cached": cached}


def measure(parts: Collection[str], rounds: int | None, cases: int = STUDY_CASES) -> Measured:
    """Measure the parts that are requested; one that fails leaves the others."""
    records: dict[str, Records] = {}
    usages: dict[str, list[Usage]] = {}
    absent: dict[tuple[str, str], str] = {}
    failed: dict[str, str] = {}
    for part in (part for part in PARTS if part in parts):
        try:
            if part in GROUPS:
                records[part], missing = compared(part, rounds)
                absent |= {(part, name): why for name, why in missing.items()}
            elif part == "study":
                records[part] = {"slipfold": study(cases, records.get("responses", {}))}
            elif part == "commands":
                usages |= commands(rounds or contenders.ROUNDS[part])
            else:
                usages["paper"] = repeated(1, "the paper, cold", processes.paper_process)
        except (Failed, RuntimeError) as error:
            failed[part] = str(error)
            note(f"slipfold failed, {part}: {error}")
    return Measured(records, usages, absent, failed)


def main() -> int:
    """Measure and report; return 1 if slipfold failed anywhere."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "parts", nargs="*", metavar="PART", help=f"some of {', '.join(PARTS)}; all if none is named"
    )
    parser.add_argument("--rounds", type=int, help="rounds (default 3 of what takes seconds, or 1)")
    parser.add_argument(
        "--cases", type=int, default=STUDY_CASES, help=f"of the study (default {STUDY_CASES})"
    )
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the report to a file too")
    parser.add_argument("--docs", action="store_true", help=f"renew the tables in {PAGE.name}")
    options = parser.parse_args()
    unknown = [part for part in options.parts if part not in (*PARTS, "all")]
    if unknown:
        parser.error(f"there is no part {', '.join(unknown)}; there are {', '.join(PARTS)}")
    everything = not options.parts or "all" in options.parts
    if options.docs and not everything:
        parser.error(f"the tables in {PAGE.name} are renewed as a whole: name no part with --docs")
    measured = measure(PARTS if everything else options.parts, options.rounds, options.cases)
    # Imported late: a process inherits the memory of the one that starts it as its least.
    from report import brief, renew, report

    text = report(measured)
    print(text)
    if options.write:
        options.write.write_text(text + "\n")
    if options.docs:
        PAGE.write_text(renew(PAGE.read_text(), brief(measured)))
    return 1 if measured.failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
