"""A Dask cluster as an executor."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager, suppress
from functools import partial
from time import monotonic
from typing import Any

from slipfold.errors import InputError

PATIENCE = 10.0
"""Seconds in which a scheduler has to answer."""

LOGGERS = ("distributed", "distributed.client", "tornado.application")
"""Loggers of Dask with handlers of their own, which write tracebacks where a connection ends."""

ASKED_AFTER = 2.0
"""Seconds between questions how many workers there are."""


@contextmanager
def connected(address: str) -> Iterator[tuple[Executor, Callable[[], int]]]:
    """Connect to a scheduler; tell how many tasks its workers take at the moment."""
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
            client: Any = connect(address, timeout=PATIENCE, set_as_default=False)
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
    """Tasks that are read only where they are done, as a task's first step.

    What a worker lacks is then an error of the task, which reaches the study. A worker that Dask
    has read a task it cannot read ends, and gets its tasks again when it comes back, for ever.
    """

    def __init__(self, executor: Executor) -> None:
        self._executor = executor

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Send what, when it is read, has been done."""
        # As Dask writes it: what a script defines itself goes along.
        from distributed.protocol import pickle

        written: Any = pickle
        call = _Call(partial(fn, *args, **kwargs))
        return self._executor.submit(written.loads, written.dumps(call))


class _Call:
    """A call that is made when it is unpickled: what is read is what it returns."""

    def __init__(self, call: Callable[[], Any]) -> None:
        self._call = call

    def __reduce__(self) -> tuple[Callable[[], Any], tuple[()]]:
        return self._call, ()


class _Slots:
    """How many tasks keep all workers busy; workers come and go."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._asked, self._count = -math.inf, 2

    def __call__(self) -> int:
        """Return how many; the scheduler is not asked all the time."""
        if monotonic() - self._asked > ASKED_AFTER:
            # A scheduler that is gone tells by cancelling what it had.
            with suppress(OSError):
                self._count = 2 * max(1, sum(self._client.nthreads().values()))
            self._asked = monotonic()
        return self._count
