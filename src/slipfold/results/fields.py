"""Fields of results, declared once: files, tables and documentation of them follow from it."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from operator import attrgetter
from types import SimpleNamespace
from typing import Any, cast, get_args, get_origin

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.models.quantities import Output, Parameter, State
from slipfold.read_only import field_hints
from slipfold.results.records import SavedTable, types_of
from slipfold.results.tables import Variable
from slipfold.text import headed

Axes = Mapping[str, Sequence[str]]
"""Labels along each dimension, with units."""

WITH_UNITS = frozenset({
    "state", "output", "parameter", "by_parameter", "quantity", "fitted", "chosen", "uncertain",
})  # fmt: skip
"""Dimensions whose labels have units, in a variable of their own."""

REFERENCE = re.compile(r"\{(\w+)(?:\[(\d)\])?(\.name)?\}")
"""Reference to a parameter or state by the attribute that names it: ``{vary}``, ``{axes[0]}``.

``{vary.name}`` is its name instead of its meaning or unit. Other texts stand for themselves.
"""


@dataclass(frozen=True)
class ValueType:
    """Type of values, and the value that stands for a missing one."""

    type: type
    missing: Any


TEXT, WHOLE, TRUTH = ValueType(np.str_, ""), ValueType(np.int64, 0), ValueType(np.bool_, False)
REAL, COMPLEX = ValueType(np.float64, np.nan), ValueType(np.complex128, np.nan)

KINDS: dict[Any, ValueType] = {
    np.float64: REAL, np.complex128: COMPLEX, np.int64: WHOLE, np.bool_: TRUTH, np.str_: TEXT,
    np.object_: TEXT, str: TEXT, float: REAL, int: WHOLE,
}  # fmt: skip


class ResultPart:
    """How one attribute of a result is written as arrays, and read back from them."""

    doc = ""
    """Text of a docstring."""

    def variables(self, result: Any, key: str) -> Mapping[str, Variable]:
        """Return the arrays of an attribute."""
        return {}

    def names(self, key: str) -> set[str]:
        """Return names of its arrays and dimensions, besides those named for a parameter."""
        return set()

    def attributes(self, result: Any, key: str) -> dict[str, Any]:
        """Return the attributes of the file that it needs besides its arrays."""
        return {}

    def read(self, saved: SavedTable, result: Any, key: str) -> Any:
        """Return the attribute; those that were declared before it are there."""
        raise NotImplementedError

    def record(self, result: Any, key: str) -> Any:
        """Return it as records hold it; nothing where they hold its parts."""
        return None

    def described(self) -> str:
        """Return the text of a docstring."""
        return self.doc


@cache
def parts_of(kind: Any) -> dict[str, ResultPart]:
    """Return how attributes of a class are written as arrays, in the order of its fields."""
    notes = {k: getattr(hint, "__metadata__", ()) for k, hint in field_hints(kind).items()}
    declared = {
        name: note[0] for name, note in notes.items() if note and isinstance(note[0], ResultPart)
    }
    own = dataclasses.fields(kind)
    return {item.name: declared[item.name] for item in own if item.name in declared} | {
        **kind.arrays
    }


@dataclass(frozen=True)
class Column:
    """A field of the items of a table."""

    key: str
    """Attribute of an item, argument of its class, and key in records; dots lead inside."""
    kind: ValueType = REAL
    meaning: str = ""
    """Meaning of the values; a column without one is not among the arrays."""
    unit: str | None = None
    """Empty for a number; None where other columns say the unit, or there can be none."""
    dimensions: tuple[str, ...] = ()
    """Dimensions of one value."""
    get: Callable[[Any], Any] | None = None
    """Returns the value from an item, instead of the attribute."""
    name: str | None = None
    """Name of the variable, instead of the key behind the prefix of the table."""
    label: bool = False
    """Whether it labels rows rather than holds results."""
    derived: bool = False
    """Whether it follows from other columns and is not read back."""
    optional: bool = False
    """Whether a missing value is None."""
    record: bool = False
    """Whether it is in records."""
    head: str | None = "{}"
    """Heading in tables, where ``{}`` is the name of the variable; None: not there."""
    when: str = ""
    """Parts of a result, separated by spaces, without which the column is not there."""

    def bound(self, result: Any) -> Column:
        """Return it with its references replaced."""
        texts: dict[str, tuple[str | None, Callable[[Any], str]]] = {
            "meaning": (self.meaning, meaning_of),
            "unit": (self.unit, attrgetter("unit")),
            "name": (self.name, result._variable_name),
            "head": (self.head, attrgetter("name")),
        }
        changed = {key: bound(text, result, shown) for key, (text, shown) in texts.items() if text}
        return replace(self, **cast(Any, changed))

    def of(self, item: Any) -> Any:
        """Return the value of an item."""
        return (self.get or attrgetter(self.key))(item)

    def values(self, items: Sequence[Any], axes: Axes, own: int = 0) -> NDArray[Any]:
        """Return the values of all items, one behind the other; shorter ones are filled up.

        Shapes: values (n_rows, ...). An item has `own` axes of rows itself, or is a row.
        """
        missing = self.kind.missing
        result = [missing if (value := self.of(item)) is None else value for item in items]
        parts: list[NDArray[Any]] = [np.asarray(value, self.kind.type) for value in result]
        if not own:
            parts, own = [part[None] for part in parts], 1
        shape = [
            max([len(axes.get(name, ())), *(part.shape[axis] for part in parts)])
            for axis, name in enumerate(self.dimensions, own)
        ]
        if not parts:
            return np.empty((0, *shape), self.kind.type)
        return np.concatenate([_filled(part, own, shape, missing) for part in parts])

    def variables(
        self, name: str, dimensions: tuple[str, ...], values: NDArray[Any]
    ) -> dict[str, Variable]:
        """Return its variable by name."""
        along = (*dimensions, *self.dimensions)
        unit = self.unit
        if unit is None and self.kind in (REAL, COMPLEX) and WITH_UNITS & {*along[-1:]}:
            unit = f"see {along[-1]}_units"
        attributes = {"long_name": self.meaning, "units": unit or "1"}
        head = None if self.head is None else self.head.format(name)
        return {name: Variable(along, values, attributes, self.label, head)}

    def stored(
        self, name: str, dimensions: tuple[str, ...], saved: SavedTable, axes: Axes
    ) -> NDArray[Any]:
        """Return all values in a file, in the shape that they should have."""
        values = saved.complex(name) if self.kind is COMPLEX else saved.columns[name]
        along = (*dimensions, *self.dimensions)
        known = {axis: len(axes[each]) for axis, each in enumerate(along) if each in axes}
        if len(along) != values.ndim or any(values.shape[k] != n for k, n in known.items()):
            raise ValueError(f"{name} has the shape {values.shape}")
        return values

    def item(self, value: Any) -> Any:
        """Convert a value from a file to the form that items hold."""
        if not self.dimensions:
            single = value.item()
            empty = single == self.kind.missing or single != single
            return None if self.optional and empty else single
        if self.dimensions in (("parameter",), ("bound",)):
            return tuple(value.tolist())
        return tuple(value[value != 0].tolist()) if self.kind is WHOLE else value


def _filled(part: NDArray[Any], own: int, shape: Sequence[int], missing: Any) -> NDArray[Any]:
    """Fill up a part along all axes but its own."""
    short = [(0, size - had) for size, had in zip(shape, part.shape[own:], strict=True)]
    if not any(after for _, after in short):
        return part
    return np.pad(part, [(0, 0)] * own + short, constant_values=missing)


@dataclass(frozen=True)
class Items(ResultPart):
    """Columns of items of one class, each a row, with what each item owns.

    It declares an attribute of a result, or is part of another declaration.
    """

    dimension: str
    """Along which the items stand, e.g. ``"point"``."""
    columns: Sequence[Column]
    prefix: str = ""
    """Beginning of the names of variables."""
    kind: Callable[..., Any] = dict
    """Makes an item from its fields."""
    doc: str = ""
    """Text of a docstring."""
    owner: tuple[str, str] | None = None
    """Name of the owner of the items and meaning of its number, which is the first column."""
    owners: str = ""
    """Attribute with an entry an owner; the attribute of the result is then a tuple for each."""
    joined: bool = False
    """Whether an item has many rows, such as the points of a branch."""
    rows: Items | None = None
    """Rows that an item has itself, such as the points of a curve."""
    owned: Mapping[str, Items] = field(default_factory=dict)
    """Items that an item owns, by attribute; it has a number, ``id``."""

    def bound(self, result: Any) -> Items:
        """Return it with its references replaced."""
        return replace(
            self,
            dimension=bound(self.dimension, result, result._variable_name),
            prefix=bound(self.prefix, result, result._variable_name),
            columns=tuple(item.bound(result) for item in self.columns),
            owner=self.owner and cast(Any, tuple(bound(t, result, str) for t in self.owner)),
            rows=self.rows and self.rows.bound(result),
            owned={key: table.bound(result) for key, table in self.owned.items()},
        )

    def arrays(
        self, items: Iterable[Any], axes: Axes, owners: Iterable[int] = ()
    ) -> dict[str, Variable]:
        """Return the arrays of items, of their rows and of what they own."""
        known, result, along = list(items), dict[str, Variable](), (self.dimension,)
        if self.owner is not None:
            counts = [len(item) for item in known] if self.joined else 1
            numbers = np.repeat(np.array(list(owners), np.int64), counts)
            owner = Column("", WHOLE, self.owner[1], "", label=True, head=self.owner[0])
            result |= owner.variables(self._owner_name, along, numbers)
        for column in self.columns:
            if column.meaning:
                head = None if column.head is None else column.head.format(column.key)
                values = column.values(known, axes, int(self.joined))
                result |= replace(column, head=head).variables(self._name(column), along, values)
        if self.rows is not None:
            result |= self.rows.arrays(known, axes, [item.id for item in known])
        for key, table in self.owned.items():
            owned = [(item.id, own) for item in known for own in getattr(item, key)]
            result |= table.arrays([own for _, own in owned], axes, [number for number, _ in owned])
        return result

    def record_of(self, item: Any) -> dict[str, Any]:
        """Return the record of an item."""
        return nested({column.key: column.of(item) for column in self.columns if column.record})

    def count(self, saved: SavedTable) -> int:
        """Return how many items there are in a file."""
        name = next(self._name(column) for column in self.columns if column.meaning)
        return len(saved.columns[name])

    def rows_by_owner(self, saved: SavedTable) -> Mapping[int, NDArray[np.int64]]:
        """Return the rows in a file that belong to each owner."""
        return saved.rows(self.dimension, self._owner_name)

    def fields(self, saved: SavedTable, axes: Axes, rows: Any) -> dict[str, Any]:
        """Return the fields of the item in a row of a file, or in many rows if `joined`."""
        result = {}
        for column in self.columns:
            if column.meaning and not column.derived:
                values = column.stored(self._name(column), (self.dimension,), saved, axes)[rows]
                result[column.key] = values if self.joined else column.item(values)
        return nested(result)

    def all_fields(self, saved: SavedTable, axes: Axes) -> Iterator[dict[str, Any]]:
        """Yield the fields of each item; of what it owns, a tuple of items."""
        owned = [(key, table, table.rows_by_owner(saved)) for key, table in self.owned.items()]
        rows = None if self.rows is None else self.rows.rows_by_owner(saved)
        for row in range(self.count(saved)):
            result = self.fields(saved, axes, row)
            number = int(saved.columns[self.dimension][row]) if self.rows or owned else 0
            if self.rows is not None and rows is not None:
                result |= self.rows.fields(saved, axes, rows[number])
            for key, table, own in owned:
                items = (table.kind(**table.fields(saved, axes, each)) for each in own[number])
                result[key] = tuple(items)
            yield result

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return an array for each column."""
        table, items, axes = self.bound(result), getattr(result, key), axes_of(result)
        if not self.owners:
            return table.arrays(items, axes)
        owned = [(place, item) for place, own in enumerate(items) for item in own]
        return table.arrays([item for _, item in owned], axes, [place for place, _ in owned])

    def names(self, key: str) -> set[str]:
        """Return the names of the arrays of its columns."""
        return {self.dimension, *(item.name or self.prefix + item.key for item in self.columns)}

    def read(self, saved: SavedTable, result: Any, key: str) -> tuple[Any, ...]:
        """Return the items."""
        table = self.bound(result)
        items = [self.kind(**fields) for fields in table.all_fields(saved, axes_of(result))]
        if not self.owners:
            return tuple(items)
        rows, count = table.rows_by_owner(saved), len(getattr(result, self.owners))
        return tuple(tuple(items[row] for row in rows[place]) for place in range(count))

    def record(self, result: Any, key: str) -> list[dict[str, Any]]:
        """Return a record for each item."""
        table = self.bound(result)
        return [table.record_of(item) for item in getattr(result, key)]

    def _name(self, column: Column) -> str:
        return column.name or self.prefix + column.key

    @property
    def _owner_name(self) -> str:
        assert self.owner is not None
        return f"{self.owner[0]}_of_{self.dimension}"


@dataclass(frozen=True)
class Entry(ResultPart):
    """An attribute that is an array, as the note of its type: ``Annotated[Array, Entry(...)]``.

    References such as ``{vary}`` stand for the parameter that an attribute names.
    """

    dimensions: str
    """Their names, separated by spaces."""
    meaning: str
    unit: str | None = None
    """Empty for a number; None where the labels of a dimension say the unit, or for text."""
    kind: ValueType | None = None
    """Type of the values, if the annotation does not give it."""
    name: str | None = None
    """Name of the variable, instead of the attribute's."""
    label: bool = False
    """Whether it labels rows rather than holds results."""
    head: str | None = "{}"
    """Heading in tables, where ``{}`` is the name of the variable; None: not there."""
    doc: str = ""
    """Text of a docstring, instead of the meaning."""
    more: str = ""
    """Addition to a docstring, e.g. the value that stands for a missing one."""

    def described(self) -> str:
        """Return its meaning and its dimensions."""
        text = self.doc or self.meaning[:1].upper() + self.meaning[1:]
        names = REFERENCE.sub(lambda match: match[0].strip("{}"), self.dimensions).split()
        shape = f"({', '.join(names)}{',' * (len(names) == 1)})"
        return f"{text}, shape {shape}{'; ' * bool(self.more)}{self.more}."

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return its array; of a complex one both parts."""
        column = self._column(result, key)
        values: NDArray[Any] = np.asarray(getattr(result, key), column.kind.type)
        return column.variables(column.name or key, self._dimensions(result), values)

    def names(self, key: str) -> set[str]:
        """Return the names of its array and its dimensions."""
        return {each for each in (self.name or key, *self.dimensions.split()) if "{" not in each}

    def read(self, saved: SavedTable, result: Any, key: str) -> Any:
        """Return the array, or a tuple if the field is one."""
        column, dimensions = self._column(result, key), self._dimensions(result)
        values = column.stored(column.name or key, dimensions, saved, axes_of(result))
        kind = types_of(_declaring(result))[key]
        if get_origin(kind) is tuple:
            return tuple(values.tolist())
        return values.astype(object) if _element(kind) is np.object_ else values

    def record(self, result: Any, key: str) -> Any:
        """Return the array; of text None where it is empty."""
        value = getattr(result, key)
        text = self._column(result, key).kind is TEXT
        return _without_empty(np.asarray(value).tolist()) if text else value

    def _dimensions(self, result: Any) -> tuple[str, ...]:
        return tuple(bound(self.dimensions, result, result._variable_name).split())

    def _column(self, result: Any, key: str) -> Column:
        types = types_of(_declaring(result))
        kind = self.kind or (KINDS[_element(types[key])] if key in types else REAL)
        column = Column(
            key, kind, self.meaning, self.unit, name=self.name, label=self.label, head=self.head
        )
        return column.bound(result)


def _element(kind: Any) -> Any:
    """Return the type of the elements of an array or a tuple."""
    inner = get_args(kind)
    return get_args(inner[1])[0] if get_origin(kind) is np.ndarray else inner[0]


def _without_empty(value: Any) -> Any:
    return [_without_empty(item) for item in value] if isinstance(value, list) else value or None


def axis(reference: str) -> Entry:
    """Return the values of a parameter, which label the dimension that is named for it."""
    doc = "Values of the parameter or state, increasing"
    return Entry(reference, reference, reference, name=reference, label=True, doc=doc)


@dataclass(frozen=True)
class Labels(ResultPart):
    """An attribute with values of parameters by name, along dimensions named for them or one."""

    dimension: str | None = None

    def described(self) -> str:
        """Return what a docstring says of them."""
        along = "" if self.dimension is None else f", one a {self.dimension}"
        return f"Values of parameters by name{along}."

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
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

    def attributes(self, result: Any, key: str) -> dict[str, Any]:
        """Return the names of the parameters."""
        return {key: " ".join(getattr(result, key))}

    def read(self, saved: SavedTable, result: Any, key: str) -> dict[str, NDArray[Any]]:
        """Return the values by name."""
        items = [result.model.parameter(name) for name in str(saved.attributes[key]).split()]
        return {item.name: saved.columns[result._variable_name(item)] for item in items}

    def record(self, result: Any, key: str) -> Any:
        """Return the values by name."""
        return getattr(result, key)


@dataclass(frozen=True)
class Nested(ResultPart):
    """An attribute that has declared attributes itself, or is None."""

    kind: Callable[..., Any]
    parts: Mapping[str, ResultPart]
    """Declarations of its attributes."""
    doc: str = ""
    """Text of a docstring."""
    given: Mapping[str, Callable[[SavedTable, Any], Any]] = field(default_factory=dict)
    """Functions that return other attributes from the file and the result."""

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return the arrays of all its attributes."""
        item, found = getattr(result, key), dict[str, Variable]()
        if item is not None:
            for name, part in self.parts.items():
                found |= part.variables(_Inner(result, item, self.kind), name)
        return found

    def names(self, key: str) -> set[str]:
        """Return the names of its arrays and dimensions."""
        return set().union(*(part.names(name) for name, part in self.parts.items()))

    def read(self, saved: SavedTable, result: Any, key: str) -> Any:
        """Return the attribute, None if the file has nothing of it."""
        entries = {name: part for name, part in self.parts.items() if isinstance(part, Entry)}
        if not {part.name or name for name, part in entries.items()} & set(saved.columns):
            return None
        item = SimpleNamespace(**{name: get(saved, result) for name, get in self.given.items()})
        for name, part in self.parts.items():
            vars(item)[name] = part.read(saved, _Inner(result, item, self.kind), name)
        for values in vars(item).values():
            if isinstance(values, np.ndarray):
                values.setflags(write=False)
        return self.kind(**vars(item))


class _Inner:
    """A nested attribute; what it lacks is that of the result that holds it."""

    def __init__(self, result: Any, item: Any, kind: Any) -> None:
        self.result, self.item, self.kind = result, item, kind

    def __getattr__(self, name: str) -> Any:
        return getattr(self.item if hasattr(self.item, name) else self.result, name)


def _declaring(result: Any) -> Any:
    """Return the class whose fields are declared."""
    return result.kind if isinstance(result, _Inner) else type(result)


def nested(flat: dict[str, Any]) -> dict[str, Any]:
    """Return values by keys with dots as nested dictionaries.

    >>> nested({"id": 1, "started.kind": "span", "started.value": 0.5})
    {'id': 1, 'started': {'kind': 'span', 'value': 0.5}}
    """
    result: dict[str, Any] = {}
    for key, value in flat.items():
        *outer, last = key.split(".")
        place = result
        for name in outer:
            place = place.setdefault(name, {})
        place[last] = value
    return result


def names(dimension: str, items: Iterable[Parameter | State | Output]) -> dict[str, Variable]:
    """Return the labels of a dimension along which quantities stand: name, unit, meaning."""
    columns = (
        Column("name", TEXT, f"name of the {dimension}", name=dimension, label=True),
        Column("unit", TEXT, f"unit of the {dimension}, empty for a number",
               name=f"{dimension}_units", label=True),
        Column("doc", TEXT, f"meaning of the {dimension}",
               name=f"{dimension}_long_name", label=True),
    )  # fmt: skip
    return Items(dimension, columns).arrays(items, {})


def axes_of(result: Any, nodes: int = 0) -> dict[str, list[str]]:
    """Return the labels along the dimensions that results share."""
    model: Model = result.model
    states = [headed(item) for item in model.states]
    vary = getattr(result, "vary", ())
    return {
        "state": states,
        "output": [*states, *(headed(item) for item in model.outputs())],
        "multiplier": [str(number) for number in range(1, len(states) + 1)],
        "by_parameter": [headed(item) for item in model.parameters],
        "parameter": [
            headed(model.parameter(name)) for name in ((vary,) if isinstance(vary, str) else vary)
        ],
        **({"node": [""] * nodes} if nodes else {}),
    }


def meaning_of(parameter: Parameter | State) -> str:
    """Return the meaning of a parameter."""
    return f"{parameter.name}: {parameter.doc}" if parameter.doc else parameter.name


def bound(text: str, result: Any, shown: Callable[[Any], str]) -> str:
    """Return a text with its references replaced by what `shown` returns of them."""

    def found(match: re.Match[str]) -> str:
        value = getattr(result, match[1])
        if match[2] is not None:
            value = value[int(match[2])]
        if isinstance(value, str):
            known: dict[str, Parameter | State] = {item.name: item for item in result.model.states}
            known |= {item.name: item for item in result.model.parameters}
            if match[1] == "thing" or value not in known:
                return value
            value = known[value]
        return value.name if match[3] else shown(value)

    return REFERENCE.sub(found, text)
