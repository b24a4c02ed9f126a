"""Compute the missing cases of a study and store them, even if single cases fail."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import BREAKDOWNS, InputError, breakdown
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress, duration_text
from slipfold.studies.executors import TASKS, OpenExecutor
from slipfold.studies.plan import Plan, total
from slipfold.studies.store import Record, Store
from slipfold.studies.works import CaseValues, Work
from slipfold.version import versions


@dataclass(frozen=True, eq=False)
class StudyTask:
    """Cases to compute, with all the data needed."""

    model: Model
    work: Work
    names: tuple[str, ...]  # of the parameters that differ
    numbers: tuple[int, ...]
    values: NDArray[np.float64]  # of those parameters, shape (n_cases, n_names)
    versions: dict[str, str]  # of the programs of the main process
    # Whether cases are batched as far as possible: a property of the study, not of the task, since
    # the last digits differ
    together: bool = True


@dataclass(frozen=True)
class Done:
    """The result of a task."""

    records: tuple[Record, ...]
    seconds: float


def compute(task: StudyTask) -> Done:
    """Compute every case of a task; one that fails says why."""
    if versions() != task.versions:
        here = ", ".join(f"{name} {version}" for name, version in versions().items())
        there = ", ".join(f"{name} {version}" for name, version in task.versions.items())
        raise InputError(
            f"a worker has {here}, but the study was started with {there}, and last digits would "
            "differ; install the same versions everywhere"
        )
    started = perf_counter()
    cases = [dict(zip(task.names, row, strict=True)) for row in task.values.tolist()]
    batched = _together(task, cases) if task.together else {}
    records = tuple(
        _record(task, number, given, batched.get(index))
        for index, (number, given) in enumerate(zip(task.numbers, cases, strict=True))
    )
    return Done(records, perf_counter() - started)


def _together(task: StudyTask, cases: Sequence[dict[str, float]]) -> dict[int, CaseValues]:
    """Return the findings of batched cases by index; the others are computed individually."""
    models = dict[int, Model]()
    for index, given in enumerate(cases):
        with suppress(InputError):  # reported when the case itself is computed
            models[index] = task.model.replace(**given)
    try:
        results = task.work.together(list(models.values())) if models else []
    except Exception:  # reported when the case itself is computed
        return {}
    return {index: item for index, item in zip(models, results, strict=True) if item is not None}


def _record(
    task: StudyTask, number: int, given: dict[str, float], values: CaseValues | None = None
) -> Record:
    try:
        values = values or task.work.compute(task.model.replace(**given))
    except BREAKDOWNS as error:
        return failure(number, given, breakdown(error))
    # A defect of the program that one case lays bare is to be reported, and stops no others.
    except Exception as error:
        return failure(number, given, f"slipfold failed ({type(error).__name__}: {error})")
    record: Record = {"case": number, "found": values.values}
    return record | {"listed": list(values.listed)} if values.listed else record


def failure(number: int, given: dict[str, float], reason: str) -> Record:
    """Return the record of a case that failed."""
    return {"case": number, "failed": reason, "given": given}


class Groups:
    """Numbers of cases in order, cut into groups by the measured time of a case.

    Groups have at minimum `minimum` cases.

    >>> groups = Groups(range(10))
    >>> groups.next(), groups.next()
    ((0,), (1,))
    >>> groups.learn(1, 0.08)
    >>> groups.next()
    (2, 3, 4)
    """

    def __init__(self, numbers: Iterable[int], minimum: int = 1) -> None:
        self._numbers = iter(numbers)
        self._minimum = self.size = minimum

    def next(self) -> tuple[int, ...]:
        """Return the next group; an empty one at the end."""
        return tuple(islice(self._numbers, self.size))

    def learn(self, count: int, seconds: float) -> None:
        """Record the time of a group."""
        wanted = int(TASKS.seconds * count / max(seconds, 1e-9))
        self.size = max(self._minimum, min(wanted, TASKS.growth * self.size, TASKS.cases))


@dataclass(frozen=True)
class _Group:
    """Cases that are computed together."""

    numbers: tuple[int, ...]
    attempts: int = 0  # how many processes died with them

    def parts(self) -> list[_Group]:
        """Return the groups to try next, one at a time, to find the case that killed a process."""
        attempts, half = self.attempts + 1, len(self.numbers) // 2
        if attempts < TASKS.attempts or not half:
            return [_Group(self.numbers, attempts)]
        return [_Group(self.numbers[:half], 1), _Group(self.numbers[half:], 1)]


def first_finished(
    futures: Collection[Future[Done]], slots: Callable[[], int]
) -> set[Future[Done]]:
    """Wait until a task is finished, in short intervals, as an interrupt does not end a wait.

    Counting slots raises if the executor is gone.
    """
    while True:
        slots()
        finished = wait(futures, TASKS.poll, FIRST_COMPLETED).done
        if finished:
            return finished


class StudyRun:
    """The cases that the store of a study lacks, while they are computed."""

    def __init__(
        self, plan: Plan, store: Store, executor: OpenExecutor, observer: Observer | None
    ) -> None:
        self._plan, self._store, self._observer = plan, store, observer
        self._executor = executor
        self._running: dict[Future[Done], _Group] = {}
        self._alone: deque[_Group] = deque()  # one of these killed a process
        self._together = store.total >= plan.work.together_from
        self._start = perf_counter()
        self._computed = 0

    def run(self, retry_failed: bool) -> None:
        """Keep as many tasks running as the executor takes; raise KeyboardInterrupt if stopped."""
        again = self._store.failures if retry_failed else 0
        self._wanted = self._store.total - self._store.done + again
        least, most = self._plan.work.side_by_side if self._together else (1, 1)
        share = self._wanted // max(self._executor.slots(), 1)
        missing = self._store.missing(failed=retry_failed)
        self._groups = Groups(missing, min(max(least, share), most))
        try:
            self._report()
            while self._send():
                self._store_results(first_finished(self._running, self._executor.slots))
                self._report()
        except KeyboardInterrupt:
            self._store_finished()
            if self._computed < self._wanted:
                raise
        except (BrokenExecutor, CancelledError):  # given by the caller, and not started again
            self._store_finished()
            raise InputError(f"{self._executor.name} is gone; {self._store.prospect()}") from None
        finally:
            for future in self._running:
                future.cancel()

    def _store_results(self, finished: Iterable[Future[Done]]) -> None:
        """Store the results of finished tasks, then raise the first error."""
        records: list[Record] = []
        wrong: list[BaseException] = []
        for future in finished:
            try:
                records += self._taken(future, self._running.pop(future))
            except BaseException as error:
                wrong.append(error)
        # Together, as the disk takes as long for one as for many.
        self._store.add(records)
        self._computed += len(records)
        if wrong:
            raise wrong[0]

    def _store_finished(self) -> None:
        """Store what is finished without waiting for more."""
        self._store_results(
            [
                future
                for future in self._running
                if future.done() and not future.cancelled() and future.exception() is None
            ]
        )

    def _send(self) -> bool:
        """Submit as many tasks as fit; return whether any is running."""
        if self._alone:
            if not self._running:
                self._submit(self._alone.popleft())
            return True
        while len(self._running) < self._executor.slots():
            numbers = self._groups.next()
            if not numbers:
                break
            self._submit(_Group(numbers))
        return bool(self._running)

    def _submit(self, group: _Group) -> None:
        plan = self._plan
        values = plan.cases.values(np.array(group.numbers))
        names, together = plan.cases.names, self._together
        task = StudyTask(plan.model, plan.work, names, group.numbers, values, versions(), together)
        self._running[self._executor.executor.submit(compute, task)] = group

    def _taken(self, future: Future[Done], group: _Group) -> Sequence[Record]:
        """Return the records of a task."""
        try:
            done = future.result()
        except BrokenExecutor:
            return self._retry(group)
        except Exception as error:
            # A scheduler of Dask that cannot unpickle a task gives the reason only as the cause.
            missing = error if isinstance(error, ModuleNotFoundError) else error.__cause__
            if isinstance(missing, ModuleNotFoundError):
                raise InputError(
                    f"{self._executor.name} lacks what a study needs ({missing}); install the same "
                    "versions of slipfold and its packages everywhere"
                ) from error
            if type(error).__name__ != "KilledWorker":  # of Dask, which may not be installed
                raise
            return self._retry(group)
        self._groups.learn(len(done.records), done.seconds)
        return done.records

    def _retry(self, group: _Group) -> Sequence[Record]:
        """Retry cases with which a process died; give up a single case after several attempts."""
        if len(group.numbers) == 1 and group.attempts + 1 >= TASKS.attempts:
            (number,) = group.numbers
            (row,) = self._plan.cases.values(np.array([number])).tolist()
            given = dict(zip(self._plan.cases.names, row, strict=True))
            reason = (
                f"the process that computed it ended {TASKS.attempts} times without a "
                "message: killed, perhaps for lack of memory"
            )
            return [failure(number, given, reason)]
        self._alone.extend(group.parts())
        return ()

    def _report(self) -> None:
        if self._observer is None:
            return
        done, total, failures = self._store.done, self._store.total, self._store.failures
        text, values = f"{failures} failed", dict[str, float]({"failures": failures})
        if self._computed:
            rate = self._computed / (perf_counter() - self._start)
            remaining = (self._wanted - self._computed) / rate
            text += f"  {rate:.3g} a second  {duration_text(remaining)} to go"
            values |= {"rate": rate, "remaining": remaining}
        self._observer(Progress("cases", done, total, text, values))


@dataclass(frozen=True)
class TimeEstimate:
    """Time of a few cases in one process, without the first, which also compiles."""

    tried: int
    seconds: float  # a case
    failures: tuple[str, ...]  # why some of them failed
    batched: bool  # whether cases of the study are batched, which takes less


def estimate(plan: Plan) -> TimeEstimate:
    """Compute a few cases for the time they take."""
    count = total(plan.cases)
    started = perf_counter()
    times: list[float] = []
    failures: list[str] = []
    chosen = np.linspace(0, count - 1, min(TASKS.estimate_cases, count)).astype(int)
    for number in np.unique(chosen).tolist():
        values = plan.cases.values(np.array([number]))
        names, alone = plan.cases.names, plan.work.together_from > 1
        task = StudyTask(plan.model, plan.work, names, (number,), values, versions(), not alone)
        done = compute(task)
        times.append(done.seconds)
        failures += [record["failed"] for record in done.records if "failed" in record]
        if len(times) > 1 and perf_counter() - started > TASKS.estimate_seconds:
            break
    able = type(plan.work).together is not Work.together
    batched = able and count >= max(plan.work.together_from, 2)
    return TimeEstimate(len(times), float(np.mean(times[1:] or times)), tuple(failures), batched)
