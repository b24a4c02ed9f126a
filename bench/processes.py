"""Programs run as processes of their own: what they print, how long they take, what they need."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

BENCH = Path(__file__).parent
TIMEOUT = 900.0
"""Seconds after which a script is given up that has no budget of its own."""

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


def ask(
    script: str, *arguments: str, seconds: float | None = None, **environment: str
) -> dict[str, Any] | Absent:
    """The record a script of this folder prints, or why there is none."""
    own = interpreter(Path(script).stem.partition("_")[0])
    patience = TIMEOUT if seconds is None else seconds
    # A session of its own, so that what a script has started ends with it.
    with subprocess.Popen(
        [own, str(BENCH / script), *arguments],
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            found, said = process.communicate(timeout=patience)
        except subprocess.TimeoutExpired:
            return Absent(f"not finished in {patience:g} s.")
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    lines = said.strip().splitlines()
    if process.returncode:
        return Absent(lines[-1] if lines else f"{script} ended with status {process.returncode}.")
    try:
        record: dict[str, Any] = json.loads(found)
    except ValueError:
        return Absent(f"{script} printed no record.")
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
            [sys.executable, "-m", "slipfold.interface.cli", *arguments],
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
