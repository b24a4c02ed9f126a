"""The plane and the window of a bifurcation set, as people write them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from slipfold.errors import InputError
from slipfold.loci.window import Window, check_window
from slipfold.models.followed import check_followed
from slipfold.models.model import Model
from slipfold.models.quantity import parse_quantity
from slipfold.orbits.find import may_slip
from slipfold.progress import Observer, Progress

Ends = tuple[float | str, float | str]
"""Two values of a parameter: numbers in SI units, or text with a unit."""

GivenWindow = Sequence[Ends] | Mapping[str, Ends]
"""Ends of both parameters, in their order or by name."""

AnyModel = TypeVar("AnyModel", bound=Model)


def parse_plane(
    model: Model, vary: tuple[str, str], window: GivenWindow | None
) -> tuple[tuple[str, str], Window]:
    """Return the names of two parameters and the window in them, in SI units, or raise.

    >>> from slipfold.models import SlidingOscillator
    >>> parse_plane(SlidingOscillator(), ("f", "Nd"), {"Nd": (0, "500mN"), "f": (13, 12)})
    (('f', 'Nd'), ((12.0, 13.0), (0.0, 0.5)))
    """
    first, second = _pair(
        vary,
        f'a locus is followed in two parameters, not in {vary!r}; give two names, e.g. ("f", "Nd")',
    )
    for name in (first, second):
        if not isinstance(name, str):
            raise InputError(
                f'{name!r} is not the name of a parameter; give two names, e.g. ("f", "Nd")'
            )
        model.parameter(name)
    if first == second:
        raise InputError(f"{first} is given for both parameters; give two different ones")
    if window is None:
        raise InputError(
            f"no window is given; give two values each for {first} and {second}, e.g. "
            f"window={{{first!r}: (least, largest), {second!r}: (least, largest)}}"
        )
    ends = _in_order((first, second), window)
    spans = (_span(model, first, ends[0]), _span(model, second, ends[1]))
    return (first, second), check_window(model, (first, second), spans)


def _pair(given: Any, sentence: str) -> tuple[Any, Any]:
    """Return both items of what should be a pair; text is none, even of two letters."""
    try:
        items = tuple(given)
    except TypeError:
        items = ()
    if isinstance(given, str) or len(items) != 2:
        raise InputError(sentence)
    return items[0], items[1]


def _in_order(vary: tuple[str, str], window: GivenWindow) -> tuple[Ends, Ends]:
    wanted = f"give two values each for {vary[0]} and {vary[1]}"
    if not isinstance(window, Mapping):
        example = "e.g. ((11.5, 13.5), (0, 0.98))"
        return _pair(window, f"window = {window!r} is not a pair of pairs; {wanted}, {example}")
    if set(window) != set(vary):
        names = ", ".join(map(str, window)) or "nothing"
        raise InputError(f"the window is given for {names}; {wanted}")
    return window[vary[0]], window[vary[1]]


def _span(model: Model, name: str, ends: Ends) -> tuple[float, float]:
    unit = model.parameter(name).unit
    first, last = _pair(
        ends,
        f"the window of {name} is {ends!r}, which is not a pair; give its least and its largest "
        "value",
    )
    for end in (first, last):
        if isinstance(end, bool | np.bool_):
            raise InputError(f"the window of {name} holds {end}, which is not a number; give one")
    return parse_quantity(first, unit, name), parse_quantity(last, unit, name)


def corner_model(
    model: AnyModel,
    vary: tuple[str, str],
    window: Window,
    changes: Mapping[str, float | str] | None = None,
) -> AnyModel:
    """Return a model at a corner of the window, the lowest that it can have.

    Parameters of a model may bound one another. A window may stick out of what is allowed, where a
    locus then ends at a limit of the model, but not with a whole side.
    """
    other = dict(changes or {})
    sides = [[(value, end) for end in window[1]] for value in window[0]]
    sides += [[(end, value) for end in window[0]] for value in window[1]]
    corners = [
        _first_allowed(model, [{**other, vary[0]: a, vary[1]: b} for a, b in side])
        for side in sides
    ]
    return corners[0]


def _first_allowed(model: AnyModel, candidates: Sequence[dict[str, float | str]]) -> AnyModel:
    refused: InputError | None = None
    for candidate in candidates:
        try:
            changed = model.replace(**candidate)
            # Where a counter-body is at rest nothing slides all the time: motions lead to orbits.
            if not changed.forced or may_slip(changed):
                check_followed(changed)
            return changed
        except InputError as error:
            refused = refused or error
    assert refused is not None
    raise refused


def with_place(observer: Observer | None, model: Model, plane: tuple[str, str]) -> Observer | None:
    """Return what reports progress with the values of the two parameters in its text."""
    if observer is None:
        return None
    units = [model.parameter(name).unit for name in plane]

    def report(progress: Progress) -> None:
        place = ", ".join(
            f"{name} = {value:.6g} {unit}".rstrip()
            for name, value, unit in zip(plane, progress.values["place"], units, strict=True)
        )
        observer(replace(progress, text=f"{progress.text}  {place}"))

    return report
