"""The benchmarks' report says plainly what was measured, missed and left out."""

from __future__ import annotations

import importlib
import math
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
        self.reference: ModuleType = importlib.import_module("reference")
        self.stick: ModuleType = importlib.import_module("peers.stick")


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


def locus(
    bench: Bench, settings: str, seconds: float, points: int, error: float = 0.0, **more: Any
) -> dict[str, Any]:
    """The record of a program that follows the locus of PD and errs by so much in Nd."""
    return {
        "settings": {"name": settings},
        "seconds": {"locus": [2 * seconds]},
        "solver_seconds": {"locus": [seconds]},
        "seconds_per_point": {"locus": seconds / points},
        "points": {"locus": points},
        "landed": [(f + 1e-9, Nd - error) for f, Nd in bench.reference.LOCUS.items()],
        **more,
    }


def loci(bench: Bench) -> dict[str, dict[str, Any]]:
    named = [("smallest Nd", 12.462906976920, 0.040083977292 + 2e-9), ("cusp of cycles", 12.0, 0.1)]
    return {
        "slipfold": locus(bench, "defaults", 0.2, 40, named=named),
        "AUTO-07p, fine": locus(bench, "fine", 2.0, 20, 2e-10),
        "AUTO-07p, largest": locus(bench, "largest", 0.1, 10, 2e-8),
    }


def thresholds(**failures: int) -> dict[str, Any]:
    """A map, and a program that finds two of three thresholds in a loop."""
    loop = {
        "solver_seconds": {"each": [0.05, 0.06, 0.09]},
        "specials": {"each": [("PD", 0.1 + 2e-7), ("PD", math.nan), ("PD", 0.3)]},
    }
    return {"slipfold": found_map(**failures), "AUTO-07p, reliable": loop}


def found_map(**failures: int) -> dict[str, Any]:
    return {
        "size": 100,
        "thresholds": 10_000 - sum(failures.values()),
        "failures": failures,
        "followed": 36,
        "seconds": {"cold": [12.0], "warm": [2.0, 1.9, 2.1]},
        "processor_seconds": {"cold": [11.0], "warm": [2.0]},
        "largest_residual": 5e-15,
        "sample": 20,
        "largest_difference": 3e-15,
        "response_ms_each": 130.0,
        "picked": [0.1, 0.2, 0.3, 0.4],
    }


def ensemble() -> dict[str, Any]:
    return {
        "cases": 200,
        "failures": 0,
        "special": 590,
        "agree": 200,
        "largest_uncertainty": 2e-11,
        "seconds": {"warm": [40.0, 36.0, 44.0]},
        "processor_seconds": {"warm": [38.0]},
    }


def measured(bench: Bench, records: dict[str, Any], **absent: str) -> Any:
    usage = bench.processes.Usage(0.9, 100_000_000)
    slow = bench.processes.Usage(40.0, 100_000_000)
    return bench.run.Measured(
        {
            "responses": records,
            "locus": loci(bench),
            "thresholds": thresholds(stuck=3),
            **systems(),
            **cycles(),
            "size": {"slipfold": sizes(2.0)},
            "ensemble": {"slipfold": ensemble()},
            "stick": stick(bench),
        },
        {"first": [usage], "cached": [usage], "paper": [slow]},
        {("responses", name): why for name, why in absent.items()},
    )


def stick(bench: Bench) -> dict[str, Any]:
    """Den Hartog's oscillator: one rival is fast, one slow."""
    after = bench.stick.state_after(5)[0]

    def record(seconds: float, error: float) -> dict[str, Any]:
        return {
            "settings": {"periods": 5},
            "processor_seconds": {"simulate": [seconds]},
            "final_state": {"simulate": [after + error, 0.0]},
        }

    return {
        "slipfold": record(0.01, 1e-13),
        "SciPy": record(0.1, 4e-11),
        "solve-nivp": record(5.0, 3e-4),
    }


def branch(seconds: float, *points: tuple[str, float], **clocks: Any) -> dict[str, Any]:
    """The record of a program that takes so long for one of the three systems."""
    return {
        "seconds": {"branch": [3 * seconds]},
        "processor_seconds": {"branch": [seconds]},
        "specials": {"branch": list(points)},
        "points": {"branch": 30},
        **clocks,
    }


def systems() -> dict[str, Any]:
    """Van der Pol's oscillator: one is slower, one is fast and blind, one has a clock."""
    return {
        "vanderpol": {
            "slipfold": branch(0.1, ("NS", 1.086728948108)),
            "XPPAUT, usual": branch(0.3, ("NS", 1.0867289)),
            "XPPAUT, large": branch(0.01),
            "AUTO-07p, usual": branch(0.7, ("NS", 1.08672894), solver_seconds={"branch": [0.2]}),
        }
    }


def cycles() -> dict[str, Any]:
    """Canards: one program invents a fold, one gives up, one is right and slow."""
    fold, arrived = ("LP", 0.3079163079), {"branch": 0.4, "duration": 72.58123415}
    return {
        "canards": {
            "slipfold": branch(1.0, fold, reached=arrived),
            "AUTO-07p, usual": branch(0.2, fold, fold, reached=arrived),
            "AUTO-07p, large": branch(0.1, fold, reached={"branch": 0.31, "duration": 100.0}),
            "AUTO-07p, fine": branch(3.0, fold, reached=arrived),
        }
    }


def sizes(power: float, compile_seconds: float = 1.0) -> dict[str, Any]:
    """The record of structures whose cost grows with a power of their size."""
    return {
        "sizes": [
            {
                "size": size,
                "states": 2 * size,
                "groups": 1 if size < 12 else size // 2,
                "compile_seconds": compile_seconds,
                "seconds": [1e-5 * size**power],
                "expected_compile_seconds": 1.0,
                "expected_seconds": 2e-5 * size**power,
            }
            for size in (1, 5, 10, 20)
        ],
        "beams": [{"elements": 3, "points": 20, "compile_seconds": 1.5, "seconds": 4.0}],
    }


def test_aims_are_judged_against_the_faster_peer(bench: Bench) -> None:
    records = {
        "slipfold": ours(0.01),
        "AUTO-07p, reliable": follower(0.2, 1e-7),
        "XPPAUT, reliable": follower(0.5, 1e-8),
    }
    rows = list(bench.report.aim_rows(measured(bench, records)))
    assert rows[0][1:] == ["20 times (AUTO-07p, reliable)", "met"]
    assert rows[1][1:] == ["< 1e-12 N against 1e-08 N", "met"]
    assert [row[2] for row in rows[2:5]] == ["met", "falls short", "falls short"]


def test_a_peer_that_misses_a_point_is_no_rival(bench: Bench) -> None:
    blind = follower(0.001)
    blind["specials"]["period1"] = []
    records = {"slipfold": ours(0.01), "AUTO-07p, largest": blind}
    what = measured(bench, records)
    assert not any("largest settings" in row[0] for row in bench.report.aim_rows(what))
    assert list(bench.report.response_rows(what))[1][-3:] == ["?", "?", "?"]
    assert "a point missed or invented" in bench.report.brief(what)


def test_the_systems_are_judged_against_who_finds_every_point(bench: Bench) -> None:
    rows = list(bench.report.systems.aim_rows(systems()))
    assert [row[1:] for row in rows] == [["2 times (AUTO-07p, usual)", "met"]]
    whole = bench.report.report(measured(bench, {"slipfold": ours(0.01)}))
    assert "| XPPAUT, large | 30 | 30 | 10 | 0.1 | a point missed or invented |" in whole
    assert "| AUTO-07p, usual | 30 | 2100 | 200 | 2 | 8e-09 |" in whole
    short = bench.report.brief(measured(bench, {"slipfold": ours(0.01)}))
    assert "200 ms (AUTO-07p, usual)" in short
    assert "3000 ms (AUTO-07p, fine)" in short
    assert len(short.splitlines()) < 60
