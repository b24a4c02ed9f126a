"""Labelled arrays as plain data: the one form behind xarray datasets and netCDF files."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError

if TYPE_CHECKING:
    import xarray

LARGE = 2**18
"""Bytes of an array above which it is packed: maps of regions shrink to a hundredth."""

PIECE = 2**14
"""Rows of texts that are written at once."""


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
        """Return itself by name; of complex numbers both parts."""
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
class LabelledTable:
    """Variables that share dimensions, with attributes.

    It goes to a netCDF file without xarray, which takes longer to import than a diagram to compute.
    """

    variables: Mapping[str, Variable]
    attributes: Mapping[str, Any]
    """Of the whole; text, numbers or arrays of numbers."""
    groups: Mapping[str, LabelledTable] = field(default_factory=dict)
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
        memory = io.BytesIO()
        self.write_netcdf(memory)
        return memory.getvalue()

    def write_netcdf(self, target: IO[bytes]) -> None:
        """Write it as a netCDF-4 file, one variable after the other."""
        import h5netcdf
        import h5py

        with h5py.File(target, "w", track_order=True) as store:
            file = h5netcdf.File(store, "w")
            self._write(file)
            file.close()

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
        # In pieces, as HDF5 makes a copy of each text.
        for begin in range(0, len(values) if values.ndim else 1, PIECE):
            piece = slice(begin, begin + PIECE) if values.ndim else ()
            written[piece] = np.asarray(values[piece], object)
    elif values.dtype.kind == "b":
        # netCDF has no truth values; this is how xarray marks them.
        written = file.create_variable(name, item.dimensions, data=values.astype(np.int8))
        attributes["dtype"] = "bool"
    else:
        packed = {"compression": "gzip"} if values.nbytes > LARGE else {}
        written = file.create_variable(name, item.dimensions, data=values, **packed)
    written.attrs.update(attributes)


def read_netcdf(path: str | Path) -> LabelledTable:
    """Read a netCDF-4 file."""
    try:
        content = Path(path).read_bytes()
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


def _read_table(file: Any, store: Any) -> LabelledTable:
    """Read a file, or a group in it."""
    attributes = {key: _plain(value) for key, value in file.attrs.items()}
    labels = str(attributes.pop("coordinates", "")).split()
    # h5netcdf looks an array up in the file a dozen times before it reads it.
    variables = {
        name: _read_variable(item, store[name][...], name in labels)
        for name, item in file.variables.items()
    }
    groups = {name: _read_table(group, store[name]) for name, group in file.groups.items()}
    return LabelledTable(variables, attributes, groups)


def _read_variable(item: Any, values: NDArray[Any], label: bool) -> Variable:
    attributes = {key: _plain(value) for key, value in item.attrs.items()}
    if values.dtype.kind in "OT":
        texts = [part.decode() if isinstance(part, bytes) else str(part) for part in values.flat]
        values = np.array(texts, dtype=str).reshape(values.shape)
    elif attributes.pop("dtype", "") == "bool":
        values = values.astype(bool)
    return Variable(tuple(item.dimensions), values, attributes, label)


def _plain(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.decode()
    return value
