"""Arguments of computations, checked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.branches.settings import Settings
from slipfold.branches.special_point import LOCUS_TYPES, SpecialPoint
from slipfold.errors import InputError
from slipfold.long_term.search import Box, box_around, checked_box
from slipfold.models.model import Model
from slipfold.models.parameter import Parameter
from slipfold.models.quantity import parse_quantity
from slipfold.results.diagram import Labeled

Values = ArrayLike | Sequence[float | str]
"""Values of a parameter: numbers, or text with a unit."""


def checked_model(model: Any) -> Model:
    """Return the model given, or raise."""
    if not isinstance(model, Model):
        raise InputError(f"model = {model!r} is not a model; give e.g. SlidingOscillator()")
    return model


def checked_forced(model: Model) -> Model:
    """Return a model that is forced, or raise."""
    if not model.forced:
        raise InputError(
            f"nothing forces {model.name}, so there is no phase at which to look at its motions; "
            "use attractors"
        )
    return model


def checked_point(given: Any) -> SpecialPoint:
    """Return the special point given, or raise; it must have a locus."""
    point = given.point if isinstance(given, Labeled) else given
    if not isinstance(point, SpecialPoint):
        raise InputError(
            f"point = {given!r} is no special point; give one of a diagram's, e.g. "
            "diagram.special[0]"
        )
    if point.type not in LOCUS_TYPES:
        raise InputError(
            f"a special point of type {point.type} has no gradients; give one of type "
            f"{', '.join(LOCUS_TYPES)}"
        )
    return point


def checked_count(given: Any, name: str, least: int = 1) -> int:
    """Return a whole number of at least `least`, or raise."""
    if isinstance(given, (int, np.integer)) and not isinstance(given, bool) and given >= least:
        return int(given)
    raise InputError(f"{name} = {given!r} is not a whole number of at least {least}; give one")


def refuse_varied(names: Iterable[str], parameters: Mapping[str, Any], place: str) -> None:
    """Refuse values of parameters that are varied."""
    for name in names:
        if name in parameters:
            raise InputError(
                f"{name} is varied, so it cannot be set to {parameters[name]} as well; "
                f"give it once, in {place}"
            )


def parse_ends(parameter: Parameter, span: Any) -> tuple[float, float]:
    """Return the first and the last value of a parameter, in SI units."""
    unit, name = parameter.unit, parameter.name
    try:
        first, last = span
    except (TypeError, ValueError):
        raise InputError(
            f"span = {span!r} is not a pair of numbers; give the first and the last value of {name}"
        ) from None
    return parse_quantity(first, unit, name), parse_quantity(last, unit, name)


def parse_values(parameter: Parameter, values: Values) -> ArrayLike:
    """Convert text with units; leave the rest to be checked where it is used."""
    if isinstance(values, list | tuple):
        return [parse_quantity(value, parameter.unit, parameter.name) for value in values]
    return values


def spread_values(parameter: Parameter, span: Any, count: Any) -> NDArray[np.float64]:
    """Return values spread evenly over a span, least first, shape (count,), or raise."""
    low, high = sorted(parameter.check(end) for end in parse_ends(parameter, span))
    if low == high:
        raise InputError(
            f"the span of {parameter.name} from {low:g} to {high:g} is empty; give two values"
        )
    return np.linspace(low, high, checked_count(count, "points", least=2))


def starts_given(
    model: Model, box: Any, starts: Any, seed: Any, least: int = 1
) -> tuple[Box, NDArray[np.float64]]:
    """Return a box, that around the model's start if none is given, and starts in it, or raise.

    Shapes: returns the box and (n_starts, n_states).
    """
    where = box_around(model) if box is None else checked_box(model, box)
    count, begin = checked_count(starts, "starts", least), checked_count(seed, "seed", least=0)
    return where, where.starts(count, begin) if count else np.empty((0, len(model.states)))


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
