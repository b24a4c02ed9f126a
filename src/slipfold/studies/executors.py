"""Where tasks run: in this process, in several, or on a cluster, by one protocol."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

from slipfold.errors import InputError
from slipfold.threads import cores, take_one_thread


class Place:
    """An executor with what the protocol does not tell: how many tasks it takes at once."""

    def __init__(self, executor: Executor, slots: Callable[[], int], name: str) -> None:
        self.executor, self.slots, self.name = executor, slots, name


@contextmanager
def open_place(given: Executor | int | str | None) -> Iterator[Place]:
    """Open what tasks run on: None is this process, a number so many, a text a scheduler."""
    if given is None:
        yield Place(_Here(), lambda: 1, "this process")
    elif isinstance(given, str):
        from slipfold.studies.cluster import connected

        with connected(given) as (executor, slots):
            yield Place(executor, slots, f"the cluster at {given}")
    elif isinstance(given, Executor):
        count = getattr(given, "_max_workers", None) or cores()
        yield Place(given, lambda: 2 * count, type(given).__name__)
    elif type(given) is int and given >= 1:
        pool = _Processes(given)
        try:
            yield Place(pool, lambda: 2 * given, f"{given} processes")
        finally:
            pool.shutdown()
    else:
        raise InputError(
            f"executor = {given!r} is nothing that cases can run on; give a number of processes, "
            "the address of a scheduler such as tcp://127.0.0.1:8786, or an executor of "
            "concurrent.futures"
        )


class _Here(Executor):
    """The process itself: a task is done when it has been submitted."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Do it."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class _Processes(Executor):
    """Processes of this machine; where one dies, the next task goes to new ones."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._pool: ProcessPoolExecutor | None = None
        self._leash: Connection | None = None

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand it to a process."""
        if self._pool is not None:
            try:
                return self._pool.submit(fn, *args, **kwargs)
            except BrokenExecutor:
                self.shutdown()
        self._pool = self._begin()
        return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes at once, whatever they are doing."""
        if self._leash is not None:
            self._leash.close()
            self._leash = None
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
            self._pool = None

    def _begin(self) -> ProcessPoolExecutor:
        # Integrators run threads, and a fork of a process with threads may hang.
        context = get_context("spawn")
        held, self._leash = context.Pipe(duplex=False)
        return ProcessPoolExecutor(self._count, context, _begin_worker, (held,))


def _begin_worker(leash: Connection) -> None:
    """Leave signals to the process in charge; end when that lets go of the leash, or dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    take_one_thread()

    def follow() -> None:
        leash.poll(None)
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
