"""Tables with one row a point, from labelled arrays: for spreadsheets and pandas."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.results.labelled_table import Variable

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]


@dataclass(frozen=True)
class Frame:
    """Columns of equal length by name, and their units."""

    columns: Mapping[str, Sequence[Any] | NDArray[Any]]
    units: Mapping[str, str]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def take(self, rows: Sequence[int]) -> Frame:
        """Return some of the rows."""
        columns = {name: [each[row] for row in rows] for name, each in self.columns.items()}
        return Frame(columns, self.units)

    def to_csv(self) -> str:
        r"""Return it as comma-separated values; numbers are exact, what is missing is empty.

        >>> Frame({"a": [0.1, float("nan")], "b": [True, False]}, {"a": "m"}).to_csv()
        'a (m),b\n0.1,1\n,0\n'
        """
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        units = self.units
        writer.writerow(
            [f"{name} ({units[name]})" if units.get(name) else name for name in self.columns]
        )
        writer.writerows(zip(*map(_cells, self.columns.values()), strict=True))
        return text.getvalue()

    def to_dataframe(self) -> pandas.DataFrame:
        """Return it as a table of pandas, with the units among its attributes."""
        import pandas

        found = pandas.DataFrame(dict(self.columns))
        found.attrs["units"] = dict(self.units)
        return found


def _cells(column: Sequence[Any] | NDArray[Any]) -> list[Any]:
    values = column.tolist() if isinstance(column, np.ndarray) else list(column)
    return [
        "" if value is None or value != value else int(value) if value is True or value is False
        else value
        for value in values
    ]  # fmt: skip


def frame_of(variables: Mapping[str, Variable], rows: Sequence[str]) -> Frame:
    """Return the arrays that lie along all dimensions in `rows`, one row for each of their places.

    Other dimensions of an array stand side by side.
    """
    sizes = {
        name: size
        for item in variables.values()
        for name, size in zip(item.dimensions, item.values.shape, strict=True)
    }
    shape = tuple(sizes[name] for name in rows)
    columns: dict[str, Any] = {}
    units: dict[str, str] = {}

    def add(head: str, unit: str, values: NDArray[Any]) -> None:
        parts = {head: values}
        if values.dtype.kind == "c":
            parts = {f"{head} real": values.real, f"{head} imaginary": values.imag}
        columns.update(parts)
        units.update(dict.fromkeys(parts, "" if unit == "1" or unit.startswith("see ") else unit))

    for name, numbers in zip(rows, np.indices(shape).reshape(len(rows), -1), strict=True):
        label = variables.get(name)
        if label is not None and label.head is not None:
            add(label.head, label.attributes["units"], label.values[numbers])
        elif label is None and len(rows) > 1:
            add(name, "", numbers)
    for name, item in variables.items():
        if name in rows or item.head is None or not set(rows) <= set(item.dimensions):
            continue
        others = [each for each in item.dimensions if each not in rows]
        order = [item.dimensions.index(each) for each in (*rows, *others)]
        known: NDArray[Any] = item.values.transpose(order).reshape(
            -1, *(sizes[each] for each in others)
        )
        for place in product(*(range(sizes[each]) for each in others)):
            words, unit = _said(variables, dict(zip(others, place, strict=True)))
            stated = item.attributes["units"]
            head = " ".join(filter(None, [item.head, words]))
            # Where labels say the unit, it is that of the last dimension.
            known_unit = unit if others and stated == f"see {others[-1]}_units" else stated
            add(head, known_unit, np.moveaxis(known, 0, -1)[place])
    return Frame(columns, units)


def _said(variables: Mapping[str, Variable], places: Mapping[str, int]) -> tuple[str, str]:
    """Return what places along dimensions are labelled, and the unit that labels say."""
    words, unit = [], ""
    for name, index in places.items():
        label, of = variables.get(name), variables.get(f"{name}_units")
        words.append(str(index + 1) if label is None else str(label.values[index]))
        unit = unit if of is None else str(of.values[index])
    return " over ".join(words), unit


def joined(frames: Sequence[Frame]) -> Frame:
    """Return frames one below the other; a column that one of them lacks is empty there."""
    heads = dict.fromkeys(head for each in frames for head in each.columns)
    columns = {}
    for head in heads:
        known = [_values(each.columns[head]) if head in each.columns else None for each in frames]
        text = any(own and isinstance(own[0], str) for own in known)
        lacking = ["" if text else None]
        pairs = zip(known, frames, strict=True)
        parts = [lacking * len(each) if own is None else own for own, each in pairs]
        columns[head] = [value for part in parts for value in part]
    units = {head: unit for each in frames for head, unit in each.units.items()}
    return Frame(columns, units)


def _values(column: Sequence[Any] | NDArray[Any]) -> list[Any]:
    return column.tolist() if isinstance(column, np.ndarray) else list(column)
