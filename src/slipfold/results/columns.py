"""Columns of a labelled table, gathered from the rows of a result."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.models.output import Output
from slipfold.models.parameter import Parameter, State
from slipfold.results.labelled_table import Variable

__all__ = [
    "Columns",
    "integers",
    "joined",
    "named_parameter",
    "padded",
    "padded_integers",
    "quantity_labels",
    "reals",
    "stacked",
    "state_labels",
    "texts",
]


class Columns:
    """Variables along one dimension, being gathered.

    Parameters
    ----------
    dimension
        Name of the dimension, e.g. ``"point"``.
    """

    def __init__(self, dimension: str) -> None:
        self.dimension = dimension
        self.variables: dict[str, Variable] = {}

    def add(
        self, name: str, values: NDArray[Any], long_name: str, units: str | None = None, *more: str
    ) -> None:
        """Add a column.

        Shapes: values (n_rows, ...).
        """
        if np.iscomplexobj(values):
            for suffix, part, values_of in (
                ("real", "real", values.real),
                ("imag", "imaginary", values.imag),
            ):
                about = f"{long_name}, {part} part"
                self.add(f"{name}_{suffix}", values_of.copy(), about, units, *more)
            return
        attributes = {"long_name": long_name}
        if units is not None:
            attributes["units"] = units or "1"
        self.variables[name] = Variable((self.dimension, *more), values, attributes)


def quantity_labels(model: Model) -> dict[str, Variable]:
    """Return the coordinates that name states and outputs, with unit and meaning of each."""
    labels: dict[str, Variable] = {}
    described: dict[str, tuple[State | Output, ...]] = {
        "state": model.states,
        "output": (*model.states, *model.outputs()),
    }
    for dimension, items in described.items():
        columns = Columns(dimension)
        columns.add(dimension, texts(item.name for item in items), f"name of the {dimension}")
        units = texts(item.unit for item in items)
        columns.add(f"{dimension}_units", units, f"unit of the {dimension}, empty for a number")
        meanings = texts(item.doc for item in items)
        columns.add(f"{dimension}_long_name", meanings, f"meaning of the {dimension}")
        labels |= columns.variables
    return labels


def state_labels(model: Model) -> dict[str, Variable]:
    """Return the coordinates that name the states alone."""
    labels = quantity_labels(model)
    return {name: item for name, item in labels.items() if item.dimensions == ("state",)}


def named_parameter(parameter: Parameter) -> str:
    """Return what the values of a parameter are."""
    return f"{parameter.name}: {parameter.doc}" if parameter.doc else parameter.name


def texts(items: Iterable[str]) -> NDArray[np.str_]:
    """Return text as an array, shape (n,)."""
    return np.array(list(items), dtype=str)


def integers(items: Iterable[int]) -> NDArray[np.int64]:
    """Return whole numbers as an array, shape (n,)."""
    return np.array(list(items), dtype=np.int64)


def reals(items: Iterable[float | None]) -> NDArray[np.float64]:
    """Return numbers as an array, shape (n,); None becomes NaN."""
    return np.array([np.nan if item is None else item for item in items], dtype=np.float64)


def joined(
    parts: Iterable[NDArray[Any]], shape: tuple[int, ...] = (), kind: type = float
) -> NDArray[Any]:
    """Join arrays along their first axis, none at all included.

    Shapes: parts (n_i, *shape).
    """
    return np.concatenate([np.empty((0, *shape), kind), *parts])


def stacked(
    rows: Iterable[NDArray[Any]], shape: tuple[int, ...], kind: type = float
) -> NDArray[Any]:
    """Stack rows, none at all included."""
    return joined((row[None] for row in rows), shape, kind)


def padded(parts: Iterable[NDArray[np.float64]], shape: tuple[int, int]) -> NDArray[np.float64]:
    """Join orbits of different numbers of nodes; what is missing is NaN.

    Shapes: parts (n_i, m_i, n_states).
    """
    filled = [
        np.pad(part, ((0, 0), (0, shape[0] - part.shape[1]), (0, 0)), constant_values=np.nan)
        for part in parts
    ]
    return joined(filled, shape)


def padded_integers(rows: Iterable[Sequence[int]]) -> NDArray[np.int64]:
    """Return rows of whole numbers from 1, filled up with zeros, shape (n_rows, longest).

    Examples
    --------
    >>> padded_integers([(1, 2), (), (2,)]).tolist()
    [[1, 2], [0, 0], [2, 0]]
    """
    known = list(rows)
    filled = np.zeros((len(known), max(map(len, known), default=0)), np.int64)
    for index, row in enumerate(known):
        filled[index, : len(row)] = row
    return filled
