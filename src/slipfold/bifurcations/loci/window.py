"""The window in the plane of two parameters, and reports of progress."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.settings import Settings
from slipfold.errors import InputError
from slipfold.flow.scales import measured_within
from slipfold.models.model import Model
from slipfold.models.units import interval, pair
from slipfold.progress import Observer, Progress

Window = tuple[tuple[float, float], tuple[float, float]]
"""Least and largest value of each of two parameters."""


def parse_plane(model: Model, vary: tuple[str, str], window: Any) -> tuple[tuple[str, str], Window]:
    """Return the names of two parameters and the window in them, in SI units, or raise.

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> parse_plane(SlidingOscillator(), ("f", "Nd"), {"Nd": (0, "500mN"), "f": (13, 12)})
    (('f', 'Nd'), ((12.0, 13.0), (0.0, 0.5)))
    """
    first, second = pair(
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
            f"window={{{first!r}: (lower, upper), {second!r}: (lower, upper)}}"
        )
    ends = _in_order((first, second), window)
    spans = [
        interval(model.variable_parameter(name), each, "window")
        for name, each in zip((first, second), ends, strict=True)
    ]
    (a, b), (c, d) = map(sorted, spans)
    return (first, second), ((a, b), (c, d))


def _in_order(vary: tuple[str, str], window: Any) -> tuple[Any, Any]:
    expected = f"give two values each for {vary[0]} and {vary[1]}"
    if not isinstance(window, Mapping):
        example = "e.g. ((11.5, 13.5), (0, 0.98))"
        return pair(window, f"window = {window!r} is not a pair of pairs; {expected}, {example}")
    if set(window) != set(vary):
        names = ", ".join(map(str, window)) or "nothing"
        raise InputError(f"the window is given for {names}; {expected}")
    return window[vary[0]], window[vary[1]]


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
        """Report to the observer, if there is one, what is computed next, and where."""
        if self.observer is not None:
            first, second = map(float, place)
            self.observer(locus_progress(stage, done, total, (first, second), text, **of))


@dataclass(frozen=True)
class LocusLine:
    """The part of a locus that is being followed: from its start in one direction."""

    number: int  # number of the line, from 0
    type: str  # type of the locus, as of `Locus`
    period: int  # period of its orbits
    name: str  # title of the locus, such as ``"HB of equilibria"``
    start: tuple[float, float]  # values of the two parameters at its first point


def locus_progress(
    stage: str, done: int, total: int | None, place: tuple[float, float], text: str, **values: Any
) -> Progress:
    """Return the state of a computation of loci at values of the two parameters."""
    return Progress(stage, done, total, text, {"place": place, **values})
