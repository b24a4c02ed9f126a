"""All missing cases of a study computed and kept, whatever becomes of single ones."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from slipfold.errors import InputError
from slipfold.progress import Observer, Progress, duration_text
from slipfold.studies.executors import Place
from slipfold.studies.grouping import Groups
from slipfold.studies.plan import Plan
from slipfold.studies.store import Store
from slipfold.studies.task import Done, Record, Task, compute, failure, versions

ATTEMPTS = 3
"""How often a process may die with the same cases before it is their fault."""


LOOK_UP = 0.2
"""Seconds after which a wait is begun anew."""


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
    place: Place,
    observer: Observer | None = None,
    retry_failed: bool = False,
) -> None:
    """Compute the cases that a store lacks; KeyboardInterrupt if it was stopped before that."""
    _Run(plan, store, place, observer).run(retry_failed)


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

    def __init__(self, plan: Plan, store: Store, place: Place, observer: Observer | None) -> None:
        self._plan, self._store, self._place, self._observer = plan, store, place, observer
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
                self._keep(first_finished(self._flying, self._place.slots))
                self._tell()
        except KeyboardInterrupt:
            self._keep_finished()
            if self._computed < self._wanted:
                raise
        except (BrokenExecutor, CancelledError):  # somebody else's, which is not begun anew
            self._keep_finished()
            raise InputError(f"{self._place.name} is gone; {self._store.prospect()}") from None
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
        while len(self._flying) < self._place.slots():
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
        self._flying[self._place.executor.submit(compute, task)] = group

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
                    f"{self._place.name} lacks what a study needs ({missing}); install the same "
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
