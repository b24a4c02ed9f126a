"""Arguments of computations, checked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.bifurcations.branches.settings import Event, Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.quantities import Parameter
from slipfold.models.units import interval, parse_quantity
from slipfold.orbits.bifurcation_types import LOCUS_TYPES
from slipfold.results.diagram import Labeled

Values = ArrayLike | Sequence[float | str]
"""Values of a parameter: numbers, or text with a unit."""


def checked_model(model: Any) -> Model:
    """Return the model given, or raise."""
    if not isinstance(model, Model):
        raise InputError(f"model = {model!r} is not a model; give e.g. SlidingOscillator()")
    return model


NO_PHASE = "there is no phase at which to sample its solutions; use attractors"


def checked_forced(model: Model, consequence: str = NO_PHASE) -> Model:
    """Return a model that is forced, or raise."""
    if not model.forced:
        raise InputError(f"nothing forces {model.name}, so {consequence}")
    return model


def special_point_of(given: Any) -> SpecialPoint:
    """Return the special point given, or raise."""
    point = given.point if isinstance(given, Labeled) else given
    if not isinstance(point, SpecialPoint):
        raise InputError(
            f"{given!r} is not a special point of a branch; give e.g. diagram.special[0]"
        )
    return point


def checked_point(given: Any, types: Sequence[str] = LOCUS_TYPES) -> SpecialPoint:
    """Return the special point given, or raise; it must be of some types that have loci."""
    point = special_point_of(given)
    if point.type not in types:
        raise InputError(
            f"a special point of type {point.type} has no gradients; give one of type "
            f"{', '.join(types)}"
        )
    return point


def refuse_varied(names: Iterable[str], parameters: Mapping[str, Any], where: str) -> None:
    """Refuse values of parameters that are varied."""
    for name in names:
        if name in parameters:
            raise InputError(
                f"{name} is varied, so it cannot be set to {parameters[name]} as well; "
                f"give it once, in {where}"
            )


def parse_values(parameter: Parameter, values: Values) -> Array:
    """Return values of a parameter, numbers or text with units, shape (m,), or raise."""
    given = values if isinstance(values, list | tuple) else np.asarray(values).tolist()
    if not isinstance(given, list | tuple):
        raise InputError(f"{parameter.name} = {values!r} is not a list of numbers; give one")
    parsed = [parse_quantity(value, parameter.unit, parameter.name) for value in given]
    return np.array(parsed, dtype=float)


def checked_values(parameter: Parameter, values: Values) -> Array:
    """Return one or more values of a parameter within its bounds, shape (m,), or raise."""
    several: Any = [values] if np.isscalar(values) else values
    result = parse_values(parameter, several)
    if not result.size:
        raise InputError(f"no value of {parameter.name} is given; give one or more")
    for value in result.tolist():
        parameter.check(value)
    return result


def equidistant(parameter: Parameter, span: Any, count: int) -> Array:
    """Return equidistant values of a parameter, rising, shape (count,), or raise."""
    low, high = sorted(interval(parameter, span))
    return np.linspace(low, high, count)


def checked_events(events: object) -> tuple[Event, ...]:
    """Return a sequence of events."""
    given = tuple(events) if isinstance(events, (list, tuple)) else (events,)
    for item in given:
        if not isinstance(item, Event):
            raise InputError(f"events: {item!r} is not an event; give e.g. sf.Event('x', 0.3)")
    return given


def checked_settings(given: Settings | None) -> Settings:
    """Return the options given, the defaults if there are none, or raise.

    >>> checked_settings(None).newton.tolerance
    1e-10
    """
    if given is None:
        return Settings()
    if not isinstance(given, Settings):
        raise InputError(
            f"settings = {given!r} are not options of continuation; give e.g. "
            "Settings(steps=Steps(largest=0.1))"
        )
    return given
