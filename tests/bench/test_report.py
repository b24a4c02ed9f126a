"""The benchmarks' report says plainly what was measured, missed and left out."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

BENCH = Path(__file__).parents[2] / "bench"
PD, FIRST, SECOND = 0.043578911491, 0.056690677223, 0.166438167073


class Bench:
    """The modules of the benchmarks."""

    def __init__(self) -> None:
        self.report: ModuleType = importlib.import_module("report")
        self.run: ModuleType = importlib.import_module("run")
        self.processes: ModuleType = importlib.import_module("processes")


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    monkeypatch.syspath_prepend(str(BENCH))
    return Bench()


def follower(seconds: float, error: float = 0.0, **more: Any) -> dict[str, Any]:
    """The record of a program that takes so long for each branch and errs by so much."""
    return {
        "seconds": {"period1": [seconds], "period2": [seconds]},
        "specials": {
            "period1": [("PD", PD + error)],
            "period2": [("NS", FIRST), ("NS", SECOND - error / 2)],
        },
        "points": {"period1": 20, "period2": 10},
        **more,
    }


def ours(seconds: float) -> dict[str, Any]:
    tasks = ("both", "limit", "period1", "period2", "simulate")
    return {
        **follower(seconds),
        "seconds": {task: [seconds] for task in tasks},
        "reached": {"limit": 0.3759},
        "final_state": {"simulate": [0.1031181765668, -0.0678563350151, 0, 0]},
    }


def measured(bench: Bench, records: dict[str, Any], **absent: str) -> Any:
    usage = bench.processes.Usage(0.9, 100_000_000)
    slow = bench.processes.Usage(40.0, 100_000_000)
    return bench.run.Measured(records, absent, [usage], [usage], [slow])


def test_aims_are_judged_against_the_faster_peer(bench: Bench) -> None:
    records = {
        "slipfold": ours(0.01),
        "AUTO-07p, reliable": follower(0.2, 1e-7),
        "XPPAUT, reliable": follower(0.5, 1e-8),
    }
    rows = list(bench.report.aim_rows(measured(bench, records)))
    assert rows[0][1:] == ["20 times (AUTO-07p, reliable)", "falls short"]
    assert rows[1][1:] == ["< 1e-12 N against 1e-08 N", "met"]
    assert [row[2] for row in rows[2:]] == ["met", "met", "falls short"]


def test_a_peer_that_misses_a_point_is_no_rival(bench: Bench) -> None:
    blind = follower(0.001)
    blind["specials"]["period1"] = []
    records = {"slipfold": ours(0.01), "AUTO-07p, largest": blind}
    what = measured(bench, records)
    assert not any("largest" in row[0] for row in bench.report.aim_rows(what))
    assert list(bench.report.response_rows(what))[1][-3:] == ["?", "?", "?"]
    assert "a point missed or invented" in bench.report.brief(what)


def test_programs_left_out_are_named(bench: Bench) -> None:
    what = measured(bench, {"slipfold": ours(0.01)}, XPPAUT="XPPAUT is not installed.")
    assert "Left out, XPPAUT: XPPAUT is not installed." in bench.report.report(what)


def test_a_programs_own_clock_counts(bench: Bench) -> None:
    record = follower(0.5, solver_seconds={"period1": [0.1, 0.2, 0.3], "period2": [0.4]})
    assert bench.report.together(record) == pytest.approx(0.6)


def test_the_readme_has_a_place_for_the_table(bench: Bench) -> None:
    readme = (BENCH.parent / "README.md").read_text(encoding="utf-8")
    once = bench.report.renew(readme, "first")
    twice = bench.report.renew(once, "second")
    assert "second" in twice
    assert twice == bench.report.renew(readme, "second")


def test_a_missing_script_is_a_reason(bench: Bench) -> None:
    answer = bench.processes.ask("no_such_script.py")
    assert isinstance(answer, bench.processes.Absent)
    assert "no_such_script.py" in answer.reason
