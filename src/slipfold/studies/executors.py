"""Executors of tasks: this process, several processes, or a Dask cluster, by one protocol."""

from __future__ import annotations

import logging
import math
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing import Pipe, get_context, resource_tracker
from multiprocessing.connection import Connection
from time import monotonic
from typing import Any

import heyoka as hy

from slipfold.errors import InputError
from slipfold.threads import VARIABLES, cores, take_one_thread

LOGGERS = ("distributed", "distributed.client", "tornado.application")
"""Loggers of Dask with handlers of their own, which write tracebacks where a connection ends."""


class TASKS:
    """How cases are packed into tasks, and how long is waited for them."""

    seconds: float = 0.25  # desired duration of a task: the loss when a process is killed
    cases: int = 4096  # maximum number of cases of a task
    growth: int = 4  # maximum factor by which tasks grow: the first cases also compile
    estimate_cases: int = 6  # maximum number of cases tried for an estimate, spread over all
    estimate_seconds: float = 2.0  # time after which no other case is tried
    attempts: int = 3  # processes that may die with a case before it is given up
    poll: float = 0.2  # seconds after which a wait starts again
    scheduler_timeout: float = 10.0  # seconds in which a scheduler has to answer
    slots_interval: float = 2.0  # seconds between questions for the number of workers


class OpenExecutor:
    """An executor, its name, and the number of tasks that keep it busy."""

    def __init__(self, executor: Executor, slots: Callable[[], int], name: str) -> None:
        self.executor, self.slots, self.name = executor, slots, name


@contextmanager
def open_executor(given: Executor | int | str | None) -> Iterator[OpenExecutor]:
    """Open what tasks run on: None is this process, a number so many, a text a scheduler."""
    if given is None:
        yield OpenExecutor(_ThisProcess(), lambda: 1, "this process")
    elif isinstance(given, str):
        with connected(given) as (executor, slots):
            yield OpenExecutor(executor, slots, f"the cluster at {given}")
    elif isinstance(given, Executor):
        count = getattr(given, "_max_workers", None) or cores()
        yield OpenExecutor(given, lambda: 2 * count, type(given).__name__)
    elif type(given) is int and given >= 1:
        pool = _Processes(given)
        try:
            yield OpenExecutor(pool, lambda: 2 * given, f"{given} processes")
        finally:
            pool.shutdown()
    else:
        raise InputError(
            f"executor = {given!r} is not a valid executor; give a number of processes, "
            "the address of a scheduler such as tcp://127.0.0.1:8786, or an executor of "
            "concurrent.futures"
        )


class _ThisProcess(Executor):
    """The present process: a task is computed when it is submitted."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Do it."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class _Processes(Executor):
    """Processes of this machine; after one dies, the next task goes to new ones."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._pool: ProcessPoolExecutor | None = None
        self._leash: Connection | None = None

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand it to a process."""
        with _starting():  # the task may be what starts it
            if self._pool is not None:
                try:
                    return self._pool.submit(fn, *args, **kwargs)
                except BrokenExecutor:
                    self.shutdown()
            # Integrators run threads, and a fork of a process with threads may hang.
            held, self._leash = Pipe(duplex=False)
            spawn = get_context("spawn")
            self._pool = ProcessPoolExecutor(self._count, spawn, _begin_worker, (held,))
            return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes at once, whatever they are doing."""
        if self._leash is not None and self._pool is not None:
            self._leash.close()
            self._pool.shutdown(cancel_futures=True)
            self._leash = self._pool = None


@contextmanager
def _starting() -> Iterator[None]:
    """Give processes one thread before they import NumPy; block Ctrl-C until they can ignore it."""
    added = [name for name in VARIABLES if name not in os.environ]
    masks = hasattr(signal, "pthread_sigmask")  # not on Windows
    if masks:
        # It unblocks the signal itself when it starts, so it has to be there before.
        resource_tracker.ensure_running()
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        take_one_thread()
        yield
    finally:
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        for name in added:
            os.environ.pop(name, None)


def _begin_worker(leash: Connection) -> None:
    """Leave signals to the main process; end when that closes its end of the pipe, or dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    # It would evaluate functions of many states in threads that wait busily for more.
    hy.set_nthreads(1)

    def follow() -> None:
        leash.poll(None)
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


@contextmanager
def connected(address: str) -> Iterator[tuple[Executor, Callable[[], int]]]:
    """Connect to a scheduler; yield an executor and the number of tasks that its workers take."""
    try:
        from distributed import Client
    except ImportError:
        raise InputError(
            "studies on a cluster need the packages of the extra 'cluster'; install them with "
            "pip install 'slipfold[cluster]'"
        ) from None
    connect: Any = Client
    with _unlogged():  # what goes wrong reaches the study, which says it in a sentence
        try:
            client: Any = connect(address, timeout=TASKS.scheduler_timeout, set_as_default=False)
        except (OSError, ValueError) as error:
            raise InputError(
                f"no scheduler answers at {address} ({error}); start one with dask scheduler, or "
                "give another address"
            ) from None

        with client, client.get_executor(pure=False) as executor:
            yield _Unread(executor), _Slots(client)


@contextmanager
def _unlogged() -> Iterator[None]:
    """Keep Dask from logging to standard error."""
    levels = {name: logging.getLogger(name).level for name in LOGGERS}
    try:
        for name in levels:
            logging.getLogger(name).setLevel(logging.CRITICAL)
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)


class _Unread(Executor):
    """Tasks that are unpickled only where they are computed, as their first step.

    A module that a worker lacks is then an error of the task, which reaches the study. Otherwise a
    worker that cannot unpickle a task ends, and gets its tasks again when it is restarted, forever.
    """

    def __init__(self, executor: Executor) -> None:
        self._executor = executor

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Send a call that is made when it is unpickled."""
        # As Dask writes it: functions that a script defines are included.
        from distributed.protocol import pickle

        written: Any = pickle
        call = _Call(partial(fn, *args, **kwargs))
        return self._executor.submit(written.loads, written.dumps(call))


class _Call:
    """A call that is made when it is unpickled, which gives its result."""

    def __init__(self, call: Callable[[], Any]) -> None:
        self._call = call

    def __reduce__(self) -> tuple[Callable[[], Any], tuple[()]]:
        return self._call, ()


class _Slots:
    """Number of tasks that keep all workers busy; workers may join and leave."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._updated, self._count = -math.inf, 2

    def __call__(self) -> int:
        """Return the number; the scheduler is not asked every time."""
        if monotonic() - self._updated > TASKS.slots_interval:
            # A scheduler that is gone cancels its tasks.
            with suppress(OSError):
                self._count = 2 * max(1, sum(self._client.nthreads().values()))
            self._updated = monotonic()
        return self._count
