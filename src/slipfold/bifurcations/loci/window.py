"""The window in the plane of two parameters, and reports of progress."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.settings import Settings
from slipfold.errors import InputError
from slipfold.flow.scales import measured_within
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress

Window = tuple[tuple[float, float], tuple[float, float]]
"""Least and largest value of each of two parameters."""


def check_window(model: Model, vary: tuple[str, str], window: Window) -> Window:
    """Return a window with its ends in order, or raise if it cannot be used.

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> check_window(SlidingOscillator(), ("f", "Nd"), ((13, 12), (0, 0.9)))
    ((12.0, 13.0), (0.0, 0.9))
    """
    try:
        (first, second), ((a, b), (c, d)) = vary, window
    except (TypeError, ValueError):
        raise InputError(
            f"a plane takes two parameters with two values each, not {vary!r} and {window!r}; "
            'give e.g. vary=("f", "Nd"), window=((11.5, 13.5), (0, 0.98))'
        ) from None
    parameters = [model.variable_parameter(name) for name in (first, second)]
    if first == second:
        raise InputError(f"{first} is given for both parameters; give two different ones")
    spans = []
    for parameter, ends in zip(parameters, ((a, b), (c, d)), strict=True):
        low, high = sorted(parameter.check(value) for value in ends)
        if low == high:
            raise InputError(
                f"the window of {parameter.name} from {low:g} to {high:g} is empty; give two "
                "different values"
            )
        spans.append((low, high))
    return spans[0], spans[1]


def measured_across(model: Model, plane: tuple[str, str], window: Window) -> Model:
    """Return a model that knows how large its states become at the corners of a window."""
    corners = (dict(zip(plane, values, strict=True)) for values in product(*window))
    return measured_within(model, list(corners))


@dataclass(frozen=True, eq=False)
class Plane:
    """The window of a model in which loci and regions are looked for, and how."""

    model: Model
    names: tuple[str, str]  # of the two parameters
    window: Window
    settings: Settings = field(default_factory=Settings)
    observer: Observer | None = None

    @property
    def size(self) -> Array:
        """Widths of the window, shape (2,)."""
        return np.ptp(self.window, axis=1)

    def span(self, name: str) -> tuple[float, float]:
        """Return the least and largest value of a parameter."""
        return self.window[self.names.index(name)]

    def place(self, vary: str, along: float, across: float) -> tuple[float, float]:
        """Return the values of both parameters from that of one and that of the other."""
        return (along, across) if vary == self.names[0] else (across, along)

    def at(self, place: Sequence[float] | Array) -> Model:
        """Return the model at a place."""
        return self.model.replace(**dict(zip(self.names, map(float, place), strict=True)))

    def contains(self, place: Sequence[float]) -> bool:
        """Whether a place lies in the window."""
        return all(low <= v <= high for v, (low, high) in zip(place, self.window, strict=True))

    def report(
        self,
        stage: str,
        done: int,
        total: int | None,
        place: Sequence[float] | Array,
        text: str,
        **of: Any,
    ) -> None:
        """Tell the observer, if there is one, what is computed next, and where."""
        if self.observer is not None:
            first, second = map(float, place)
            self.observer(locus_progress(stage, done, total, (first, second), text, **of))


@dataclass(frozen=True)
class LocusLine:
    """The part of a locus that is being followed: from its start in one direction."""

    number: int  # number of the line, from 0
    type: str  # type of the locus, as of `Locus`
    period: int  # period of its orbits
    start: tuple[float, float]  # values of the two parameters at its first point


def locus_progress(
    stage: str,
    done: int,
    total: int | None,
    place: tuple[float, float],
    text: str,
    **values: Any,
) -> Progress:
    """Return the state of a computation of loci at values of the two parameters."""
    return Progress(stage, done, total, text, {"place": place, **values})
