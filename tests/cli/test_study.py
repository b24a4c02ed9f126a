"""The command that computes studies."""

import json
from contextlib import contextmanager

import pytest

import slipfold as sf
from helpers.command_line import run
from helpers.studies import CHEAP, CHEAP_FILE, content, files_of_at_most
from slipfold.studies.executors import TASKS


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "cheap.toml"
    path.write_text(CHEAP_FILE)
    return str(path)


def test_it_writes_what_python_returns(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("study", case, "--workers", "1", "--json", "all.json", "--csv", "all.csv")
    assert result.exit_code == 0, result.stderr
    assert "100 cases" in result.stdout
    alone = content(sf.study(CHEAP), tmp_path)
    assert (tmp_path / "cheap.nc").read_bytes() == alone
    record = json.loads((tmp_path / "all.json").read_text())
    assert record["schema"] == "slipfold.study/1"
    assert len(record["cases"]) == 100
    assert record["cases"][6]["given"] == {"Vd": 0.5 + 0.3 / 19, "mu": 0.4}
    assert (tmp_path / "all.csv").read_text().startswith("case,Vd (m/s),mu,settled,period,")
    again = run("study", case, "--workers", "1")
    assert again.exit_code == 2
    assert "cheap.study holds 100 of 100 cases of this study; continue" in again.stderr
    (tmp_path / "cheap.nc").unlink()
    assert run("study", case, "--resume", "--workers", "1").exit_code == 0
    assert (tmp_path / "cheap.nc").read_bytes() == alone


def test_check_says_how_much_it_is_and_computes_nothing(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("study", case, "--check", "--workers", "2")
    assert result.exit_code == 0
    assert "simulation of SlidingOscillator(Nd=0.02)" in result.stdout
    assert "20 x 5 = 100 cases over Vd, mu" in result.stdout
    assert "s a case, from" in result.stdout
    assert " on 2 processes\n" in result.stdout
    result = run("study", case, "--check", "--workers", "2", "--scheduler", "tcp://far:8786")
    assert " on 2 processes of this machine, not at tcp://far:8786\n" in result.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["cheap.toml"]


def test_a_full_disk_ends_it_with_a_sentence_and_it_goes_on_later(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with files_of_at_most(8192):
        result = run("study", case, "--workers", "1")
    assert result.exit_code == 2
    assert "cheap.study cannot be written (file too large); the" in result.stderr
    assert "cases finished before are stored: free some space and continue with" in result.stderr
    assert result.stderr.count("\n") == 1
    assert run("study", case, "--resume", "--workers", "1").exit_code == 0
    assert (tmp_path / "cheap.nc").read_bytes() == content(sf.study(CHEAP), tmp_path)


def test_ctrl_c_while_failed_cases_are_tried_again(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    failing = CHEAP_FILE.split("[cases.grid]")[0] + "cases = {list = [{Vd = 0.5}, {Vd = -1}]}"
    (tmp_path / "cheap.toml").write_text(failing)
    assert run("study", case, "--workers", "1").exit_code == 0

    @contextmanager
    def pressed():
        def stop():
            raise KeyboardInterrupt

        yield stop

    monkeypatch.setattr("slipfold.interface.cli.interruption.deferred_interrupts", pressed)
    result = run("study", case, "--workers", "1", "--retry-failed")
    assert result.exit_code == 130
    assert "2 of 2 cases are stored in cheap.study; the same command continues" in result.stderr


def test_mistakes(case, tmp_path, monkeypatch):
    monkeypatch.setattr(TASKS, "scheduler_timeout", 0.2)
    for options, words in {
        ("--workers", "0"): "--workers 0 is not a whole number of at least 1",
        ("--out", str(tmp_path / "no" / "x.nc")): "does not exist",
        ("--out", "x.zarr"): "x.zarr would be netCDF all the same; give a name that ends in .nc",
        ("--scheduler", "tcp://127.0.0.1:1", "--out", str(tmp_path / "y.nc")): "no scheduler",
    }.items():
        result = run("study", case, *options)
        assert result.exit_code == 2
        assert words in result.stderr
        assert result.stderr.count("\n") == 1
