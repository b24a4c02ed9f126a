"""Responses over a parameter: of one case, of many cases, and the gradients of thresholds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from slipfold import options
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.progress import branch_progress
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.branches.settings import Event, Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.branches.start import Begin, measured_over
from slipfold.bifurcations.tori.follow import tori_of
from slipfold.bifurcations.tori.torus_branch import TorusBranch
from slipfold.computations.arguments import (
    Values,
    checked_events,
    checked_model,
    checked_point,
    checked_settings,
    parse_values,
    refuse_varied,
)
from slipfold.computations.starts import FurtherBranches, first_begin, given_begin, model_of
from slipfold.declarations import documented
from slipfold.errors import BREAKDOWNS, InputError, breakdown
from slipfold.models.equilibria import check_followed
from slipfold.models.model import Model
from slipfold.models.system import System
from slipfold.models.units import interval
from slipfold.orbits.bifurcation_types import FOLLOWED_TYPES
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.progress import Observer, Progress
from slipfold.results.checks.checked import Checked
from slipfold.results.checks.curves import check_branches, check_together
from slipfold.results.diagram import Diagram, finalized
from slipfold.results.records import provenance

if TYPE_CHECKING:
    from slipfold.bifurcations.branches.batched import BatchedCase
    from slipfold.results.responses import Responses

SIMULTANEOUS = 256
"""Cases that are followed in one batch: of more each takes as long."""

MADE = 16
"""Cases whose orbits are checked together: of more each takes as long, and an interruption loses
these."""


@documented
def response(
    model: options.ModelOrOrbit,
    vary: options.Vary,
    span: options.Span,
    *,
    start: options.Start = None,
    settled: options.Settled = False,
    also: options.Also = (),
    gaps: options.Gaps = False,
    gradients: options.Gradients = False,
    search: options.Search = False,
    tori: options.Tori = False,
    settings: Settings | None = None,
    events: Sequence[Event] = (),
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> Diagram:
    """Follow the periodic response of a model over a parameter, and every doubled branch.

    Branches continue across sticking phases where contacts begin to stick. Where no moving surface
    slides all the time, they begin at the attractor that a solution converges to.

    Returns
    -------
    Diagram
        Branches with their special points. A branch that ends early says why in its `stopped`.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)
    >>> [(branch.period, point.type) for branch, point in diagram.special]
    [(1, 'PD'), (2, 'NS'), (2, 'NS')]
    >>> round(diagram.special[0].point.value, 9)
    0.043578911

    The cycle of the Lorenz system at a large Rayleigh number loses its symmetry, then doubles:

    >>> lorenz = sf.built_in_models()["lorenz"]()
    >>> cycle = sf.periodic_orbit(lorenz.replace(rho=350))
    >>> settings = sf.Settings(largest_period=1)
    >>> diagram = sf.response(cycle, vary="rho", span=(350, 310), settings=settings)
    >>> diagram.branches[0].special[0].type
    'BP'
    """
    orbit = model if isinstance(model, PeriodicOrbit) else None
    if orbit is not None:
        model = model_of(orbit, vary, span, {**parameters, **(start or {})})
    refuse_varied([vary], parameters, "the span")
    model = checked_model(model)
    parameters[vary], last = interval(model.variable_parameter(vary), span)
    chosen = checked_settings(settings)
    started = perf_counter()
    changed = model.replace(**parameters)
    watched = (*checked_events(events), *own_events(changed, vary))
    ends = changed.values[vary], last
    torus_set: tuple[TorusBranch, ...] = ()
    if orbit is not None:
        begin: Begin | None = given_begin(orbit, vary, ends)
    else:
        begin, torus_set = first_begin(
            changed, vary, ends, start, settled, tori, chosen, on_progress
        )
    unscaled = changed
    # An orbit that sticks has its own scales.
    if begin is None or not isinstance(begin.orbit, StickSlipOrbit):
        changed = measured_over(changed, vary, ends, begin)
    follow = partial(
        trace_response,
        changed,
        vary,
        ends,
        settings=chosen,
        events=watched,
        observer=on_progress,
        through_stick=True,
    )
    own = model.values[vary]
    further = FurtherBranches(
        changed, unscaled, vary, ends, follow, also, gaps, own, search, on_progress
    )
    branches, unfollowed, searched, stopped = further.followed(begin, torus_set)
    complete = True
    if gradients and not stopped:
        branches, complete = with_gradients(branches, chosen, on_progress)
    if tori and complete and not stopped and not torus_set:
        torus_set = tori_of(branches, ends, chosen, on_progress)
        complete = not any(item.interrupted for item in torus_set)
    complete &= not stopped
    checked = check_branches(branches, on_progress) if complete else Checked((), interrupted=True)
    diagram = Diagram(
        changed,
        vary,
        ends,
        branches,
        chosen,
        watched,
        provenance(perf_counter() - started),
        checked,
        searched,
        torus_set,
        unfollowed,
    )
    return diagram if diagram.interrupted else finalized(diagram)


def own_events(model: Model, vary: str) -> tuple[Event, ...]:
    """Return the events that the definition of a system asks for, as far as they can occur."""
    if not isinstance(model, System):
        return ()
    events = (Event(item.output, item.value, item.measure, item.stop) for item in model.events)
    return tuple(item for item in events if item.measure != "parameter" or item.name == vary)


class _ReportFailedError(BaseException):
    """An error that `on_progress` raised: the observed code must not catch it."""


@documented
def responses(
    model: Model,
    vary: options.Vary,
    span: options.Span,
    *,
    over: options.Cases,
    settings: Settings | None = None,
    events: Sequence[Event] = (),
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> Responses:
    """Follow the periodic responses of a model over a parameter, for many cases.

    Each is what `slipfold.response` gives for its case alone; the equations are compiled once. At
    16 cases and more ordinary branches are followed in batches, in less than half of the time:
    points lie elsewhere on the same branches, special points differ by no more than their
    uncertainties, and fewer orbits are checked: checks take a tenth of the work. `on_progress`
    receives, several times a second, ``done`` finished cases, their ``failures`` and the
    ``fraction`` of the stage.

    Returns
    -------
    Responses
        A diagram each; where there is none, `Responses.failures` says why.

    Raises
    ------
    InputError
        For errors of all cases: an unknown parameter, a wrong unit, an empty span, no cases,
        columns of different lengths.

    Examples
    --------
    >>> import slipfold as sf
    >>> cases = [{"Vd": 0.5}, {"Vd": "600mm/s"}, {"Vd": -1}]
    >>> result = sf.responses(sf.SlidingOscillator(f=12.5), "Nd", (0, 0.1), over=cases)
    >>> [None if diagram is None else len(diagram.special) for diagram in result]
    [1, 2, None]
    >>> result.failures
    {2: 'Vd = -1 is outside its bounds; Vd must be >= 0 m/s'}
    """
    from slipfold.bifurcations.branches.batched_walk import BATCH
    from slipfold.results.responses import INTERRUPTED, Responses

    changed = checked_model(model).replace(**parameters)
    columns = _columns(changed, over)
    refuse_varied(columns, parameters, "over")
    if vary in columns:
        raise InputError(f"{vary} is followed, so it cannot be in over as well; leave it out there")
    first, last = interval(changed.variable_parameter(vary), span)
    chosen = checked_settings(settings)
    events = checked_events(events)
    total, started = len(next(iter(columns.values()))), perf_counter()
    diagrams: list[Diagram | None] = []
    reasons: list[str] = []
    cases = [
        {name: float(column[case]) for name, column in columns.items()} for case in range(total)
    ]
    batch: dict[int, BatchedCase] = {}
    made: dict[int, Diagram] = {}

    def send(stage: str, fraction: float) -> None:
        if on_progress is not None:
            values = {"failures": sum(map(bool, reasons)), "fraction": fraction}
            progress = Progress(stage, len(diagrams), total, values=values)
            try:
                on_progress(progress)
            except Exception as error:
                raise _ReportFailedError(error) from error

    try:
        for case, values in enumerate(cases):
            if case % SIMULTANEOUS == 0 and total >= BATCH.minimum_size and not events:
                batch = _batch(changed, vary, (first, last), cases, case, chosen, send)
            if case in batch:
                some = [number for number in range(case, case + MADE) if number in batch]
                together = {number: batch.pop(number) for number in some}
                made = _diagrams(together, vary, (first, last), chosen)
            result = made.pop(case, None) or _one(
                changed, vary, (first, last), values, settings=chosen, events=events
            )
            if isinstance(result, Diagram) and result.interrupted:
                raise KeyboardInterrupt
            diagrams.append(None if isinstance(result, str) else result)
            reasons.append(result if isinstance(result, str) else "")
            send("cases", 1.0)
    except _ReportFailedError as error:
        raise error.args[0] from None
    except KeyboardInterrupt:
        pass
    missing = total - len(diagrams)
    return Responses(
        changed,
        vary,
        (first, last),
        columns,
        (*diagrams, *[None] * missing),
        (*reasons, *[INTERRUPTED] * missing),
        provenance(perf_counter() - started),
    )


def _batch(
    model: Model,
    vary: str,
    span: tuple[float, float],
    cases: Sequence[Mapping[str, float]],
    start: int,
    settings: Settings,
    send: Callable[[str, float], None],
) -> dict[int, BatchedCase]:
    """Follow cases in a batch, those that can be, by their numbers."""
    from slipfold.bifurcations.branches.batched import follow_batch

    if own_events(model, vary):
        return {}
    models, began = dict[int, Model](), perf_counter()
    for case in range(start, min(start + SIMULTANEOUS, len(cases))):
        with suppress(*BREAKDOWNS):  # reported when the case itself is computed
            own = model.replace(**cases[case], **{vary: span[0]})
            check_followed(own)
            models[case] = measured_over(own, vary, span)
    if not models:
        return {}
    try:
        result = follow_batch(list(models.values()), vary, span, settings, send)
    except BREAKDOWNS:  # reported when the case itself is computed
        return {}
    for followed in result:
        followed.seconds = (perf_counter() - began) / len(models)
    return {case: item for case, item in zip(models, result, strict=True) if not item.failure}


def _diagrams(
    batch: Mapping[int, BatchedCase], vary: str, span: tuple[float, float], settings: Settings
) -> dict[int, Diagram]:
    """Return the diagrams of cases that were followed in a batch, without those that fail."""
    began, branches = perf_counter(), dict[int, tuple[Branch, ...]]()
    for case, item in batch.items():
        with suppress(*BREAKDOWNS):  # reported when the case itself is computed
            branches[case] = item.assembled(vary, span[0])
    try:
        checked = check_together(list(branches.values()))
    except BREAKDOWNS:  # likewise
        return {}
    each = (perf_counter() - began) / len(batch)
    diagrams = dict[int, Diagram]()
    for (case, own), checks in zip(branches.items(), checked, strict=True):
        item = batch[case]
        text = provenance(item.seconds + each)
        diagrams[case] = Diagram(item.model, vary, span, own, settings, (), text, checks)
    return diagrams


def _one(
    model: Model, vary: str, span: tuple[float, float], values: Mapping[str, float], **options: Any
) -> Diagram | str:
    """Return the diagram of a case, or why there is none."""
    try:
        return response(model.replace(**values), vary, span, **options)
    except BREAKDOWNS as error:
        return breakdown(error)


def _columns(
    model: Model, over: Mapping[str, Values] | Sequence[Mapping[str, float | str]]
) -> dict[str, NDArray[np.float64]]:
    """Return the values of each parameter that differs, one a case."""
    table: Any = over
    if not hasattr(over, "keys"):  # one mapping a case; a table has keys, be it a mapping or not
        given: Any = over
        rows = list(given) if isinstance(given, Iterable) else [given]
        if not all(hasattr(row, "keys") and set(row) == set(rows[0]) for row in rows):
            raise InputError("over does not give the same parameters in each case, by name")
        table = {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}
    result = {
        str(name): parse_values(model.variable_parameter(str(name)), table[name])
        for name in table.keys()  # noqa: SIM118 (a table may iterate over something else)
    }
    lengths = {name: len(values) for name, values in result.items()}
    if not result or not all(lengths.values()):
        raise InputError("over holds no cases; give e.g. {'Vd': [0.5, 0.6], 'mu': [0.5, 0.45]}")
    if len(set(lengths.values())) > 1:
        text = ", ".join(f"{count} of {name}" for name, count in lengths.items())
        raise InputError(f"over needs one value a case of each parameter, but has {text}")
    return result


@documented
def gradients(point: options.Point) -> dict[str, float]:
    """Compute the derivatives of a special point with respect to every parameter not followed.

    Exact derivatives of its value, from the equations of its locus in two parameters: one linear
    system serves all parameters. Values that depend on parameters change with them, such as masses
    that follow from a stiffness and a frequency.

    Returns
    -------
    dict
        Derivatives by name of the parameter, in the unit of the point's value over that of the
        parameter, angles in rad. NaN where there is none: a parameter that separates the crossing
        branches removes a branch point, or the orbit is not found again.

    Raises
    ------
    InputError
        If the point has no locus, as a user's event.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> doubling = diagram.special[0].point
    >>> round(sf.gradients(doubling)["Vd"], 9)
    -0.041609201
    """
    from slipfold.bifurcations.loci.gradients import threshold_gradients

    result = threshold_gradients(checked_point(point, FOLLOWED_TYPES))
    assert result is not None
    return result


def with_gradients(
    branches: Sequence[Branch], settings: Settings, on_progress: Observer | None
) -> tuple[tuple[Branch, ...], bool]:
    """Return branches whose special points have gradients, and whether all of them do."""
    from slipfold.bifurcations.loci.gradients import threshold_gradients

    total, done = sum(len(branch.special) for branch in branches), 0
    result = list[Branch]()
    try:
        for branch in branches:
            special = list[SpecialPoint]()
            for point in branch.special:
                if on_progress is not None:
                    on_progress(_progress(branch, done, total))
                special.append(replace(point, gradients=threshold_gradients(point, settings)))
                done += 1
            result.append(replace(branch, special=tuple(special)))
    except KeyboardInterrupt:
        return (*result, *branches[len(result) :]), False
    return tuple(result), True


def _progress(branch: Branch, done: int, total: int) -> Progress:
    names = tuple(point.type for point in branch.special)
    at = branch.id, branch.period, len(branch), branch.stopped.value, names
    return branch_progress(branch.model.parameter(branch.vary), *at, "gradients", done, total)
