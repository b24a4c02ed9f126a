"""Some cases together as one task: what goes to whoever computes them, and what comes back."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import BREAKDOWNS, InputError, breakdown
from slipfold.models.model import Model
from slipfold.studies.work.work import Findings, Work
from slipfold.version import package_version

Record = dict[str, Any]
"""A finished case as plain data: its number, and what was found or why it failed."""


@dataclass(frozen=True, eq=False)
class Task:
    """Cases to compute, with all that takes."""

    model: Model
    work: Work
    names: tuple[str, ...]  # of the parameters that differ
    numbers: tuple[int, ...]
    values: NDArray[np.float64]  # of those parameters, shape (n_cases, n_names)
    versions: dict[str, str]  # of the programs of whoever wants it
    # Whether cases go side by side, as far as they can: a matter of the study, not of the task,
    # since the last digits differ
    together: bool = True


@dataclass(frozen=True)
class Done:
    """What a task came to."""

    records: tuple[Record, ...]
    seconds: float


def compute(task: Task) -> Done:
    """Compute every case of a task; one that fails says why."""
    if versions() != task.versions:
        told = ", ".join(f"{name} {version}" for name, version in versions().items())
        wanted = ", ".join(f"{name} {version}" for name, version in task.versions.items())
        raise InputError(
            f"a worker has {told}, but the study was begun with {wanted}, and last digits would "
            "differ; install the same versions everywhere"
        )
    started = perf_counter()
    cases = [dict(zip(task.names, row, strict=True)) for row in task.values.tolist()]
    known = _together(task, cases) if task.together else {}
    records = tuple(
        _record(task, number, given, known.get(place))
        for place, (number, given) in enumerate(zip(task.numbers, cases, strict=True))
    )
    return Done(records, perf_counter() - started)


def _together(task: Task, cases: Sequence[dict[str, float]]) -> dict[int, Findings]:
    """Return what is found of cases side by side, by their places; the others go by themselves."""
    models = dict[int, Model]()
    for place, given in enumerate(cases):
        with suppress(InputError):  # said of the case when its turn comes
            models[place] = task.model.replace(**given)
    try:
        found = task.work.together(list(models.values())) if models else []
    except Exception:  # whichever case it is, by itself it says so
        return {}
    return {place: item for place, item in zip(models, found, strict=True) if item is not None}


def _record(
    task: Task, number: int, given: dict[str, float], found: Findings | None = None
) -> Record:
    try:
        found = found or task.work.of(task.model.replace(**given))
    except InputError as error:
        return failure(number, given, str(error))
    except BREAKDOWNS as error:
        return failure(number, given, breakdown(error))
    # A defect of the program that one case lays bare is to be reported, and stops no others.
    except Exception as error:
        return failure(number, given, f"slipfold failed ({type(error).__name__}: {error})")
    record: Record = {"case": number, "found": found.values}
    return record | {"listed": list(found.listed)} if found.listed else record


def failure(number: int, given: dict[str, float], reason: str) -> Record:
    """Return what is kept of a case that failed."""
    return {"case": number, "failed": reason, "given": given}


@cache
def versions() -> dict[str, str]:
    """Return the versions of whatever last digits depend on."""
    import heyoka
    import numpy
    import scipy

    return {
        "slipfold": package_version(),
        "heyoka": heyoka.__version__,
        "numpy": numpy.__version__,
        "scipy": scipy.__version__,
        "python": platform.python_version(),
    }
