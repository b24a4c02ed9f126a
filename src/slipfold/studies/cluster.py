"""A Dask cluster as an executor."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager, suppress
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from time import monotonic
from typing import Any

from slipfold.errors import InputError

__all__ = ["connected"]

PATIENCE = 10.0
"""Seconds in which a scheduler has to answer."""

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
    try:
        client: Any = connect(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            f"no scheduler answers at {address} ({error}); start one with dask scheduler, or give "
            "another address"
        ) from None

    with client, client.get_executor(pure=False) as executor:
        yield executor, _Slots(client, address)


class _Slots:
    """How many tasks keep all workers busy; workers come and go."""

    def __init__(self, client: Any, address: str) -> None:
        self._client, self._address = client, address
        self._asked, self._count = -math.inf, 2
        self._known: set[str] = set()  # workers that have slipfold

    def __call__(self) -> int:
        """Return how many; the scheduler is not asked all the time."""
        if monotonic() - self._asked > ASKED_AFTER:
            # A scheduler that is gone tells by cancelling what it had.
            with suppress(OSError):
                threads = self._client.nthreads()
                self._count = 2 * max(1, sum(threads.values()))
                self._check(sorted(set(threads) - self._known))
            self._asked = monotonic()
        return self._count

    def _check(self, workers: list[str]) -> None:
        """Refuse workers without slipfold: Dask gives them tasks again and again, for ever."""
        if not workers:
            return
        found = self._client.run(find_spec, "slipfold", workers=workers, on_error="return")
        lacking = [worker for worker, spec in found.items() if spec is None]
        if lacking:
            raise InputError(
                f"the worker {lacking[0]} of the cluster at {self._address} has no slipfold; "
                "install the same versions of slipfold and its packages everywhere"
            )
        # Who did not answer, since it only just begins or ends, is asked again.
        self._known |= {worker for worker, spec in found.items() if isinstance(spec, ModuleSpec)}
