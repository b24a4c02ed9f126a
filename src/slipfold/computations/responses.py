"""The periodic responses of a model for many cases, in one call."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.abreast.assembled import assembled
from slipfold.branches.abreast.own_branch import Case
from slipfold.branches.abreast.responses import FEWEST, follow_abreast
from slipfold.branches.event import Event
from slipfold.branches.response import measured_over
from slipfold.branches.settings import Settings
from slipfold.checks.curves import check_branches
from slipfold.computations.given import (
    Values,
    checked_model,
    checked_settings,
    parse_ends,
    parse_values,
    refuse_varied,
)
from slipfold.computations.response import own_events, response
from slipfold.errors import BREAKDOWNS, InputError, breakdown
from slipfold.models.followed import check_followed
from slipfold.models.model import Model
from slipfold.models.parameter import Parameter
from slipfold.progress import Observer, Progress
from slipfold.results.diagram import Diagram
from slipfold.results.records import provenance
from slipfold.results.responses import INTERRUPTED, Responses

AT_ONCE = 256
"""Cases that are followed side by side: of more each takes as long."""


class _ObserverFailedError(BaseException):
    """What an observer raised, which is not for those to catch whom it watches."""


def responses(
    model: Model,
    vary: str,
    span: tuple[float | str, float | str],
    *,
    over: Mapping[str, Values] | Sequence[Mapping[str, float | str]],
    settings: Settings | None = None,
    events: Sequence[Event] = (),
    observer: Observer | None = None,
    **parameters: float | str,
) -> Responses:
    """Follow the periodic responses of a model over a parameter, for many cases.

    Each is what `slipfold.response` gives for its case alone; the equations are compiled once. Of
    16 cases and more those on which nothing is out of the ordinary are followed side by side, in
    less than half of the time: points lie elsewhere on the same branches, and what is special
    differs by no more than its uncertainties.

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``.
    vary
        Name of the parameter to follow.
    span
        Its first and last value: numbers in SI units, or text with a unit.
    over
        The cases: of each parameter that differs one value a case, by name, such as columns of a
        table or an `xarray.Dataset`; or one mapping a case. Numbers in SI units, or text with a
        unit.
    settings
        Options of continuation; the defaults of `slipfold.Settings` if None.
    events
        Values of outputs or of the parameter to locate.
    observer
        Called after every case with a `slipfold.Progress`, and several times a second while many
        are followed together: ``done`` counts finished cases, the value ``fraction`` tells how far
        the stage is. If it raises `KeyboardInterrupt`, or the user does, the cases not
        finished say so.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    Responses
        A diagram each; where there is none, `Responses.failures` says why.

    Raises
    ------
    InputError
        For what is wrong in all cases: an unknown parameter, a wrong unit, an empty span, no cases,
        columns of different lengths.

    Examples
    --------
    >>> import slipfold as sf
    >>> cases = [{"Vd": 0.5}, {"Vd": "600mm/s"}, {"Vd": -1}]
    >>> found = sf.responses(sf.SlidingOscillator(f=12.5), "Nd", (0, 0.1), over=cases)
    >>> [None if diagram is None else len(diagram.special) for diagram in found]
    [1, 2, None]
    >>> found.failures
    {2: 'Vd = -1 is outside its bounds; Vd must be >= 0 m/s'}
    """
    changed = checked_model(model).replace(**parameters)
    columns = _columns(changed, over)
    refuse_varied(columns, parameters, "over")
    if vary in columns:
        raise InputError(f"{vary} is followed, so it cannot be in over as well; leave it out there")
    followed = changed.variable_parameter(vary)
    first, last = (followed.check(value) for value in parse_ends(followed, span))
    if first == last:
        raise InputError(f"the span of {vary} is empty; give two different values")
    chosen = checked_settings(settings)
    total, started = len(next(iter(columns.values()))), perf_counter()
    diagrams: list[Diagram | None] = []
    reasons: list[str] = []
    cases = [
        {name: float(column[case]) for name, column in columns.items()} for case in range(total)
    ]
    beside = dict[int, Callable[[], Diagram | None]]()

    def tell(stage: str, share: float) -> None:
        if observer is not None:
            values = {"failures": sum(map(bool, reasons)), "fraction": share}
            progress = Progress(stage, len(diagrams), total, values=values)
            try:
                observer(progress)
            except Exception as error:
                raise _ObserverFailedError(error) from error

    try:
        for case, values in enumerate(cases):
            if case % AT_ONCE == 0 and total >= FEWEST and not events:
                beside = _side_by_side(changed, vary, (first, last), cases, case, chosen, tell)
            found = beside.pop(case, lambda: None)() or _one(
                changed, vary, (first, last), values, settings=chosen, events=events
            )
            if isinstance(found, Diagram) and found.interrupted:
                raise KeyboardInterrupt
            diagrams.append(None if isinstance(found, str) else found)
            reasons.append(found if isinstance(found, str) else "")
            tell("cases", 1.0)
    except _ObserverFailedError as error:
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


def _side_by_side(
    model: Model,
    vary: str,
    span: tuple[float, float],
    cases: Sequence[Mapping[str, float]],
    start: int,
    settings: Settings,
    tell: Callable[[str, float], None],
) -> dict[int, Callable[[], Diagram | None]]:
    """Return what makes the diagrams of some cases by their numbers; None of those left."""
    if own_events(model, vary):
        return {}
    models, begun = dict[int, Model](), perf_counter()
    for case in range(start, min(start + AT_ONCE, len(cases))):
        with suppress(InputError, *BREAKDOWNS):  # said of the case when its turn comes
            own = model.replace(**cases[case], **{vary: span[0]})
            check_followed(own)
            models[case] = measured_over(own, vary, span)
    if not models:
        return {}
    try:
        found = follow_abreast(list(models.values()), vary, span, settings, tell)
    except (InputError, *BREAKDOWNS):  # whichever case it is, by itself it says so
        return {}
    each = (perf_counter() - begun) / len(models)
    return {
        case: partial(_diagram, models[case], vary, span, settings, followed, each)
        for case, followed in zip(models, found, strict=True)
    }


def _diagram(
    model: Model,
    vary: str,
    span: tuple[float, float],
    settings: Settings,
    followed: Case,
    seconds: float,
) -> Diagram | None:
    """Return the diagram of a case that was followed beside others; None if it was left."""
    begun = perf_counter()
    try:
        branches = assembled(followed, vary, span)
        if branches is None:
            return None
        checked = check_branches(branches)
    except (InputError, *BREAKDOWNS):  # by itself it says what it is
        return None
    told = provenance(seconds + perf_counter() - begun)
    return Diagram(model, vary, span, branches, settings, (), told, checked)


def _one(
    model: Model, vary: str, span: tuple[float, float], values: Mapping[str, float], **options: Any
) -> Diagram | str:
    """Return the diagram of a case, or why there is none."""
    try:
        return response(model.replace(**values), vary, span, **options)
    except InputError as error:
        return str(error)
    except BREAKDOWNS as error:
        return breakdown(error)


def _columns(
    model: Model, over: Mapping[str, Values] | Sequence[Mapping[str, float | str]]
) -> dict[str, NDArray[np.float64]]:
    """Return the values of each parameter that differs, one a case."""
    table: Any = over
    if not hasattr(over, "keys"):  # one mapping a case; a table has keys, be it a mapping or not
        rows = list(over)
        if not all(hasattr(row, "keys") and set(row) == set(rows[0]) for row in rows):
            raise InputError("over does not give the same parameters in each case, by name")
        table = {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}
    found = {
        str(name): _numbers(model.variable_parameter(str(name)), table[name])
        for name in table.keys()  # noqa: SIM118 (a table may iterate over something else)
    }
    lengths = {name: len(values) for name, values in found.items()}
    if not found or not all(lengths.values()):
        raise InputError("over holds no cases; give e.g. {'Vd': [0.5, 0.6], 'mu': [0.5, 0.45]}")
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{count} of {name}" for name, count in lengths.items())
        raise InputError(f"over needs one value a case of each parameter, but has {told}")
    return found


def _numbers(parameter: Parameter, values: Values) -> NDArray[np.float64]:
    given = np.asarray(values)
    if given.dtype.kind in "OU":  # text, perhaps with units
        given = np.asarray(parse_values(parameter, given.tolist()))
    try:
        found = np.array(given, dtype=float)
    except (TypeError, ValueError):
        found = np.empty((0, 0))
    if found.ndim != 1:
        raise InputError(f"{parameter.name} = {values!r} is not a list of numbers, one a case")
    return found
