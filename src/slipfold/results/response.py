"""The periodic response of a model over a parameter, in one call."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter

from slipfold.branches.event import Event
from slipfold.branches.progress import Observer
from slipfold.branches.response import trace_response
from slipfold.branches.settings import Settings
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.quantity import parse_quantity
from slipfold.models.system import System
from slipfold.results.diagram import Diagram
from slipfold.results.given_settings import checked_settings
from slipfold.results.provenance import provenance

__all__ = ["response"]


def response(
    model: Model,
    vary: str,
    span: tuple[float | str, float | str],
    *,
    settings: Settings | None = None,
    events: Sequence[Event] = (),
    observer: Observer | None = None,
    **parameters: float | str,
) -> Diagram:
    """Follow the periodic response of a model over a parameter, and every doubled branch.

    **Main arguments**

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``.
    vary
        Name of the parameter to follow.
    span
        Its first and last value: numbers in SI units, or text with a unit. A descending span is
        fine.
    settings
        Options of continuation; the defaults of `slipfold.Settings` if None.
    events
        Values of outputs or of the parameter to locate.
    observer
        Called after every point with a `slipfold.branches.progress.Progress`. If it raises
        `KeyboardInterrupt`, or the user does, what is finished is returned.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    Diagram
        Branches with their special points. A branch that stops early says why in its `stopped`.

    Raises
    ------
    InputError
        For an unknown parameter, a wrong unit, a value outside its bounds, an empty span, or a
        start where no orbit is found.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)
    >>> round(diagram.branches[0].special[0].value, 9)
    0.043578911
    """
    if vary in parameters:
        raise InputError(
            f"{vary} is varied, so it cannot be set to {parameters[vary]} as well; "
            "give it once, in the span"
        )
    if not isinstance(model, Model):
        raise InputError(f"model = {model!r} is not a model; give e.g. SlidingOscillator()")
    parameters[vary], last = _ends(model, vary, span)
    chosen = checked_settings(settings)
    changed = model.replace(**parameters)
    watched = (*events, *_own_events(changed, vary))
    first = changed.values[vary]
    started = perf_counter()
    branches = trace_response(
        changed, vary, (first, last), settings=chosen, events=watched, observer=observer
    )
    return Diagram(
        changed,
        vary,
        (first, last),
        branches,
        chosen,
        watched,
        provenance(perf_counter() - started),
    )


def _own_events(model: Model, vary: str) -> tuple[Event, ...]:
    """Events that the definition of a system asks for, as far as they can occur."""
    if not isinstance(model, System):
        return ()
    events = (Event(item.output, item.value, item.measure, item.stop) for item in model.events)
    return tuple(item for item in events if item.measure != "parameter" or item.name == vary)


def _ends(model: Model, vary: str, span: tuple[float | str, float | str]) -> tuple[float, float]:
    parameter = model.parameter(vary)
    try:
        first, last = span
    except (TypeError, ValueError):
        raise InputError(
            f"span = {span!r} is not a pair of numbers; give the first and the last value of {vary}"
        ) from None
    ends = (parse_quantity(first, parameter.unit, vary), parse_quantity(last, parameter.unit, vary))
    return parameter.check(ends[0]), parameter.check(ends[1])
