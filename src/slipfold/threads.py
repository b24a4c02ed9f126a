"""How many threads there may be, and how many of them linear algebra takes."""

from __future__ import annotations

import os

VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def take_one_thread() -> None:
    """Have linear algebra loaded from now on take one thread, unless the user says otherwise.

    The matrices are small: waking other threads takes longer than the work, and where several
    processes share the cores they wait for each other.
    """
    for variable in VARIABLES:
        os.environ.setdefault(variable, "1")


def cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
