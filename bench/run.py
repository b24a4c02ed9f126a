"""slipfold beside other programs: time, memory and error, measured in one run.

    python bench/run.py [PART ...] [--rounds 3] [--cases 512] [--write FILE.md] [--readme]

Parts are named below. Without any, those of ten minutes are measured in one round; `all` are all of
them, which takes more than an hour. Every program runs in its own process, one after
the other, round after round, so that all of them
see the same machine; figures are medians. What is not installed is named and left out. The report
is Markdown, on standard output; `--write` keeps it, `--readme` renews the table in README.md.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from statistics import median
from typing import Any

import processes
from measured import Measured
from processes import Absent, Usage

README = processes.BENCH.parent / "README.md"

CONTENDERS: dict[str, tuple[str, ...]] = {
    "slipfold": ("ours.py", "--repeat", "3"),
    **{
        f"{name}, {settings}": (f"peers/{script}", "--repeat", "2", "--settings", settings)
        for name, script in (("AUTO-07p", "auto07p.py"), ("XPPAUT", "xppaut.py"))
        for settings in ("reliable", "largest", "fine")
    },
    "SciPy": ("peers/scipy_simulate.py", "--repeat", "1"),
}
"""Name, script and arguments; one call of each is a round."""

LOCUS_PEER = "peers/auto07p_locus.py"

LOCUS_CONTENDERS: dict[str, tuple[str, ...]] = {
    "slipfold": ("ours_locus.py", "--repeat", "3"),
    **{
        f"AUTO-07p, {settings}": (LOCUS_PEER, "--repeat", "2", "--settings", settings)
        for settings in ("reliable", "largest", "fine")
    },
}
"""The same of the locus of period doubling."""

SYSTEM_PEERS = {
    "AUTO-07p": "peers/auto07p_systems.py",
    "XPPAUT": "peers/xppaut_systems.py",
    "pyHarm": "peers/pyharm_systems.py",
}

SYSTEM_CONTENDERS: dict[str, dict[str, tuple[str, ...]]] = {
    system: {
        "slipfold": ("ours_systems.py", "--repeat", "3", "--system", system),
        **{
            f"{name}, {settings}": (
                script, "--repeat", "2", "--settings", settings, "--system", system
            )
            for name, script in SYSTEM_PEERS.items()
            if name != "pyHarm" or system == "duffing"
            for settings in ("usual", "large", "fine")
        },
    }
    for system in ("duffing", "vanderpol", "chain")
}  # fmt: skip
"""The same of three systems; pyHarm has elements for the first only."""

CYCLE_CONTENDERS: dict[str, dict[str, tuple[str, ...]]] = {
    name: {
        "slipfold": ("ours_cycles.py", "--repeat", "3", "--system", name),
        **{
            f"AUTO-07p, {settings}": (
                "peers/auto07p_cycles.py", "--repeat", "2", "--settings", settings, "--system", name
            )
            for settings in ("usual", "large", "fine")
        },
    }
    for name in ("canards", "relaxation", "beam")
}  # fmt: skip
"""The same of three systems that nothing forces."""

STICK_CONTENDERS: dict[str, tuple[str, ...]] = {
    "slipfold": ("peers/slipfold_stick.py", "--repeat", "3"),
    "SciPy": ("peers/scipy_stick.py", "--repeat", "1"),
    "solve-nivp": ("peers/nivp_stick.py", "--repeat", "1"),
}
"""The same of an oscillator that sticks and slips."""

BATCH_CONTENDERS: dict[str, tuple[str, ...]] = {
    "slipfold": ("peers/slipfold_batch.py", "--repeat", "3"),
    "pynamicalsys": ("peers/pynamicalsys_batch.py", "--repeat", "2"),
    "SciPy": ("peers/scipy_batch.py", "--repeat", "1"),
}
"""The same of many motions at once."""

MAP = ("threshold_map.py", "--repeat", "1")

ENSEMBLE = ("ensemble.py", "--repeat", "1")

SIZE = ("size.py", "--repeat", "5")

STUDY = "many_cases/measure.py"

AFTER_THE_HOPF = ("many_cases/after_the_hopf.py", "--repeat", "1")

FEW = 3
"""Rounds of what takes long."""

STUDY_CASES = 512
"""Responses of the study where no number is asked for."""

WHOLE_STUDY = 2000
"""Responses of the study that the aims are about, for which memory is measured to 100,000 cases."""

CLOCKS = ("seconds", "solver_seconds", "processor_seconds")


QUICK = (
    "responses",
    "locus",
    "thresholds",
    "ensemble",
    *SYSTEM_CONTENDERS,
    "stick",
    "batch",
    "after-the-hopf",
    "commands",
)
"""What is measured where nothing is asked for: one round takes ten minutes of a quiet machine."""

PARTS = (*QUICK, "size", "study", *CYCLE_CONTENDERS, "paper")


def note(sentence: str) -> None:
    """Say how far it is, where that is not part of the report."""
    print(sentence, file=sys.stderr, flush=True)


def merge(record: dict[str, Any], other: dict[str, Any]) -> None:
    """Add the times of another round to a record."""
    for clock in CLOCKS:
        for task, seconds in other.get(clock, {}).items():
            record[clock][task] += seconds
    times = record.get("solver_seconds", record["seconds"])
    for task in record.get("seconds_per_point", {}):
        record["seconds_per_point"][task] = median(times[task]) / record["points"][task]


def collect(records: dict[str, dict[str, Any]], name: str, answer: dict[str, Any]) -> None:
    """Keep a record, or add its times to those kept."""
    if name in records:
        merge(records[name], answer)
    else:
        records[name] = answer


def compete(
    rounds: int, contenders: Mapping[str, tuple[str, ...]], **environment: str
) -> tuple[dict[str, dict[str, Any]], dict[str, str]]:
    """Let all programs work in turn; return their records, and why others did not work."""
    records: dict[str, dict[str, Any]] = {}
    absent: dict[str, str] = {}
    for number in range(1, rounds + 1):
        for name, (script, *arguments) in contenders.items():
            if name in absent:
                continue
            note(f"round {number} of {rounds}: {name}, {script}")
            answer = processes.ask(script, *arguments, **environment)
            if not isinstance(answer, Absent):
                collect(records, name, answer)
            elif name == "slipfold":
                raise SystemExit(f"slipfold's {script} did not run: {answer.reason}")
            else:
                absent[name] = answer.reason
    return records, absent


def thresholds(rounds: int) -> dict[str, Any]:
    """The record of the map of thresholds, its first one each time with empty caches."""
    kept: dict[str, dict[str, Any]] = {}
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as folder:
            environment = {"SLIPFOLD_CACHE_DIR": folder, **processes.ONE_THREAD}
            records, _ = compete(1, {"slipfold": MAP}, **environment)
        collect(kept, "slipfold", records["slipfold"])
    return kept["slipfold"]


def ensemble(rounds: int) -> dict[str, Any]:
    """The record of responses with random parameters."""
    return compete(rounds, {"slipfold": ENSEMBLE}, **processes.ONE_THREAD)[0]["slipfold"]


def study(cases: int, responses: Mapping[str, dict[str, Any]]) -> dict[str, Any]:
    """The record of a study, beside what AUTO's engine takes for one of its cases."""
    few = () if cases >= WHOLE_STUDY else ("--largest", str(max(10 * cases, 100)))
    contender = {"slipfold": (STUDY, "--cases", str(cases), *few)}
    record = compete(1, contender, **processes.ONE_THREAD)[0]["slipfold"]
    peers = [times for name, times in responses.items() if name.startswith("AUTO-07p")]
    each = [
        sum(median(times["solver_seconds"][task]) for task in ("period1", "period2"))
        for times in peers
        if "solver_seconds" in times
    ]
    return {**record, "auto": min(each, default=None)}


def sizes() -> dict[str, Any]:
    """The record of the cost by size, with an empty cache, so that compiling is seen."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {"SLIPFOLD_CACHE_DIR": folder, **processes.ONE_THREAD}
        records, _ = compete(1, {"slipfold": SIZE}, **environment)
    return records["slipfold"]


def after_the_hopf(rounds: int) -> dict[str, Any]:
    """The record of tori and of a picture of basins."""
    records: dict[str, Any] = {}
    for _ in range(rounds):
        found = compete(1, {"slipfold": AFTER_THE_HOPF}, **processes.ONE_THREAD)[0]["slipfold"]
        for what, record in found.items():
            records.setdefault(what, {**record, "seconds": []})["seconds"] += record["seconds"]
    return records


def all_absent(responses: dict[str, str], others: dict[str, dict[str, str]]) -> dict[str, str]:
    """Why programs did not run, each reason of a program once."""
    new = {
        f"{name}, {task}": why
        for task, absent in others.items()
        for name, why in absent.items()
        if responses.get(name) != why
    }
    return {**responses, **new}


def repeated(rounds: int, name: str, work: Callable[[Path], Usage]) -> list[Usage]:
    """Measure a command with empty caches."""
    usages = []
    for number in range(1, rounds + 1):
        note(f"{name}, {number} of {rounds}")
        with tempfile.TemporaryDirectory() as folder:
            usages.append(work(Path(folder)))
    return usages


def commands(rounds: int) -> tuple[list[Usage], list[Usage]]:
    """The force response as a command, with empty caches and with filled ones."""
    first = repeated(rounds, "first process ever", processes.response_process)
    with tempfile.TemporaryDirectory() as folder:
        processes.response_process(Path(folder))
        return first, [processes.response_process(Path(folder)) for _ in range(rounds)]


def measure(parts: Collection[str], rounds: int, cases: int = STUDY_CASES) -> Measured:
    """Measure the parts that are asked for."""
    few = min(rounds, FEW)
    empty: tuple[dict[str, dict[str, Any]], dict[str, str]] = ({}, {})
    records, absent = compete(rounds, CONTENDERS) if "responses" in parts else empty
    loci, missing = (
        compete(rounds, LOCUS_CONTENDERS, **processes.ONE_THREAD) if "locus" in parts else empty
    )
    missing_there = {"locus": missing}

    def each(group: Mapping[str, Mapping[str, tuple[str, ...]]]) -> dict[str, Any]:
        found = {}
        for name in (name for name in group if name in parts):
            found[name], missing_there[name] = compete(few, group[name], **processes.ONE_THREAD)
        return found

    systems, cycles = each(SYSTEM_CONTENDERS), each(CYCLE_CONTENDERS)
    stick, missing_there["stick"] = (
        compete(few, STICK_CONTENDERS, **processes.ONE_THREAD) if "stick" in parts else empty
    )
    batch, missing_there["batch"] = (
        compete(few, BATCH_CONTENDERS, **processes.ONE_THREAD) if "batch" in parts else empty
    )
    first, cached = commands(rounds) if "commands" in parts else ([], [])
    return Measured(
        records,
        all_absent(absent, missing_there),
        first,
        cached,
        repeated(1, "the paper, cold", processes.paper_process) if "paper" in parts else [],
        loci,
        thresholds(1) if "thresholds" in parts else {},
        systems,
        cycles,
        sizes() if "size" in parts else {},
        ensemble(few) if "ensemble" in parts else {},
        stick,
        study(cases, records) if "study" in parts else {},
        batch,
        after_the_hopf(few) if "after-the-hopf" in parts else {},
    )


def main() -> None:
    """Measure and report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "parts", nargs="*", metavar="PART", help=f"some of {', '.join(PARTS)}; or all"
    )
    parser.add_argument("--rounds", type=int, help="rounds (default 3; 1 where no part is named)")
    parser.add_argument(
        "--cases", type=int, default=STUDY_CASES, help=f"of the study (default {STUDY_CASES})"
    )
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the report to a file too")
    parser.add_argument("--readme", action="store_true", help="renew the table in README.md")
    options = parser.parse_args()
    unknown = [part for part in options.parts if part not in (*PARTS, "all")]
    if unknown:
        parser.error(f"there is no part {', '.join(unknown)}; there are {', '.join(PARTS)}")
    if options.readme and "all" not in options.parts:
        parser.error("the tables in README.md are renewed as a whole: name all with --readme")
    parts = PARTS if "all" in options.parts else options.parts or QUICK
    rounds = options.rounds or (3 if options.parts else 1)
    measured = measure(parts, rounds, options.cases)
    # Imported late: a process inherits the memory of the one that starts it as its least.
    from report import brief, renew, report

    text = report(measured)
    print(text)
    if options.write:
        options.write.write_text(text + "\n")
    if options.readme:
        README.write_text(renew(README.read_text(), brief(measured)))


if __name__ == "__main__":
    main()
