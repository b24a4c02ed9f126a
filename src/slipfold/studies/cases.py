"""The cases of a study: values of parameters by number, in the order of their numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from math import prod
from typing import Any, Protocol

import numpy as np

from slipfold.arrays import Array


class Cases(Protocol):
    """Values of some parameters for every case."""

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters that differ from case to case."""

    @property
    def shape(self) -> tuple[int, ...]:
        """How many cases there are; of a grid along each of its axes."""

    def values(self, numbers: Any) -> Array:
        """Return the values of some cases. Shapes: numbers (k,), from 0; returns (k, n_names)."""

    def record(self) -> dict[str, Any]:
        """Return what they are, as plain data."""


@dataclass(frozen=True, eq=False)
class Grid:
    """All combinations of some values of each parameter; the last parameter changes first."""

    axes: Mapping[str, Array]

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters that differ from case to case."""
        return tuple(self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each has."""
        return tuple(len(values) for values in self.axes.values())

    def values(self, numbers: Any) -> Array:
        """Return the values of some cases."""
        places = np.unravel_index(numbers, self.shape)
        columns = [values[place] for values, place in zip(self.axes.values(), places, strict=True)]
        return np.stack(columns, axis=-1)

    def record(self) -> dict[str, Any]:
        """Return what they are, as plain data."""
        return {"grid": {name: values.tolist() for name, values in self.axes.items()}}


@dataclass(frozen=True, eq=False)
class Rows:
    """Cases that are listed, or were drawn at random."""

    names: tuple[str, ...]
    rows: Array  # shape (n_cases, n_names)
    drawn: Mapping[str, Any] | None = None  # how they were drawn; None if they were listed

    @property
    def shape(self) -> tuple[int, ...]:
        """How many there are."""
        return (len(self.rows),)

    def values(self, numbers: Any) -> Array:
        """Return the values of some cases."""
        return self.rows[numbers]

    def record(self) -> dict[str, Any]:
        """Return what they are, as plain data."""
        if self.drawn is not None:
            return dict(self.drawn)
        columns = zip(self.names, self.rows.T.tolist(), strict=True)
        return {"list": dict(columns)}


def digest(cases: Cases) -> str | None:
    """Return what tells cases that were drawn from other ones; None of those that are given.

    Programs may come to draw otherwise by the same seed; last digits differ between processors.
    """
    if not isinstance(cases, Rows) or cases.drawn is None:
        return None
    return sha256(cases.rows.astype("<f4").tobytes()).hexdigest()[:16]


def total(cases: Cases) -> int:
    """Return how many cases there are.

    >>> total(Grid({"Vd": np.array([0.5, 0.6]), "mu": np.array([0.4, 0.5, 0.6])}))
    6
    """
    return prod(cases.shape)
