"""One computation for many cases, described by a file; finished cases are stored."""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from slipfold import options
from slipfold.declarations import documented
from slipfold.progress import Observer
from slipfold.results.records import provenance, structure_record
from slipfold.results.study import StudyResult, study_result
from slipfold.studies.executors import open_executor
from slipfold.studies.plan import Plan, digest, read_plan, total
from slipfold.studies.run import StudyRun
from slipfold.studies.store import Store
from slipfold.version import versions


@documented
def study(
    given: options.StudyGiven,
    store: options.StoreFolder = None,
    *,
    executor: options.StudyExecutor = None,
    resume: options.Resume = False,
    retry_failed: options.RetryFailed = False,
    on_progress: Observer | None = None,
) -> StudyResult:
    """Compute the same thing for many cases, on one core or many.

    A case that fails is stored with the reason and stops no others. The result does not depend on
    where cases are computed, nor on whether the study was interrupted.

    Returns
    -------
    StudyResult
        One labeled dataset of all cases.

    Raises
    ------
    InputError
        If the study has something that is unknown or cannot be used, or the store holds another
        one, is in use, or cannot be written.

    Examples
    --------
    >>> import slipfold as sf
    >>> result = sf.study({
    ...     "model": sf.SlidingOscillator(f=12.5),
    ...     "compute": {"what": "threshold", "vary": "Nd", "span": [0, "900mN"]},
    ...     "cases": {"list": [{"Vd": 0.6, "mu": 0.5}, {"Vd": "500mm/s", "mu": 0.4}]},
    ... })
    >>> result.values["threshold"].round(6).tolist(), result.values["outcome"].tolist()
    ([0.043579, 0.049686], ['PD', 'PD'])
    """
    plan = read_plan(given)
    with ExitStack() as stack:
        temporary = store is None
        if store is None:
            store = stack.enter_context(tempfile.TemporaryDirectory(prefix="slipfold-study-"))
        head = {"versions": versions(), **_head(plan)}
        again = resume or retry_failed
        open_store = stack.enter_context(
            Store.open(Path(store), total(plan.cases), head, again, temporary)
        )
        stopped = False
        try:
            if retry_failed or open_store.done < open_store.total:
                with open_executor(executor) as opened:
                    StudyRun(plan, open_store, opened, on_progress).run(retry_failed)
        except KeyboardInterrupt:
            stopped = True  # what is finished is in the store
        return study_result(plan, open_store.records(), provenance(), stopped, open_store.damaged)


def _head(plan: Plan) -> dict[str, Any]:
    """Return the data that identify a study."""
    head = {
        "model": plan.model.name,
        "structure": structure_record(plan.model),
        "parameters": dict(plan.model.values),
        "compute": plan.work.record(),
        "quantities": [item.name for item in plan.work.quantities(plan.model)],
        "cases": plan.cases.record(),
    }
    draws = digest(plan.cases)
    return head if draws is None else {**head, "draws": draws}
