"""Programs run as processes of their own: what they print, how long they take, what they need."""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

BENCH = Path(__file__).parent
TIMEOUT = 900
"""Seconds after which a peer is given up."""

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
"""Environment in which linear algebra keeps to one thread."""


class Absent(NamedTuple):
    """A peer that did not run, and why."""

    reason: str


class Usage(NamedTuple):
    """Wall time of a process in seconds, and its largest resident memory in bytes."""

    seconds: float
    memory: int


def interpreter(peer: str) -> str:
    """The Python of a peer that has an environment of its own, else the one that runs here."""
    own = Path(sys.prefix, peer, "bin", "python")
    return str(own) if own.exists() else sys.executable


def ask(script: str, *arguments: str, **environment: str) -> dict[str, Any] | Absent:
    """The record a script of this folder prints, or why there is none."""
    own = interpreter(Path(script).stem.partition("_")[0])
    try:
        done = subprocess.run(
            [own, str(BENCH / script), *arguments],
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            timeout=TIMEOUT,
        )
    except subprocess.TimeoutExpired:
        return Absent(f"{script} was not done after {TIMEOUT} s.")
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        return Absent(lines[-1] if lines else f"{script} ended with status {done.returncode}.")
    record: dict[str, Any] = json.loads(done.stdout)
    return record


def command(arguments: list[str], cache: Path) -> Usage:
    """Run slipfold's command line with compiled flows and font lists cached in a folder.

    The memory is that of the largest process, where a command uses several.
    """
    folders = {"SLIPFOLD_CACHE_DIR": str(cache / "flows"), "MPLCONFIGDIR": str(cache / "fonts")}
    # Byte code is kept, as it is by default; some containers switch that off.
    kept = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    begun = time.perf_counter()
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(
            [sys.executable, "-m", "slipfold.cli", *arguments],
            env={**kept, **folders},
            stdout=subprocess.DEVNULL,
            stderr=errors,
        )
        # wait4 and not getrusage: the latter gives the largest of all children so far.
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - begun
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            errors.seek(0)
            raise RuntimeError(f"slipfold {' '.join(arguments)}: {errors.read().decode()}")
    return Usage(seconds, usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024))


def response_process(cache: Path) -> Usage:
    """Time and memory of the force response at 12.5 Hz as a command."""
    return command(["response", "sliding", "--vary", "Nd=0:0.98", "--set", "f=12.5"], cache)


def paper_process(cache: Path) -> Usage:
    """Time and memory of the source paper's reproduction as a command."""
    return command(["paper", "--out", str(cache / "paper")], cache)
