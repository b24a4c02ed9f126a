"""One field of a result, said once: what files, records and spreadsheets hold of it follows."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.results.labelled_table import Variable
from slipfold.results.saved_table import SavedTable

__all__ = ["COMPLEX", "REAL", "TEXT", "TRUTH", "WHOLE", "Axes", "Column", "Kind", "plain"]

Axes = Mapping[str, Sequence[str]]
"""What stands along each dimension, in words with units."""


WITH_UNITS = frozenset({
    "state", "output", "parameter", "by_parameter", "quantity", "fitted", "chosen", "scattered",
})  # fmt: skip
"""Dimensions whose labels have units, in a variable of their own."""


@dataclass(frozen=True)
class Kind:
    """What values are, and what stands where there is none."""

    type: type
    missing: Any


TEXT, WHOLE, TRUTH = Kind(np.str_, ""), Kind(np.int64, 0), Kind(np.bool_, False)
REAL, COMPLEX = Kind(np.float64, np.nan), Kind(np.complex128, np.nan)


@dataclass(frozen=True)
class Column:
    """A field of the items of a table."""

    key: str
    """Attribute of an item, argument of its class, and key in records; dots lead inside."""
    kind: Kind = REAL
    meaning: str = ""
    """What it is; without one, it is not among the arrays."""
    unit: str | None = None
    """Empty for a number; None where other columns say the unit, or there can be none."""
    dimensions: tuple[str, ...] = ()
    """Those of one value."""
    get: Callable[[Any], Any] | None = None
    """Returns the value from an item, instead of the attribute."""
    name: str | None = None
    """Name of the variable, instead of the key behind the prefix of the table."""
    label: bool = False
    """Whether it labels rows rather than holds results."""
    derived: bool = False
    """Whether it follows from others, so that nothing is made from it."""
    optional: bool = False
    """Whether what is missing is None, and empty in spreadsheets."""
    record: bool = False
    """Whether it is in records."""
    late: bool = False
    """Whether files of earlier versions lack it."""
    slot: str | None = None
    """Its place in a spreadsheet, instead of the key."""
    head: str | None = "{}"
    """Heading in tables, where ``{}`` is the name of the variable; None: not there."""

    def of(self, item: Any) -> Any:
        """Return the value of an item."""
        return (self.get or attrgetter(self.key))(item)

    def values(self, items: Sequence[Any], axes: Axes, own: int = 0) -> NDArray[Any]:
        """Return the values of all items, one behind the other; shorter ones are filled up.

        Shapes: values (n_rows, ...). An item has `own` axes of rows itself, or is a row.
        """
        missing = self.kind.missing
        found = [missing if (value := self.of(item)) is None else value for item in items]
        parts: list[NDArray[Any]] = [np.asarray(value, self.kind.type) for value in found]
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
        """Return one value out of a file as items hold it."""
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


def plain(value: Any) -> Any:
    """Return what JSON can hold: pairs for complex numbers, None for what is not finite.

    >>> plain({"a": (1, float("inf")), "b": 2 - 1j})
    {'a': [1, None], 'b': [2.0, -1.0]}
    """
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, complex):
        return plain((value.real, value.imag))
    return None if isinstance(value, float) and not math.isfinite(value) else value
