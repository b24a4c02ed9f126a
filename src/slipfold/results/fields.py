"""Fields of results, declared once: files, tables and documentation of them follow from it."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, ClassVar, Protocol, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.models.parameter import Parameter, State
from slipfold.results.column import COMPLEX, REAL, TEXT, TRUTH, WHOLE, Column, Kind
from slipfold.results.labelled_table import Variable
from slipfold.results.plain_data import types_of
from slipfold.results.saved_table import SavedTable
from slipfold.results.table import Table, axes_of, meaning_of

__all__ = [
    "Declared",
    "Field",
    "Items",
    "Labels",
    "Part",
    "axis",
    "bound",
    "parts_of",
]

REFERENCE = re.compile(r"\{(\w+)(?:\[(\d)\])?\}")
"""Reference to a parameter or state by the attribute that names it: ``{vary}``, ``{axes[0]}``."""


class Declared(Protocol):
    """What fields want to know of their result."""

    arrays: ClassVar[Mapping[str, Any]]
    """Attributes that are arrays, besides fields that are declared so."""

    @property
    def model(self) -> Model:
        """The model."""

    def _variable_name(self, item: Parameter | State) -> str:
        """Return the name of the variable of a parameter or state."""


class Part(Protocol):
    """How one attribute of a result is written as arrays, and read back from them."""

    def variables(self, result: Declared, key: str) -> Mapping[str, Variable]:
        """Return the arrays of an attribute."""

    def names(self, key: str) -> set[str]:
        """Return names of its arrays and dimensions, besides those named for a parameter."""

    def read(self, saved: SavedTable, result: Declared, key: str) -> Any:
        """Return the attribute; those that were declared before it are there."""

    def record(self, result: Declared, key: str) -> Any:
        """Return what records hold of it."""


@cache
def parts_of(kind: type[Declared]) -> dict[str, Part]:
    """Return how attributes of a class are written as arrays, in the order of its fields."""
    hints = get_type_hints(kind, include_extras=True)
    notes = {name: getattr(hint, "__metadata__", ()) for name, hint in hints.items()}
    declared = {name: note[0] for name, note in notes.items() if note}
    own = dataclasses.fields(cast(Any, kind))
    return {item.name: declared[item.name] for item in own if item.name in declared} | {
        **kind.arrays
    }


@dataclass(frozen=True)
class Field:
    """An attribute that is an array, as the note of its type: ``Annotated[Array, Field(...)]``.

    References such as ``{vary}`` stand for the parameter that an attribute names.
    """

    dimensions: str
    """Their names, separated by spaces."""
    meaning: str
    unit: str | None = None
    """Empty for a number; None where the labels of a dimension say the unit, or for text."""
    kind: Kind | None = None
    """What values are, where the type does not say it."""
    name: str | None = None
    """Name of the variable, instead of the attribute's."""
    label: bool = False
    """Whether it labels rows rather than holds results."""
    head: str | None = "{}"
    """Heading in tables, where ``{}`` is the name of the variable; None: not there."""

    def variables(self, result: Declared, key: str) -> dict[str, Variable]:
        """Return its array; of a complex one both parts."""
        column = self._column(result, key)
        values: NDArray[Any] = np.asarray(getattr(result, key), column.kind.type)
        return column.variables(column.key, self._dimensions(result), values)

    def names(self, key: str) -> set[str]:
        """Return the names of its array and its dimensions."""
        return {each for each in (self.name or key, *self.dimensions.split()) if "{" not in each}

    def read(self, saved: SavedTable, result: Declared, key: str) -> Any:
        """Return the array, or a tuple if the field is one."""
        column, dimensions = self._column(result, key), self._dimensions(result)
        values = column.stored(column.key, dimensions, saved, axes_of(result.model))
        kind = types_of(type(result))[key]
        if get_origin(kind) is tuple:
            return tuple(values.tolist())
        return values.astype(object) if _element(kind) is np.object_ else values

    def record(self, result: Declared, key: str) -> Any:
        """Return the array; of text None where it is empty."""
        value = getattr(result, key)
        text = self._column(result, key).kind is TEXT
        return _without_empty(np.asarray(value).tolist()) if text else value

    def _dimensions(self, result: Declared) -> tuple[str, ...]:
        return tuple(bound(self.dimensions, result, result._variable_name).split())

    def _column(self, result: Declared, key: str) -> Column:
        name = bound(self.name or key, result, result._variable_name)
        types = types_of(type(result))
        kind = self.kind or (KINDS[_element(types[key])] if key in types else REAL)
        column = Column(name, kind, self.meaning, self.unit, label=self.label)
        head = None if self.head is None else bound(self.head, result, lambda item: item.name)
        return replace(_bound_column(column, result), head=head)


KINDS: dict[Any, Kind] = {
    np.float64: REAL, np.complex128: COMPLEX, np.int64: WHOLE, np.bool_: TRUTH, np.str_: TEXT,
    np.object_: TEXT, str: TEXT, float: REAL, int: WHOLE,
}  # fmt: skip


def _element(kind: Any) -> Any:
    """Return the type of the elements of an array or a tuple."""
    inner = get_args(kind)
    return get_args(inner[1])[0] if get_origin(kind) is np.ndarray else inner[0]


def axis(reference: str) -> Field:
    """Return the values of a parameter, which label the dimension that is named for it."""
    return Field(reference, reference, reference, name=reference, label=True)


@dataclass(frozen=True)
class Labels:
    """An attribute with values of parameters by name, along dimensions named for them or one."""

    dimension: str | None = None

    def variables(self, result: Declared, key: str) -> dict[str, Variable]:
        """Return the values as labels."""
        found: dict[str, Variable] = {}
        for name, values in getattr(result, key).items():
            item = result.model.parameter(name)
            label = result._variable_name(item)
            column = Column(label, REAL, meaning_of(item), item.unit, label=True)
            found |= column.variables(label, (self.dimension or label,), values)
        return found

    def names(self, key: str) -> set[str]:
        """Return the dimension, if it is not named for a parameter."""
        return set() if self.dimension is None else {self.dimension}

    def attributes(self, result: Declared, key: str) -> dict[str, Any]:
        """Return the names of the parameters."""
        return {key: " ".join(getattr(result, key))}

    def read(self, saved: SavedTable, result: Declared, key: str) -> dict[str, NDArray[Any]]:
        """Return the values by name."""
        items = [result.model.parameter(name) for name in str(saved.attributes[key]).split()]
        return {item.name: saved.columns[result._variable_name(item)] for item in items}

    def record(self, result: Declared, key: str) -> Any:
        """Return the values by name."""
        return getattr(result, key)


@dataclass(frozen=True)
class Items:
    """An attribute with many items of one class, each a row; or a tuple of them for each owner."""

    dimension: str
    kind: Callable[..., Any]
    columns: Sequence[Column]
    prefix: str = ""
    owner: tuple[str, str, str] | None = None
    """What owns items, what the number of an owner is, and an attribute as long as the owners."""

    def table(self, result: Declared) -> Table:
        """Return what is said of an item."""
        columns = tuple(_bound_column(item, result) for item in self.columns)
        owner = None if self.owner is None else self.owner[:2]
        return Table((self.dimension,), columns, self.prefix, owner)

    def variables(self, result: Declared, key: str) -> dict[str, Variable]:
        """Return an array for each column."""
        table, items = self.table(result), getattr(result, key)
        if self.owner is None:
            return table.variables(items, axes_of(result.model))
        owned = [(place, item) for place, own in enumerate(items) for item in own]
        owners = [place for place, _ in owned]
        return table.variables([item for _, item in owned], axes_of(result.model), owners)

    def names(self, key: str) -> set[str]:
        """Return the names of the arrays of its columns."""
        return {self.dimension, *(item.name or self.prefix + item.key for item in self.columns)}

    def read(self, saved: SavedTable, result: Declared, key: str) -> tuple[Any, ...]:
        """Return the items."""
        table, axes = self.table(result), axes_of(result.model)
        found = [self.kind(**table.read(saved, axes, row)) for row in range(table.count(saved))]
        if self.owner is None:
            return tuple(found)
        rows, count = table.rows(saved), len(getattr(result, self.owner[2]))
        return tuple(tuple(found[row] for row in rows[place]) for place in range(count))

    def record(self, result: Declared, key: str) -> list[dict[str, Any]]:
        """Return a record for each item."""
        table = self.table(result)
        return [table.record(item) for item in getattr(result, key)]


def _without_empty(value: Any) -> Any:
    return [_without_empty(item) for item in value] if isinstance(value, list) else value or None


def _bound_column(column: Column, result: Declared) -> Column:
    """Return a column with the references in its meaning and unit replaced."""
    unit = column.unit
    if unit is not None:
        unit = bound(unit, result, lambda item: item.unit)
    return replace(column, meaning=bound(column.meaning, result, meaning_of), unit=unit)


def bound(text: str, result: Declared, shown: Callable[[Any], str]) -> str:
    """Return a text with its references replaced: parameters are shown in some way."""

    def found(match: re.Match[str]) -> str:
        value = getattr(result, match[1])
        if match[2] is not None:
            value = value[int(match[2])]
        if not isinstance(value, str):
            return shown(value)
        known: dict[str, Parameter | State] = {item.name: item for item in result.model.states}
        known |= {item.name: item for item in result.model.parameters}
        return shown(known[value]) if value in known else value

    return REFERENCE.sub(found, text)
