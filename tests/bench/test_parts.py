"""Every part of the benchmarks can be chosen by name, and what slipfold does in it runs."""

import importlib
import json
import subprocess
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[2] / "bench"


@pytest.fixture
def run(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCH))
    return importlib.import_module("run")


@pytest.fixture
def asked(run, monkeypatch):
    """Scripts that are requested, none of which runs."""
    scripts = []

    def ask(script, *_, **__):
        scripts.append(script)
        return {"seconds": {}}

    monkeypatch.setattr(run.processes, "ask", ask)
    for command in ("response_process", "paper_process"):
        monkeypatch.setattr(
            run.processes, command, lambda folder: scripts.append(f"{folder}") or (1.0, 1)
        )
    return scripts


def test_each_part_is_measured_alone_by_scripts_that_exist(run, asked):
    everything = {"peers/auto07p_demos.py"}  # which gallery_demos.py asks
    for part in run.PARTS:
        asked.clear()
        measured = run.measure([part], 1)
        assert asked
        if part not in ("commands", "paper"):
            assert all((BENCH / script).exists() for script in asked)
            everything |= set(asked)
        assert set(measured.records) == ({part} if part in (*run.GROUPS, "study") else set())
        assert len(measured.usages) == {"commands": 2, "paper": 1}.get(part, 0)
        assert not measured.absent
        assert not measured.failed
    peers = {str(path.relative_to(BENCH)) for path in (BENCH / "peers").glob("*_*.py")}
    assert peers <= everything


def test_the_exact_curve_after_a_slider_is_the_followed_one(run):
    latency = importlib.import_module("sections.latency")
    seconds = {"first": [0.04, 0.03, 0.02], "followed": [0.07, 0.08, 0.09]}
    rows = [row[:2] for row in latency.aim_rows({"seconds": seconds})]
    assert rows == [
        ["from a slider to the first curve in 50 ms", "30 ms"],
        ["from a slider to the exact curve in 50 ms", "80 ms"],
    ]


SMALLEST = {
    "responses": ("ours.py", "--repeat", "1"),
    "locus": ("ours_locus.py", "--repeat", "1"),
    "thresholds": ("threshold_map.py", "--repeat", "1", "--size", "4", "--sample", "1"),
    "ensemble": ("ensemble.py", "--repeat", "1", "--cases", "2"),
    "study": ("many_cases/measure.py", "--cases", "2", "--largest", "10"),
    "size": ("size.py", "--repeat", "1"),
    "structures": ("ours_structures.py", "--repeat", "1"),
    "stick": ("peers/slipfold_stick.py", "--repeat", "1"),
    "batch": ("peers/slipfold_batch.py", "--repeat", "1"),
    "after-the-hopf": ("many_cases/after_the_hopf.py", "--repeat", "1", "--points", "4"),
    **{
        system: ("ours_systems.py", "--repeat", "1", "--system", system)
        for system in ("duffing", "vanderpol", "chain")
    },
    **{
        system: ("ours_cycles.py", "--repeat", "1", "--system", system)
        for system in ("canards", "relaxation", "beam")
    },
}


def test_each_part_has_a_smallest_size(run):
    assert set(SMALLEST) == set(run.PARTS) - {"commands", "paper", "latency"}


@pytest.mark.long
@pytest.mark.parametrize("part", SMALLEST)
def test_what_slipfold_does_in_a_part_runs(part):
    script, *arguments = SMALLEST[part]
    command = [sys.executable, str(BENCH / script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)
