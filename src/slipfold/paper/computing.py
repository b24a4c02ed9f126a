"""Computing and drawing in one process or several, and stopping with what is finished."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any


class Tasks:
    """Functions that wait for a free process; no more are handed over than processes are free."""

    def __init__(self, executor: Executor, processes: int) -> None:
        self._executor = executor
        self._processes = processes
        self._waiting: list[tuple[Any, Callable[..., Any], tuple[Any, ...]]] = []
        self._running: dict[Future[Any], Any] = {}

    def add(self, name: Any, function: Callable[..., Any], *arguments: Any) -> None:
        """Put a function in the queue."""
        self._waiting.append((name, function, arguments))

    def finished(self) -> Iterator[tuple[Any, Any]]:
        """Yield name and result of each function as it ends, until none is left.

        Functions may be added meanwhile.
        """
        while self._waiting or self._running:
            while self._waiting and len(self._running) < self._processes:
                name, function, arguments = self._waiting.pop(0)
                self._running[self._executor.submit(function, *arguments)] = name
            done, _ = wait(self._running, return_when=FIRST_COMPLETED)
            for future in [item for item in self._running if item in done]:
                yield self._running.pop(future), future.result()

    def stop(self) -> Iterator[tuple[Any, Any]]:
        """Forget what waits, and yield name and result of what is running until it ends."""
        self._waiting.clear()
        yield from self.finished()


class _InThisProcess(Executor):
    """Runs each function at once, here."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


@contextmanager
def open_tasks(processes: int) -> Iterator[Tasks]:
    """Open a queue of functions to compute."""
    if processes == 1:
        yield Tasks(_InThisProcess(), 1)
        return
    # Not forked: threads of numerical libraries do not survive a fork.
    context = multiprocessing.get_context("spawn")
    executor = ProcessPoolExecutor(processes, context, initializer=_ignore_interrupts)
    try:
        _start(executor)
        yield Tasks(executor, processes)
    finally:
        executor.shutdown(wait=True, cancel_futures=True)


def _start(executor: Executor) -> None:
    """Start the processes with Ctrl-C blocked, which they inherit: it could hit them early."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        return
    # It unblocks the signal itself when it starts, so it has to be there before.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        executor.submit(_ignore_interrupts)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _ignore_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
