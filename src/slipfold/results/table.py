"""Columns along one dimension: to arrays and back, and to records."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.models.output import Output
from slipfold.models.parameter import Parameter, State
from slipfold.results.column import TEXT, WHOLE, Axes, Column
from slipfold.results.labelled_table import Variable
from slipfold.results.saved_table import SavedTable
from slipfold.text.one_line import headed

__all__ = ["Table", "axes_of", "meaning_of", "names"]


@dataclass(frozen=True)
class Table:
    """What is said of items of one kind."""

    dimensions: tuple[str, ...]
    """Along which the items stand, e.g. ``("point",)``."""
    columns: tuple[Column, ...]
    prefix: str = ""
    """What names of variables begin with."""
    owner: tuple[str, str] | None = None
    """What the items belong to, and how: a column of its numbers goes in front."""
    joined: bool = False
    """Whether an item has many rows, such as the points of a branch."""

    def variables(
        self, items: Iterable[Any], axes: Axes, owners: Iterable[int] = ()
    ) -> dict[str, Variable]:
        """Return the arrays of items, and which belongs to what."""
        rows = list(items)
        found: dict[str, Variable] = {}
        if self.owner is not None:
            numbers = np.array(list(owners), np.int64)
            if self.joined:
                numbers = np.repeat(numbers, [len(item) for item in rows])
            owner = Column("", WHOLE, self.owner[1], "", label=True, head=self.owner[0])
            found |= owner.variables(self._owner_name, self.dimensions, numbers)
        for column in self.columns:
            if column.meaning:
                values = column.values(rows, axes, self.own)
                head = None if column.head is None else column.head.format(column.key)
                told = replace(column, head=head)
                found |= told.variables(self._name(column), self.dimensions, values)
        return found

    def record(self, item: Any) -> dict[str, Any]:
        """Return what records hold of an item."""
        return nested({column.key: column.of(item) for column in self.columns if column.record})

    def count(self, saved: SavedTable) -> int:
        """Return how many items there are in a file."""
        name = next(self._name(column) for column in self.columns if column.meaning)
        return len(saved.columns[name])

    def rows(self, saved: SavedTable) -> Mapping[int, NDArray[np.int64]]:
        """Return which rows in a file belong to what."""
        return saved.rows(self.dimensions[0], self._owner_name)

    def read(self, saved: SavedTable, axes: Axes, rows: Any) -> dict[str, Any]:
        """Return the fields of the item in a row of a file, or in many rows if `joined`."""
        found = {}
        for column in self.columns:
            if column.late and self._name(column) not in saved.columns:
                continue
            if column.meaning and not column.derived:
                values = column.stored(self._name(column), self.dimensions, saved, axes)[rows]
                found[column.key] = values if self.joined else column.item(values)
        return nested(found)

    def _name(self, column: Column) -> str:
        return column.name or self.prefix + column.key

    @property
    def own(self) -> int:
        """Axes of rows that an item itself has."""
        return len(self.dimensions) if self.joined else 0

    @property
    def _owner_name(self) -> str:
        assert self.owner is not None
        return f"{self.owner[0]}_of_{self.dimensions[0]}"


def nested(flat: dict[str, Any]) -> dict[str, Any]:
    """Return values by keys with dots as dictionaries inside of each other.

    >>> nested({"id": 1, "begun.kind": "span", "begun.value": 0.5})
    {'id': 1, 'begun': {'kind': 'span', 'value': 0.5}}
    """
    found: dict[str, Any] = {}
    for key, value in flat.items():
        *outer, last = key.split(".")
        place = found
        for name in outer:
            place = place.setdefault(name, {})
        place[last] = value
    return found


def names(dimension: str, items: Iterable[Parameter | State | Output]) -> dict[str, Variable]:
    """Return the labels of a dimension along which quantities stand: name, unit, meaning."""
    columns = (
        Column("name", TEXT, f"name of the {dimension}", name=dimension, label=True),
        Column("unit", TEXT, f"unit of the {dimension}, empty for a number",
               name=f"{dimension}_units", label=True),
        Column("doc", TEXT, f"meaning of the {dimension}",
               name=f"{dimension}_long_name", label=True),
    )  # fmt: skip
    return Table((dimension,), columns).variables(items, {})


def axes_of(model: Model, vary: Sequence[str] = (), nodes: int = 0) -> dict[str, list[str]]:
    """Return what stands along the dimensions that results share."""
    states = [headed(item) for item in model.states]
    found = {
        "state": states,
        "output": [*states, *(headed(item) for item in model.outputs())],
        "multiplier": [str(number) for number in range(1, len(states) + 1)],
        "by_parameter": [headed(item) for item in model.parameters],
        "parameter": [headed(model.parameter(name)) for name in vary],
    }
    return found | ({"node": [""] * nodes} if nodes else {})


def meaning_of(parameter: Parameter) -> str:
    """Return what the values of a parameter are."""
    return f"{parameter.name}: {parameter.doc}" if parameter.doc else parameter.name
