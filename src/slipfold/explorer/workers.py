"""The worker processes, and which of them computes what and when."""

from __future__ import annotations

import asyncio
import itertools
import multiprocessing
from pathlib import Path

from slipfold.explorer.job import SLOW, Job
from slipfold.explorer.limits import Limits
from slipfold.explorer.process import GRACE, WorkerProcess
from slipfold.explorer.worker import READY, Reply
from slipfold.models.model import Model

FAILED_STARTS = 3
"""Workers in a row that end before they are ready, after which no more are started."""

KILLED = (
    "the worker process that computed this was ended from outside ({code}), perhaps for want of "
    "memory; a fresh one takes its place, so ask again"
)


class Workers:
    """A few processes that compute jobs; to be used from one event loop.

    `given` is a model beside the built-in ones, `file` that with its equations, if it has one.
    """

    def __init__(
        self, given: Model | None, count: int, limits: Limits, file: Path | None = None
    ) -> None:
        self._given, self._file = given, file
        self._count = count
        self._limits = limits
        self._context = multiprocessing.get_context("spawn")
        self._numbers = itertools.count(READY + 1)
        self._pending: list[Job] = []
        self._workers: list[WorkerProcess] = []
        self._failed_starts = 0
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
        job.place = instead_of.place if waiting and instead_of is not None else job.number
        if instead_of is not None:
            self.cancel(instead_of)
        if self._failed_starts >= FAILED_STARTS:
            job.fail("no worker process can be started; the terminal of slipfold explore says why")
            return
        self._pending.append(job)
        self._dispatch()

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

    def _choose(self, job: Job) -> WorkerProcess | None:
        """Return a free worker for a job: that of its client, or any that is not."""
        home = self._workers[job.home % self._count]
        idle = [worker for worker in self._workers if worker.idle]
        if job.kind in SLOW:
            # Such jobs take seconds: the client's own worker, and one of all, stay free of them.
            others = [worker for worker in idle if worker is not home]
            slow = sum(
                worker.job is not None and worker.job.kind in SLOW for worker in self._workers
            )
            if self._count > 1:
                return others[0] if others and slow < self._count - 1 else None
        if home.idle or home.dropping:
            return home if home.idle else None
        return idle[0] if idle else None

    def _hand_over(self, job: Job, worker: WorkerProcess) -> None:
        loop = asyncio.get_running_loop()
        seconds = self._limits.seconds[job.kind]
        worker.timer = loop.call_later(seconds, self._too_long, worker, job, seconds)
        worker.give(job)

    def _too_long(self, worker: WorkerProcess, job: Job, seconds: float) -> None:
        if worker.job is not job:
            return
        if not job.cancelled:
            job.cancelled = True
            job.fail(
                f"this took more than {seconds:g} s and was given up; ask for less, e.g. a "
                "narrower span"
            )
        worker.drop()
        loop = asyncio.get_running_loop()
        loop.call_later(GRACE, lambda: worker.kill() if worker.job is job else None)

    # -- what workers say ----------------------------------------------------------------------

    def _heard(self, worker: WorkerProcess, reply: Reply) -> None:
        if reply.number == READY:
            worker.ready = True
            self._failed_starts = 0
        elif worker.job is not None and worker.job.number == reply.number:
            job = worker.job
            if reply.last:
                worker.finish()
                self._replace_if_large(worker)
            if not job.cancelled:
                job.deliver(reply)
        if worker.idle:
            self._dispatch()

    def _ended(self, worker: WorkerProcess) -> None:
        """Put a fresh worker in the place of one that has ended."""
        if self._stopping or worker not in self._workers:
            return
        worker.end()
        job, code = worker.job, worker.process.exitcode
        worker.finish()
        self._failed_starts += not worker.ready
        lasting = self._failed_starts >= FAILED_STARTS
        if not lasting:
            self._workers[worker.index] = self._started(worker.index)
        if job is not None and not job.cancelled:
            job.cancelled = True
            how = f"signal {-code}" if code is not None and code < 0 else f"exit status {code}"
            job.fail(KILLED.format(code=how), again=True)
        if lasting:
            self._give_up()

    def _give_up(self) -> None:
        waiting, self._pending = self._pending, []
        for job in waiting:
            job.fail("no worker process can be started; the terminal of slipfold explore says why")

    def _replace_if_large(self, worker: WorkerProcess) -> None:
        if worker.resident_bytes() > self._limits.worker_bytes:
            self._workers[worker.index] = self._started(worker.index)
            worker.ask_to_stop()

    def _started(self, index: int) -> WorkerProcess:
        return WorkerProcess(
            index, self._context, self._given, self._file, self._heard, self._ended
        )
