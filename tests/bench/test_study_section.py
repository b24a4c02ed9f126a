"""What the benchmarks' report says of studies."""

import importlib
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[2] / "bench"

RECORD = {
    "processes": 2,
    "cases": 2000,
    "seconds": 500.0,
    "failures": 1,
    "special": 5000,
    "few": 250,
    "one": 120.0,
    "several": 65.0,
    "auto": 0.25,
    "cluster": {"cases": 4000, "processes": 4.0, "cluster": 5.0, "tasks": 900.0},
    "memory": [
        {"cases": n, "computing": 1e8, "saving": 1.2e8, "store": 200 * n, "file": 100 * n}
        for n in (100, 100_000)
    ],
}


@pytest.fixture
def report(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCH))
    return importlib.import_module("sections.study")


def test_a_study_is_told_by_the_case(report):
    section = "\n".join(report.section(RECORD))
    assert "4 cases a second on 2 processes, 250 ms a case; 5,000 special points" in section
    assert "5 s on a Dask cluster of as many (+25 %); its scheduler takes 900 tasks" in section
    assert "| 100,000 | 100 MB | 120 MB | 200 | 100 |" in section
    assert "no cluster was measured" in "\n".join(report.section({**RECORD, "cluster": None}))


def test_its_aims_are_judged(report):
    rows = [row[1:] for row in report.aim_rows(RECORD)]
    flat = ["1.00", "met"]
    assert rows == [["1.85", "met"], ["1", "falls short"], flat, flat]
    few, many = RECORD["memory"]
    slow = {
        **RECORD, "several": 100.0, "auto": None, "memory": [few, {**many, "saving": 1.8e8}]
    }  # fmt: skip
    rows = [row[1:] for row in report.aim_rows(slow)]
    assert rows == [["1.20", "falls short"], flat, ["1.50", "falls short"]]
