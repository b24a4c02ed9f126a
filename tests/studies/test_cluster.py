"""The same studies on a real scheduler with real workers, which die, too."""

import json
import subprocess
import sys
import time
from contextlib import ExitStack

import pytest

import slipfold as sf
from helpers.studies import CHEAP, content
from slipfold import InputError
from slipfold.studies.executors import TASKS

distributed = pytest.importorskip("distributed", reason="clusters are the extra 'cluster'")


@pytest.fixture
def processes():
    """Start programs of Dask; end those that still run."""
    with ExitStack() as stack:

        def begin(program, *options):
            command = [sys.executable, "-m", f"distributed.cli.{program}", "--no-dashboard"]
            process = subprocess.Popen([*command, *options], stderr=subprocess.DEVNULL)
            stack.callback(process.wait)
            stack.callback(process.kill)
            return process

        yield begin


def test_a_cluster_computes_the_same_and_survives_its_workers(
    tmp_path, processes, monkeypatch, capfd
):
    monkeypatch.setattr(TASKS, "scheduler_timeout", 5.0)
    undisturbed = content(sf.study(CHEAP), tmp_path)
    known = tmp_path / "scheduler.json"
    scheduler = processes(
        "dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(known)
    )
    workers = [
        processes("dask_worker", "--scheduler-file", str(known), "--nthreads", "1", "--no-nanny")
        for _ in range(2)
    ]
    while not known.exists():
        time.sleep(0.02)
    address = json.loads(known.read_text())["address"]

    def kill_a_worker(progress):
        if progress.done:
            workers[0].kill()

    found = sf.study(CHEAP, executor=address, on_progress=kill_a_worker)
    assert content(found, tmp_path) == undisturbed

    def kill_the_scheduler(progress):
        if progress.done:
            scheduler.kill()

    store = tmp_path / "cheap.study"
    with pytest.raises(InputError, match=r"the cluster at tcp.* is gone; the \d+ cases finished"):
        sf.study(CHEAP, store, executor=address, on_progress=kill_the_scheduler)
    assert capfd.readouterr().err == ""
    found = sf.study(CHEAP, store, resume=True)
    assert content(found, tmp_path) == undisturbed
