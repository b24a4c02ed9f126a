"""slipfold beside other programs: time, memory and error, measured in one run.

    python bench/run.py [--rounds 5] [--write FILE.md] [--readme]

Every program runs in its own process, one after the other, round after round, so that all of them
see the same machine; figures are medians. What is not installed is named and left out. The report
is Markdown, on standard output; `--write` keeps it, `--readme` renews the table in README.md.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import processes
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


class Measured(NamedTuple):
    """All that was measured."""

    records: dict[str, dict[str, Any]]
    absent: dict[str, str]
    first: list[Usage]
    cached: list[Usage]
    paper: list[Usage]


def note(sentence: str) -> None:
    """Say how far it is, where that is not part of the report."""
    print(sentence, file=sys.stderr, flush=True)


def merge(record: dict[str, Any], other: dict[str, Any]) -> None:
    """Add the times of another round to a record."""
    for times in ("seconds", "solver_seconds"):
        for task, seconds in other.get(times, {}).items():
            record[times][task] += seconds


def compete(rounds: int) -> tuple[dict[str, dict[str, Any]], dict[str, str]]:
    """Let all programs work in turn; return their records, and why others did not work."""
    records: dict[str, dict[str, Any]] = {}
    absent: dict[str, str] = {}
    for number in range(1, rounds + 1):
        for name, (script, *arguments) in CONTENDERS.items():
            if name in absent:
                continue
            note(f"round {number} of {rounds}: {name}")
            answer = processes.ask(script, *arguments)
            if isinstance(answer, Absent):
                absent[name] = answer.reason
            elif name in records:
                merge(records[name], answer)
            else:
                records[name] = answer
    return records, absent


def repeated(rounds: int, name: str, work: Callable[[Path], Usage]) -> list[Usage]:
    """Measure a command with empty caches."""
    usages = []
    for number in range(1, rounds + 1):
        note(f"{name}, {number} of {rounds}")
        with tempfile.TemporaryDirectory() as folder:
            usages.append(work(Path(folder)))
    return usages


def measure(rounds: int) -> Measured:
    """Measure everything."""
    records, absent = compete(rounds)
    first = repeated(rounds, "first process ever", processes.response_process)
    with tempfile.TemporaryDirectory() as folder:
        processes.response_process(Path(folder))
        cached = [processes.response_process(Path(folder)) for _ in range(rounds)]
    paper = repeated(min(rounds, 3), "the paper, cold", processes.paper_process)
    return Measured(records, absent, first, cached, paper)


def main() -> None:
    """Measure and report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5, help="rounds (default 5)")
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the report to a file too")
    parser.add_argument("--readme", action="store_true", help="renew the table in README.md")
    options = parser.parse_args()
    measured = measure(options.rounds)
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
