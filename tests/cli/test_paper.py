"""``slipfold paper``: what is said, and the exit status; what it computes is tested elsewhere."""

import importlib
from pathlib import Path

import pytest

from helpers.command_line import run
from slipfold import Progress
from slipfold.interface.paper.reproduce import Reproduction


@pytest.fixture
def calls(monkeypatch):
    """Let the command report these instead of computing for half a minute."""
    made = {}

    def reproduce(out, on_progress=None, *, processes, tori, long_term):
        made.update(processes=processes, tori=tori, long_term=long_term)
        on_progress(Progress("results", 1, 30, "Nd_base  found: PD 0.0435789"))
        return Reproduction(Path(out), (), (), **made.get("outcome", {}))

    module = importlib.import_module("slipfold.interface.paper.reproduce")
    monkeypatch.setattr(module, "reproduce", reproduce)
    return made


def test_done(calls):
    result = run("paper", "--out", "here", "--processes", "3")
    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout == "0 files are in here; 0 of 0 claims are confirmed\n"
    assert (calls["processes"], calls["tori"], calls["long_term"]) == (3, False, False)


def test_interrupted(calls):
    calls["outcome"] = {"missing": ("figure7",)}
    result = run("paper", "--out", "here")
    assert (result.exit_code, result.stdout) == (130, "")
    assert result.stderr.startswith("slipfold: interrupted: 0 files")


def test_stopped_by_a_failure(calls):
    calls["outcome"] = {"stopped": ("Nd_base, branch 1: lost",)}
    result = run("paper", "--out", "here")
    assert result.exit_code == 3
    assert "0 files are in here" in result.stdout
    assert result.stderr == "slipfold: stopped early: Nd_base, branch 1: lost\n"


def test_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    result = run("paper", "--out", str(tmp_path / "file" / "out"))
    assert (result.exit_code, result.stdout) == (2, "")
    assert "file/out" in result.stderr
    assert result.stderr.count("\n") == 1
