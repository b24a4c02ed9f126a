"""How long a study may take, from a few of its cases."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from slipfold.studies.cases import total
from slipfold.studies.plan import Plan
from slipfold.studies.task import Task, compute, versions
from slipfold.studies.work.work import Work

MOST = 6
"""Cases tried at most, spread over all of them."""

ENOUGH = 2.0
"""Seconds after which no other case is tried."""


@dataclass(frozen=True)
class Estimate:
    """What a few cases took, in one process, after the first one: that compiles, too."""

    tried: int
    seconds: float  # a case
    failures: tuple[str, ...]  # why some of them failed
    beside: bool  # whether cases of the study go side by side, which takes less


def estimate(plan: Plan) -> Estimate:
    """Compute a few cases, and keep nothing but the time they take."""
    count = total(plan.cases)
    begun = perf_counter()
    times: list[float] = []
    failures: list[str] = []
    for number in np.unique(np.linspace(0, count - 1, min(MOST, count)).astype(int)).tolist():
        values = plan.cases.values(np.array([number]))
        names, alone = plan.cases.names, plan.work.together_from > 1
        task = Task(plan.model, plan.work, names, (number,), values, versions(), not alone)
        done = compute(task)
        times.append(done.seconds)
        failures += [record["failed"] for record in done.records if "failed" in record]
        if len(times) > 1 and perf_counter() - begun > ENOUGH:
            break
    able = type(plan.work).together is not Work.together
    beside = able and count >= max(plan.work.together_from, 2)
    return Estimate(len(times), float(np.mean(times[1:] or times)), tuple(failures), beside)
