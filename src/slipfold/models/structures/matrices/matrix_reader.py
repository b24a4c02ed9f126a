"""Matrices and samples of a structure in its file: written there, or in files beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as FilePath
from pathlib import PurePosixPath, PureWindowsPath
from typing import Any

import numpy as np

from slipfold.errors import InputError
from slipfold.models.definitions.source import Source
from slipfold.models.definitions.toml_entries import Entries, type_name
from slipfold.models.definitions.toml_parts import plain
from slipfold.models.definitions.toml_places import Path
from slipfold.models.structures.matrices.matrices import Matrix, as_matrix
from slipfold.models.structures.matrices.matrix_files import read_matrix

FORM = (
    "give rows such as [[2, -1], [-1, 1]], { diagonal = [1, 1] }, or the name of a .npz, .npy, "
    ".mat or Matrix Market file beside this one"
)

LARGEST = 1_000_000
"""Rows of the largest matrix: more do not fit into memory with their modes."""


def read_matrix_entry(
    source: Source, path: Path, value: Any, folder: FilePath | None, triangles: str | None = None
) -> Matrix:
    """Read a matrix."""
    name = path[-1]
    if isinstance(value, str):
        rows = _from_file(source, path, value, folder)
    elif isinstance(value, Mapping) and "entries" in value:
        rows = _from_entries(source, path, value)
    elif isinstance(value, Mapping):
        entries = Entries(source, path, value, ("diagonal",), name)
        if "diagonal" not in entries:
            raise source.error(path, f"{name} is an empty table; {FORM}")
        rows = np.diag(_row(source, (*path, "diagonal"), value["diagonal"]))
    elif isinstance(value, list | tuple):
        rows = [_row(source, (*path, str(n)), row) for n, row in enumerate(value)]
        for n, row in enumerate(rows):
            if len(row) != len(rows[0]):
                raise source.error(
                    (*path, str(n)),
                    f"row {n + 1} of {name} has {len(row)} numbers and row 1 has {len(rows[0])}; "
                    "give rows of one length",
                )
    else:
        raise source.error(path, f"{name} is {type_name(value)}, no matrix; {FORM}")
    try:
        return as_matrix(rows, name, triangles)
    except InputError as error:
        raise source.error(path, str(error)) from None


def read_samples_entry(
    source: Source, path: Path, value: Any, folder: FilePath | None
) -> list[float]:
    """Read the samples of a tabulated force."""
    if not isinstance(value, str):
        return _row(source, path, value)
    found = np.asarray(_from_file(source, path, value, folder))
    if found.dtype.kind not in "fiu" or found.size != max(found.shape, default=0):
        raise source.error(path, f"{value} holds no row of numbers; save one period of the force")
    return [float(number) for number in found.ravel()]


def matrix_table(matrix: Matrix) -> dict[str, Any]:
    """Return a matrix as plain data: its size, and rows and columns from 0 with the entries there.

    >>> matrix_table(as_matrix([[2, 0], [0, 1]], "K"))
    {'size': 2, 'rows': [0, 1], 'columns': [0, 1], 'entries': [2.0, 1.0]}
    """
    return {
        "size": matrix.size,
        "rows": matrix.rows.tolist(),
        "columns": matrix.columns.tolist(),
        "entries": matrix.entries.tolist(),
    }


def _row(source: Source, path: Path, value: Any) -> list[float]:
    if not isinstance(value, list | tuple):
        raise source.error(path, f"this part of {_named(path)} is {type_name(value)}; {FORM}")
    numbers = plain(source, path, value)
    for n, number in enumerate(numbers):
        if not isinstance(number, int | float):
            raise source.error(
                (*path, str(n)), f"an entry of {_named(path)} is {type_name(number)}; give a number"
            )
    return [float(number) for number in numbers]


def _named(path: Path) -> str:
    return next(key for key in reversed(path) if not key.isdigit() and key != "diagonal")


def _from_file(source: Source, path: Path, given: str, folder: FilePath | None) -> Any:
    if folder is None:
        raise source.error(
            path, f"{path[-1]} is the name of a file, but this text is in none; write the matrix"
        )
    absolute = PurePosixPath(given).is_absolute() or PureWindowsPath(given).anchor
    if absolute or ".." in PureWindowsPath(given).parts or not given.isprintable():
        raise source.error(
            path,
            f"{path[-1]} = {given[:80]!r} leads out of the folder of this file; put the matrix "
            "there and give its name",
        )
    try:
        return read_matrix(folder / given, path[-1])
    except InputError as error:
        raise source.error(path, str(error)) from None


def _from_entries(source: Source, path: Path, value: Mapping[str, Any]) -> Any:
    Entries(source, path, value, ("size", "rows", "columns", "entries"), path[-1])
    size = value.get("size")
    if not isinstance(size, int) or isinstance(size, bool) or not 0 < size <= LARGEST:
        raise source.error(path, f"{path[-1]} has no size; give the number of its rows")
    parts = [_row(source, (*path, key), value.get(key)) for key in ("rows", "columns", "entries")]
    rows, columns, entries = (np.array(part) for part in parts)
    if not len(rows) == len(columns) == len(entries):
        raise source.error(
            path, f"{path[-1]} has as many rows as columns and entries, or it is no matrix"
        )
    places = np.concatenate([rows, columns])
    if len(places) and not (
        np.all(places == np.floor(places)) and places.min() >= 0 and places.max() < size
    ):
        raise source.error(
            path, f"{path[-1]} has entries outside its {size} rows; give rows and columns from 0"
        )
    from scipy.sparse import coo_array

    shape = (size, size)
    return coo_array((entries, (rows.astype(np.int64), columns.astype(np.int64))), shape)
