"""Labeled arrays, as netCDF files, xarray datasets, spreadsheets and data frames."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.writing import to_read

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped]
    import xarray

LARGE = 2**18
"""Bytes of an array above which it is packed: maps of regions shrink to a hundredth."""


@dataclass(frozen=True, eq=False)
class Variable:
    """An array with named dimensions: numbers, truth values or text."""

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, str] = field(default_factory=dict)
    """``long_name``, ``units`` and what else there is to say."""
    label: bool = False
    """Whether it labels rather than holds results."""
    head: str | None = ""
    """Heading in tables; None: not there."""

    def parts(self, name: str) -> dict[str, Variable]:
        """Return the variable by name; of complex numbers both parts."""
        if self.values.dtype.kind != "c":
            return {name: self}
        about = self.attributes["long_name"]
        return {
            f"{name}_{end}": replace(
                self,
                values=np.ascontiguousarray(values),
                attributes={**self.attributes, "long_name": f"{about}, {word} part"},
            )
            for end, word, values in (
                ("real", "real", self.values.real),
                ("imag", "imaginary", self.values.imag),
            )
        }


@dataclass(frozen=True, eq=False)
class LabeledTable:
    """Variables that share dimensions, with attributes.

    It goes to a netCDF file without xarray, which takes longer to import than a diagram to compute.
    """

    variables: Mapping[str, Variable]
    attributes: Mapping[str, Any]
    """Of the whole; text, numbers or arrays of numbers."""
    groups: Mapping[str, LabeledTable] = field(default_factory=dict)
    """Tables of their own in the same file."""

    def to_xarray(self) -> xarray.Dataset:
        """Return it as a dataset."""
        import xarray

        whole = dict(self.real())
        entries = {
            name: xarray.Variable(item.dimensions, item.values, dict(item.attributes))
            for name, item in whole.items()
        }
        marked = [name for name, item in whole.items() if item.label]
        labels = {name: entries.pop(name) for name in marked}
        return xarray.Dataset(entries, labels, dict(self.attributes))

    def real(self) -> Iterator[tuple[str, Variable]]:
        """Go through the variables, complex ones as two."""
        for name, item in self.variables.items():
            yield from item.parts(name).items()

    def to_netcdf(self) -> bytes:
        """Return it as the content of a netCDF-4 file."""
        import h5netcdf
        import h5py

        memory = io.BytesIO()
        with h5py.File(memory, "w", track_order=True) as store:
            file = h5netcdf.File(store, "w")
            self._write(file)
            file.close()
        return memory.getvalue()

    def _write(self, file: Any) -> None:
        """Write to a file or to a group in it."""
        labels = []
        for name, item in self.real():
            for dimension, size in zip(item.dimensions, item.values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.dimensions[dimension] = size
            _write_variable(file, name, item)
            labels += [name] * item.label
        plain = [name for name in labels if name not in file.dimensions]
        file.attrs["coordinates"] = " ".join(plain)
        for key, value in self.attributes.items():
            file.attrs[key] = value
        for name, table in self.groups.items():
            table._write(file.create_group(name))


def _write_variable(file: Any, name: str, item: Variable) -> None:
    import h5py

    values = item.values
    attributes = dict(item.attributes)
    if values.dtype.kind in "UO":
        written = file.create_variable(name, item.dimensions, dtype=h5py.string_dtype())
        written[...] = np.asarray(values, object)
    elif values.dtype.kind == "b":
        # netCDF has no truth values; this is how xarray marks them.
        written = file.create_variable(name, item.dimensions, data=values.astype(np.int8))
        attributes["dtype"] = "bool"
    else:
        packed = {"compression": "gzip"} if values.nbytes > LARGE else {}
        written = file.create_variable(name, item.dimensions, data=values, **packed)
    written.attrs.update(attributes)


def read_netcdf(path: str | Path) -> LabeledTable:
    """Read a netCDF-4 file."""
    try:
        content = to_read(path).read_bytes()
    except OSError as error:
        why = (error.strerror or str(error)).lower()
        raise InputError(
            f"{path} cannot be read ({why}); give a file that slipfold saved"
        ) from error
    try:
        import h5netcdf
        import h5py

        with h5py.File(io.BytesIO(content)) as store, h5netcdf.File(store) as file:
            return _read_table(file, store)
    # A damaged file makes HDF5 fail in many ways.
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError) as error:
        raise InputError(
            f"{path} is not a netCDF-4 file, or is damaged; give a file that slipfold saved"
        ) from error


def _read_table(file: Any, store: Any) -> LabeledTable:
    """Read a file, or a group in it."""
    attributes = {key: _plain(value) for key, value in file.attrs.items()}
    labels = str(attributes.pop("coordinates", "")).split()
    # h5netcdf looks an array up in the file a dozen times before it reads it.
    variables = {
        name: _read_variable(item, store[name][...], name in labels)
        for name, item in file.variables.items()
    }
    groups = {name: _read_table(group, store[name]) for name, group in file.groups.items()}
    return LabeledTable(variables, attributes, groups)


def _read_variable(item: Any, values: NDArray[Any], label: bool) -> Variable:
    attributes = {key: _plain(value) for key, value in item.attrs.items()}
    if values.dtype.kind in "OT":
        texts = [part.decode() if isinstance(part, bytes) else str(part) for part in values.flat]
        values = np.array(texts, dtype=str).reshape(values.shape)
    elif attributes.pop("dtype", "") == "bool":
        values = values.astype(bool)
    return Variable(tuple(item.dimensions), values, attributes, label)


def _plain(value: Any) -> Any:
    return value.decode() if isinstance(value, bytes) else value


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

        result = pandas.DataFrame(dict(self.columns))
        result.attrs["units"] = dict(self.units)
        return result


def _cells(column: Sequence[Any] | NDArray[Any]) -> list[Any]:
    return [
        "" if value is None or value != value else int(value) if value is True or value is False
        else value
        for value in _values(column)
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
    """Return the labels of positions along dimensions, and the unit in the labels."""
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
