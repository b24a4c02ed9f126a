"""All missing cases of a study computed and kept, whatever becomes of single ones."""

from __future__ import annotations

import platform
from collections import deque
from collections.abc import Callable, Collection, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from itertools import islice
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import BREAKDOWNS, InputError, breakdown
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress, duration_text
from slipfold.studies.executors import OpenExecutor
from slipfold.studies.plan import Plan, total
from slipfold.studies.store import Record, Store
from slipfold.studies.works import Findings, Work
from slipfold.version import package_version

AIM = 0.25
"""Seconds that are aimed at: what is lost when a process is killed."""

LARGEST = 4096
"""Cases of the largest task."""

GROWTH = 4
"""Factor by which tasks grow at most: the first cases also compile."""

MOST = 6
"""Cases tried at most, spread over all of them."""

ENOUGH = 2.0
"""Seconds after which no other case is tried."""

ATTEMPTS = 3
"""How often a process may die with the same cases before it is their fault."""


LOOK_UP = 0.2
"""Seconds after which a wait is begun anew."""


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


class Groups:
    """Numbers of cases in their order, cut into groups as it becomes known how long cases take.

    Groups have at least so many.

    >>> groups = Groups(range(10))
    >>> groups.next(), groups.next()
    ((0,), (1,))
    >>> groups.learn(1, 0.08)
    >>> groups.next()
    (2, 3, 4)
    """

    def __init__(self, numbers: Iterable[int], least: int = 1) -> None:
        self._numbers = iter(numbers)
        self._least = self.size = least

    def next(self) -> tuple[int, ...]:
        """Return the next group; an empty one at the end."""
        return tuple(islice(self._numbers, self.size))

    def learn(self, count: int, seconds: float) -> None:
        """Take note of how long a group took."""
        wanted = int(AIM * count / max(seconds, 1e-9))
        self.size = max(self._least, min(wanted, GROWTH * self.size, LARGEST))


@dataclass(frozen=True)
class _Group:
    """Cases that are computed together."""

    numbers: tuple[int, ...]
    attempts: int = 0  # how many processes died with them

    def parts(self) -> list[_Group]:
        """Return what to try next after a process died, alone, so that it is known by what."""
        attempts, half = self.attempts + 1, len(self.numbers) // 2
        if attempts < ATTEMPTS or not half:
            return [_Group(self.numbers, attempts)]
        return [_Group(self.numbers[:half], 1), _Group(self.numbers[half:], 1)]


def run_cases(
    plan: Plan,
    store: Store,
    executor: OpenExecutor,
    observer: Observer | None = None,
    retry_failed: bool = False,
) -> None:
    """Compute the cases that a store lacks; KeyboardInterrupt if it was stopped before that."""
    _Run(plan, store, executor, observer).run(retry_failed)


def first_finished(
    futures: Collection[Future[Done]], slots: Callable[[], int]
) -> set[Future[Done]]:
    """Wait until something is finished; look up now and then, as an interrupt does not wake.

    Whether there is still somebody who can finish anything shows when slots are counted.
    """
    while True:
        slots()
        found = wait(futures, LOOK_UP, FIRST_COMPLETED).done
        if found:
            return found


class _Run:
    """Cases on their way."""

    def __init__(
        self, plan: Plan, store: Store, executor: OpenExecutor, observer: Observer | None
    ) -> None:
        self._plan, self._store, self._observer = plan, store, observer
        self._executor = executor
        self._flying: dict[Future[Done], _Group] = {}
        self._alone: deque[_Group] = deque()  # one of these killed a process
        self._together = store.total >= plan.work.together_from
        self._begun = perf_counter()
        self._computed = 0

    def run(self, retry_failed: bool) -> None:
        """Keep as many tasks on their way as there is room for."""
        least = self._plan.work.side_by_side if self._together else 1
        self._groups = Groups(self._store.missing(failed=retry_failed), least)
        again = self._store.failures if retry_failed else 0
        self._wanted = self._store.total - self._store.done + again
        try:
            self._tell()
            while self._send():
                self._keep(first_finished(self._flying, self._executor.slots))
                self._tell()
        except KeyboardInterrupt:
            self._keep_finished()
            if self._computed < self._wanted:
                raise
        except (BrokenExecutor, CancelledError):  # somebody else's, which is not begun anew
            self._keep_finished()
            raise InputError(f"{self._executor.name} is gone; {self._store.prospect()}") from None
        finally:
            for future in self._flying:
                future.cancel()

    def _keep(self, finished: Iterable[Future[Done]]) -> None:
        """Keep what finished tasks came to; what went wrong with one of them is raised then."""
        records: list[Record] = []
        wrong: list[BaseException] = []
        for future in finished:
            try:
                records += self._taken(future, self._flying.pop(future))
            except BaseException as error:
                wrong.append(error)
        # Together, as the disk takes as long for one as for many.
        self._store.add(records)
        self._computed += len(records)
        if wrong:
            raise wrong[0]

    def _keep_finished(self) -> None:
        """Keep what is finished where no more is waited for."""
        self._keep(
            [
                future
                for future in self._flying
                if future.done() and not future.cancelled() and future.exception() is None
            ]
        )

    def _send(self) -> bool:
        """Send what there is room for; return whether anything is on its way."""
        if self._alone:
            if not self._flying:
                self._submit(self._alone.popleft())
            return True
        while len(self._flying) < self._executor.slots():
            numbers = self._groups.next()
            if not numbers:
                break
            self._submit(_Group(numbers))
        return bool(self._flying)

    def _submit(self, group: _Group) -> None:
        plan = self._plan
        values = plan.cases.values(np.array(group.numbers))
        names, together = plan.cases.names, self._together
        task = Task(plan.model, plan.work, names, group.numbers, values, versions(), together)
        self._flying[self._executor.executor.submit(compute, task)] = group

    def _taken(self, future: Future[Done], group: _Group) -> Sequence[Record]:
        """Return what a task came to."""
        try:
            done = future.result()
        except BrokenExecutor:
            return self._try_again(group)
        except Exception as error:
            # A scheduler of Dask that cannot read a task tells why only as the cause.
            missing = error if isinstance(error, ModuleNotFoundError) else error.__cause__
            if isinstance(missing, ModuleNotFoundError):
                raise InputError(
                    f"{self._executor.name} lacks what a study needs ({missing}); install the same "
                    "versions of slipfold and its packages everywhere"
                ) from error
            if type(error).__name__ != "KilledWorker":  # of Dask, which may not be installed
                raise
            return self._try_again(group)
        self._groups.learn(len(done.records), done.seconds)
        return done.records

    def _try_again(self, group: _Group) -> Sequence[Record]:
        """Try cases again with which a process died; give one up of which it is known."""
        if len(group.numbers) == 1 and group.attempts + 1 >= ATTEMPTS:
            (number,) = group.numbers
            (row,) = self._plan.cases.values(np.array([number])).tolist()
            given = dict(zip(self._plan.cases.names, row, strict=True))
            reason = (
                f"the process that computed it ended {ATTEMPTS} times without a word: killed, "
                "perhaps for want of memory"
            )
            return [failure(number, given, reason)]
        self._alone.extend(group.parts())
        return ()

    def _tell(self) -> None:
        if self._observer is None:
            return
        done, total, failures = self._store.done, self._store.total, self._store.failures
        text, values = f"{failures} failed", dict[str, float]({"failures": failures})
        if self._computed:
            rate = self._computed / (perf_counter() - self._begun)
            remaining = (self._wanted - self._computed) / rate
            text += f"  {rate:.3g} a second  {duration_text(remaining)} to go"
            values |= {"rate": rate, "remaining": remaining}
        self._observer(Progress("cases", done, total, text, values))


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
