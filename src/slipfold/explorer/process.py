"""A worker process as the server sees it."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from slipfold.explorer.job import Job
from slipfold.explorer.worker import Reply, Task, run_worker
from slipfold.models.model import Model

GRACE = 2.0
"""Seconds that a worker has to drop what has taken too long, before it is ended."""


@dataclass(eq=False)
class WorkerProcess:
    """One worker process as the server sees it."""

    index: int  # its place among the workers
    context: Any  # makes processes
    given: Model | None  # a model beside the built-in ones
    file: Path | None  # the file that holds its equations, if it has one
    heard: Callable[[WorkerProcess, Reply], None]  # called in the event loop with every reply
    ended: Callable[[WorkerProcess], None]  # called in the event loop when the process has ended
    job: Job | None = None  # what it computes now
    ready: bool = False  # whether it has started up
    dropping: bool = False  # whether it has been told to drop its job
    timer: asyncio.TimerHandle | None = None  # fires when the job takes too long
    wanted: Any = field(init=False)
    process: Any = field(init=False)
    connection: Connection = field(init=False)

    def __post_init__(self) -> None:
        """Start the process, and a thread that listens to it."""
        self.connection, theirs = self.context.Pipe()
        self.wanted = self.context.Value("q", 0, lock=False)
        self.process = self.context.Process(
            target=run_worker, args=(theirs, self.wanted, self.given, self.file), daemon=True
        )
        self.process.start()
        theirs.close()
        loop = asyncio.get_running_loop()
        threading.Thread(target=self._listen, args=(loop,), daemon=True).start()

    @property
    def idle(self) -> bool:
        """Whether it waits for a job."""
        return self.ready and self.job is None

    def give(self, job: Job) -> None:
        """Let it compute a job."""
        self.job = job
        self.wanted.value = job.number
        with suppress(OSError):  # it may just have ended: the listener will say so
            self.connection.send(Task(job.number, job.request))

    def drop(self) -> None:
        """Let it drop its job at the next point of a branch."""
        self.dropping = True
        self.wanted.value = 0

    def finish(self) -> None:
        """Note that it has no job any more."""
        self.job, self.dropping = None, False
        if self.timer is not None:
            self.timer.cancel()
            self.timer = None

    def kill(self) -> None:
        """End it at once."""
        self.process.kill()

    def ask_to_stop(self) -> None:
        """Let it end when it has dropped its job."""
        self.wanted.value = 0
        with suppress(OSError):
            self.connection.send(None)

    def end(self) -> None:
        """Wait until it has ended; end it if it does not."""
        self.process.join(GRACE)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()

    def resident_bytes(self) -> int:
        """Memory in use; 0 where the system does not tell."""
        try:
            pages = Path(f"/proc/{self.process.pid}/statm").read_text().split()[1]
        except OSError:
            return 0
        return int(pages) * 4096

    def _listen(self, loop: asyncio.AbstractEventLoop) -> None:
        with suppress(EOFError, OSError):
            while True:
                reply = self.connection.recv()
                loop.call_soon_threadsafe(self.heard, self, reply)
        with suppress(RuntimeError):  # the event loop may have ended
            loop.call_soon_threadsafe(self.ended, self)
