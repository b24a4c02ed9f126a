"""Studies whose process or workers are killed: nothing finished is lost, and nothing changes."""

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import nullcontext
from pathlib import Path

import pytest

import slipfold as sf
from helpers.command_line import run
from helpers.studies import CHEAP, CHEAP_FILE, content
from slipfold import InputError

HELPER = Path(__file__).parents[1] / "helpers" / "killed_study.py"

KILLS = 4


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    return content(sf.study(CHEAP), tmp_path_factory.mktemp("undisturbed"))


def test_killed_at_many_moments_and_resumed_it_is_the_same(tmp_path, undisturbed):
    command = [sys.executable, str(HELPER), str(tmp_path), str(KILLS)]
    said = json.loads(subprocess.check_output(command, text=True, timeout=120))
    assert said["killed"] == KILLS
    assert said["same"] == [True] * said["studies"]


def test_a_command_killed_with_its_workers_at_work_is_resumed(tmp_path, undisturbed, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("cheap.toml").write_text(CHEAP_FILE)
    command = [
        sys.executable,
        "-m",
        "slipfold.interface.cli",
        "study",
        "cheap.toml",
        "--workers",
        "2",
    ]
    # As a shell does it: the command and its workers are one group.
    process = subprocess.Popen(command, start_new_session=True, stderr=subprocess.DEVNULL)
    kept = tmp_path / "cheap.study" / "cases.jsonl"
    while process.poll() is None and not (kept.exists() and kept.read_bytes().count(b"\n") > 1):
        time.sleep(0.01)
    process.kill()
    process.wait()
    # Workers whose command is gone end by themselves.
    deadline = time.monotonic() + 20
    while _alive(process.pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not _alive(process.pid)
    assert run("study", "cheap.toml", "--resume", "--workers", "1").exit_code == 0
    assert Path("cheap.nc").read_bytes() == undisturbed


def _alive(group):
    """Whether any process of a group is alive."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.long
def test_a_worker_that_dies_takes_no_case_with_it(tmp_path, undisturbed):
    killed = []

    def kill(progress):
        if progress.done and not killed:
            killed.append(multiprocessing.active_children()[0])
            killed[0].kill()

    found = sf.study(CHEAP, executor=2, on_progress=kill)
    assert killed
    assert content(found, tmp_path) == undisturbed


class Fragile(Executor):
    """Dies with whatever holds one case, as a pool of processes does."""

    tried = 0

    def submit(self, fn, task):
        future = Future()
        if 7 in task.numbers:
            self.tried += 1
            future.set_exception(BrokenExecutor())
        else:
            future.set_result(fn(task))
        return future


def test_a_case_that_kills_its_worker_is_found_and_kept_as_failed():
    executor = Fragile()
    found = sf.study(CHEAP, executor=executor)
    assert list(found.failures) == [7]
    assert "the process that computed it ended 3 times without a message" in found.failures[7]
    assert found.done == 100
    assert executor.tried >= 3


class Ending(Executor):
    """Computes a task, then ends with the next one, and both are told at once."""

    def __init__(self, end):
        self.end, self.futures = end, []

    def submit(self, fn, task):
        self.futures.append(Future())
        if len(self.futures) == 2:
            first, second = self.futures
            second.set_exception(self.end)
            first.set_result(fn(self.first))
        self.first = task
        return self.futures[-1]


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("end", [CancelledError(), KeyboardInterrupt(), ValueError("a defect")])
def test_what_is_finished_when_something_ends_is_kept(tmp_path, monkeypatch, end, order):
    def all_finished(futures, slots):
        return [future for future in futures if future.done()][::order]

    monkeypatch.setattr("slipfold.studies.run.first_finished", all_finished)
    expected = nullcontext()
    if not isinstance(end, KeyboardInterrupt):
        expected = pytest.raises((InputError, ValueError), match=r"the 1 cases .* stored|a defect")
    store = tmp_path / "cheap.study"
    with expected:
        assert sf.study(CHEAP, store, executor=Ending(end)).interrupted
    with pytest.raises(InputError, match="holds 1 of 100 cases"):
        sf.study(CHEAP, store)


@pytest.mark.parametrize("by_a_scheduler", [False, True])
def test_workers_without_slipfold_are_reported_in_a_sentence(tmp_path, by_a_scheduler):
    class Bare(Executor):
        def submit(self, fn, task):
            error = missing = ModuleNotFoundError("No module named 'slipfold'")
            if by_a_scheduler:
                error = RuntimeError("Error during deserialization of the task graph.")
                error.__cause__ = missing
            future = Future()
            future.set_exception(error)
            return future

    words = r"^Bare lacks what a study needs \(No module named 'slipfold'\); install the same"
    with pytest.raises(InputError, match=words):
        sf.study(CHEAP, tmp_path / "cheap.study", executor=Bare())


def test_ctrl_c_reaches_the_workers_too_and_says_how_to_go_on(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("many.toml").write_text(CHEAP_FILE.replace("count = 20", "count = 20000"))
    command = [
        sys.executable,
        "-m",
        "slipfold.interface.cli",
        "study",
        "many.toml",
        "--workers",
        "2",
    ]
    process = subprocess.Popen(
        command, start_new_session=True, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    kept = tmp_path / "many.study" / "cases.jsonl"
    while process.poll() is None and not (kept.exists() and kept.read_bytes().count(b"\n") > 5):
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    printed, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert printed == ""
    cases = kept.read_bytes().count(b"\n") - 1
    assert said == (
        f"slipfold: interrupted; {cases} of 100000 cases are stored in many.study; the same "
        "command with --resume continues\n"
    )
