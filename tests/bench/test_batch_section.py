"""Rates of many motions at once are compared with the fastest peer, errors with a reference."""

import importlib
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[2] / "bench"


def record(seconds, error, task="strobe", **more):
    return {
        "settings": {"motions": 512, "periods": 100},
        "processor_seconds": {task: [seconds]},
        "points": {task: 51_200},
        "final_state": {task: [0.1 + error, 0.2], **more},
    }


def test_rates_and_errors_of_many_motions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCH))
    report = importlib.import_module("sections.batch")
    records = {
        "slipfold": record(0.1, 1e-9, reference=[0.1, 0.2]),
        "pynamicalsys": record(0.8, 1e-7, "rk45"),
        "SciPy": record(100.0, 1e-8, "DOP853"),
    }
    assert list(report.runs(records))[1][:2] == ("pynamicalsys rk45", 64_000)
    aims = [row[1:] for row in report.aim_rows(records)]
    assert aims == [["512,000", "met"], ["8 times (pynamicalsys rk45)", "met"]]
    assert "| SciPy DOP853 | 512 | 1e+03 | 1e-08 |" in report.section(records)[-1]


def test_all_programs_get_the_same_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCH / "peers"))
    batch = importlib.import_module("batch")
    whole, few = batch.starts(), batch.starts(batch.COMPARED)
    assert batch.compared(whole[:, :2]) == batch.compared(few[:, :2])
    assert len(whole) == batch.COUNT
