"""Worker processes: what each does with a request, and which of them computes what and when."""

from __future__ import annotations

import asyncio
import itertools
import json
import logging
import multiprocessing
import pickle
import signal
import sys
import threading
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

from slipfold.errors import InputError
from slipfold.interface.explorer.answering import Answering
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.messages import (
    DiagramRequest,
    ExportRequest,
    OrbitRequest,
    PostedRequest,
    Quick,
    ViewRequest,
)
from slipfold.interface.explorer.security import ServerLimits
from slipfold.interface.explorer.settings import PAGE
from slipfold.interface.explorer.trajectories import Kept, keep
from slipfold.models.model import Model

READY = 0
"""Number of the reply that says that the worker is ready."""

WANTED = -1
"""Number in place of a job's that asks a worker which is not ready to be so soon."""


class WorkerTask(NamedTuple):
    """What a worker is given."""

    number: int  # number of the job
    request: ViewRequest | PostedRequest  # the request
    made: bytes | None = None  # of a file, what was made for its view, pickled


class Reply(NamedTuple):
    """What a worker gives back."""

    number: int  # number of the job
    body: bytes  # JSON, or the file of an export
    last: bool = True  # whether it is the last one
    refused: bool = False  # whether the body is the sentence of a refusal over HTTP
    made: bytes | None = None  # the result that the body shows parts of, pickled


class Superseded(Exception):
    """The request is superseded."""


def run_worker(
    connection: Connection, current: Any, given: Model | None, file: Path | None
) -> None:
    """Compute until it is stopped; the main function of a worker process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the server says when to stop
    _bound_memory()
    answering = Answering(Catalogue(given, file))
    _warm_up(answering, lambda: current.value == WANTED)
    connection.send(Reply(READY, b""))
    while True:
        try:
            task: WorkerTask | None = connection.recv()
        except EOFError:
            return  # the server is gone
        if task is None:
            return
        try:
            connection.send(_reply(answering, task, connection, current))
        except (BrokenPipeError, ConnectionResetError):
            return


def _warm_up(answering: Answering, is_wanted: Callable[[], bool]) -> None:
    """Prepare for the first request; what fails here will fail there, and is said to who asks."""
    try:
        answering.warm_up(is_wanted)
    except Exception:
        logging.getLogger("slipfold.interface.explorer").exception(
            "the first view cannot be computed"
        )


def _reply(answering: Answering, task: WorkerTask, connection: Connection, current: Any) -> Reply:
    """Compute one task; return its last reply."""
    number, request, made = task
    held = b""

    def check() -> None:
        if current.value != number:
            raise Superseded

    def emit(view: dict[str, Any]) -> None:
        nonlocal held
        body = json.dumps(view, allow_nan=False, separators=(",", ":")).encode()
        if view["done"]:
            held = body
        else:
            connection.send(Reply(number, body, last=False))

    try:
        if isinstance(request, ExportRequest):
            if made is not None:
                answering.adopt(request.view, pickle.loads(made))
            return Reply(number, answering.export(request, check))
        if isinstance(request, PostedRequest):
            return Reply(number, json.dumps(answering.post(request)).encode())
        answering.answer(request, emit, check)
        result = answering.made(request)
        return Reply(number, held, made=None if result is None else pickle.dumps(result))
    except Superseded:
        return Reply(number, b"")
    except InputError as error:
        return _failure(task, str(error))
    except MemoryError:
        return _failure(task, "the computation needs more memory than a worker may take")
    except Exception as error:
        logging.getLogger("slipfold.interface.explorer").exception("a request failed: %r", request)
        return _failure(
            task,
            f"this is a defect of slipfold ({type(error).__name__}: {error}); the terminal in "
            "which slipfold explore runs says more",
        )


def _failure(task: WorkerTask, sentence: str) -> Reply:
    request = task.request
    if isinstance(request, PostedRequest):
        return Reply(task.number, sentence.encode(), refused=True)
    answer = {**request.head, "done": True, "error": sentence}
    return Reply(task.number, json.dumps(answer).encode())


def _bound_memory() -> None:
    if sys.platform == "win32":
        return
    import resource

    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    bound = PAGE.data_bytes if hard == resource.RLIM_INFINITY else min(hard, PAGE.data_bytes)
    resource.setrlimit(resource.RLIMIT_DATA, (bound, hard))


# -- the server's side --------------------------------------------------------------------------


@dataclass(eq=False)
class Job:
    """A request on its way."""

    request: ViewRequest | PostedRequest  # the request
    # Number of the client, whose jobs go to one worker where possible: it remembers its diagrams
    home: int
    # Takes the replies, and last of all one that is marked so, unless the job is cancelled
    deliver: Callable[[Reply], None]
    # Called if the job ends without a last reply, with a sentence and whether asking again may help
    fail: Callable[..., None]
    number: int = 0
    position: int = 0
    since: float = 0.0  # time at which it was submitted
    cancelled: bool = False
    made: bytes | None = None  # of a file, what was made for its view

    @property
    def kind(self) -> str:
        """Kind of the request."""
        return self.request.kind

    @property
    def is_quick(self) -> bool:
        """Whether it takes a moment at most, so that it must not wait for what takes long."""
        asked = self.request
        is_text = isinstance(asked, ExportRequest) and asked.is_text
        return isinstance(asked, Quick) or is_text or self.made is not None

    @property
    def order(self) -> int:
        """Position in the queue: quick answers first."""
        pinned = isinstance(self.request, DiagramRequest) and self.request.slot != "live"
        return self.position + PAGE.overtaken * (self.request.rank + pinned)


@dataclass(eq=False)
class WorkerProcess:
    """One worker process as the server sees it."""

    index: int  # its index among the workers
    context: Any  # makes processes
    given: Model | None  # a model in addition to the built-in ones
    file: Path | None  # the file that holds its equations, if it has one
    received: Callable[[WorkerProcess, Reply], None]  # called in the event loop with every reply
    ended: Callable[[WorkerProcess], None]  # called in the event loop when the process has ended
    job: Job | None = None  # what it computes now
    ready: bool = False  # whether it has started up
    dropping: bool = False  # whether it is to drop its job
    timer: asyncio.TimerHandle | None = None  # fires when the job takes too long
    current: Any = field(init=False)
    process: Any = field(init=False)
    connection: Connection = field(init=False)

    def __post_init__(self) -> None:
        """Start the process, and a thread that listens to it."""
        self.connection, theirs = self.context.Pipe()
        self.current = self.context.Value("q", 0, lock=False)
        self.process = self.context.Process(
            target=run_worker, args=(theirs, self.current, self.given, self.file), daemon=True
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
        self.current.value = job.number
        with suppress(OSError):  # it may just have ended: the listener will say so
            self.connection.send(WorkerTask(job.number, job.request, job.made))

    def drop(self) -> None:
        """Let it drop its job at the next point of a branch."""
        self.dropping = True
        self.current.value = 0

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
        self.current.value = 0
        with suppress(OSError):
            self.connection.send(None)

    def end(self) -> None:
        """Wait until it has ended; end it if it does not."""
        self.process.join(PAGE.grace)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()

    def resident_bytes(self) -> int:
        """Memory in use; 0 where it is unknown."""
        try:
            pages = Path(f"/proc/{self.process.pid}/statm").read_text().split()[1]
        except OSError:
            return 0
        return int(pages) * 4096

    def _listen(self, loop: asyncio.AbstractEventLoop) -> None:
        with suppress(EOFError, OSError):
            while True:
                reply = self.connection.recv()
                loop.call_soon_threadsafe(self.received, self, reply)
        with suppress(RuntimeError):  # the event loop may have ended
            loop.call_soon_threadsafe(self.ended, self)


MODEL = ("model", "text", "parameters")
"""What says in a request of which model it is."""

NONE_STARTS = "no worker process can be started; the terminal of slipfold explore says why"

KILLED = (
    "the worker process that computed this was ended from outside ({code}), perhaps for lack of "
    "memory; a fresh one takes its place, so ask again"
)


class Workers:
    """A few processes that compute jobs; to be used from one event loop.

    `given` is a model in addition to the built-in ones, `file` the file of its equations.
    """

    def __init__(
        self, given: Model | None, count: int, limits: ServerLimits, file: Path | None = None
    ) -> None:
        self._given, self._file = given, file
        self._count = count
        self._limits = limits
        self._context = multiprocessing.get_context("spawn")
        self._numbers = itertools.count(READY + 1)
        self._pending: list[Job] = []
        self._workers: list[WorkerProcess] = []
        self._made: Kept = OrderedDict()  # pickled, by subject
        self._failed_starts = 0
        self._extra = True  # whether one more may start for quick jobs
        self._stopping = False

    @property
    def processes(self) -> list[int]:
        """Process ids of the workers."""
        return [worker.process.pid or 0 for worker in self._workers]

    async def start(self) -> None:
        """Start the processes; jobs may be submitted at once."""
        for index in range(self._count):
            self._workers.append(self._started(index))

    async def stop(self) -> None:
        """End the processes."""
        self._stopping = True
        self._pending.clear()
        for worker in self._workers:
            worker.ask_to_stop()
        await asyncio.gather(*(asyncio.to_thread(worker.end) for worker in self._workers))

    def submit(self, job: Job, instead_of: Job | None = None) -> None:
        """Queue a job."""
        job.number = next(self._numbers)
        waiting = instead_of is not None and instead_of in self._pending
        job.position = instead_of.position if waiting and instead_of is not None else job.number
        if instead_of is not None:
            self.cancel(instead_of)
        if self._failed_starts >= self._limits.failed_starts:
            job.fail(NONE_STARTS)
            return
        if isinstance(job.request, ExportRequest):
            # Each worker has its own seconds after which curves end: it would make another file.
            job.made = self._made.get(job.request.view.subject(*MODEL))
        self._pending.append(job)
        job.since = perf_counter()
        self._dispatch()
        if job.is_quick and job in self._pending:
            asyncio.get_running_loop().call_later(1.1 * PAGE.patience, self._dispatch)

    def cancel(self, job: Job) -> None:
        """End a job without any further reply."""
        job.cancelled = True
        if job in self._pending:
            self._pending.remove(job)
        for worker in self._workers:
            if worker.job is job:
                worker.drop()

    # -- who computes what ---------------------------------------------------------------------

    def _dispatch(self) -> None:
        for job in sorted(self._pending, key=lambda item: item.order):
            worker = self._choose(job)
            if worker is not None:
                self._pending.remove(job)
                self._hand_over(job, worker)
        for worker in self._workers if self._pending else ():
            if not worker.ready:
                worker.current.value = WANTED

    def _choose(self, job: Job) -> WorkerProcess | None:
        """Return a free worker for a job: that of its client, or any that is not."""
        home = self._workers[job.home % self._count]
        if job.is_quick and all(worker.ready for worker in self._workers):
            idle = [worker for worker in self._workers if worker.idle]
            idle.sort(key=lambda worker: worker is home)  # for what it alone knows
            late = not idle and perf_counter() - job.since > PAGE.patience
            if late and self._extra and len(self._workers) == self._count:
                self._workers.append(self._started(self._count))
            return idle[0] if idle else None
        idle = [worker for worker in self._workers[: self._count] if worker.idle]
        if job.request.slow:
            # Such jobs take seconds: the client's own worker, and one of all, stay free of them.
            others = [worker for worker in idle if worker is not home]
            slow = sum(bool(item.job and item.job.request.slow) for item in self._workers)
            if self._count > 1:
                return others[0] if others and slow < self._count - 1 else None
        # Others would have to follow the branches of an orbit, and those beside a diagram's.
        own, now = isinstance(job.request, OrbitRequest), home.job
        known = own or isinstance(job.request, DiagramRequest)
        soon = OrbitRequest | DiagramRequest if own else OrbitRequest
        waits = known and now is not None and (now.is_quick or isinstance(now.request, soon))
        if home.idle or home.dropping or waits:
            return home if home.idle else None
        return idle[0] if idle else None

    def _hand_over(self, job: Job, worker: WorkerProcess) -> None:
        loop = asyncio.get_running_loop()
        seconds = self._limits.seconds.get(job.kind, job.request.seconds)
        worker.timer = loop.call_later(seconds, self._too_long, worker, job, seconds)
        worker.give(job)

    def _too_long(self, worker: WorkerProcess, job: Job, seconds: float) -> None:
        if worker.job is not job:
            return
        if not job.cancelled:
            job.cancelled = True
            job.fail(f"this took more than {seconds:g} s and was given up; {job.request.remedy}")
        worker.drop()
        loop = asyncio.get_running_loop()
        loop.call_later(PAGE.grace, lambda: worker.kill() if worker.job is job else None)

    # -- what workers say ----------------------------------------------------------------------

    def _received(self, worker: WorkerProcess, reply: Reply) -> None:
        if reply.number == READY:
            worker.ready = True
            self._failed_starts = 0
        elif worker.job is not None and worker.job.number == reply.number:
            job = worker.job
            if reply.last:
                if reply.made is not None and not isinstance(job.request, PostedRequest):
                    keep(self._made, job.request.subject(*MODEL), reply.made)
                worker.finish()
                if worker.resident_bytes() > self._limits.worker_bytes:
                    self._workers[worker.index] = self._started(worker.index)
                    worker.ask_to_stop()
            if not job.cancelled:
                job.deliver(reply)
        if worker.idle:
            self._dispatch()

    def _ended(self, worker: WorkerProcess) -> None:
        """Replace a worker that has ended."""
        if self._stopping or worker not in self._workers:
            return
        worker.end()
        job, code = worker.job, worker.process.exitcode
        worker.finish()
        if worker.index == self._count and not worker.ready:  # the others do without it
            self._workers.remove(worker)
            self._extra = False
            return
        self._failed_starts += not worker.ready
        lasting = self._failed_starts >= self._limits.failed_starts
        if not lasting:
            self._workers[worker.index] = self._started(worker.index)
        if job is not None and not job.cancelled:
            job.cancelled = True
            how = f"signal {-code}" if code is not None and code < 0 else f"exit status {code}"
            job.fail(KILLED.format(code=how), again=True)
        while lasting and self._pending:
            self._pending.pop().fail(NONE_STARTS)

    def _started(self, index: int) -> WorkerProcess:
        return WorkerProcess(
            index, self._context, self._given, self._file, self._received, self._ended
        )
