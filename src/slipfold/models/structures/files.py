"""A structure as the tables of a file: read, and written."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path as FilePath
from pathlib import PurePosixPath, PureWindowsPath
from typing import Any, TypeVar

import numpy as np

from slipfold.errors import InputError
from slipfold.models.definitions.source import MOST_ENTRIES, Keys, Source
from slipfold.models.definitions.tables import (
    Entries,
    Reader,
    part_table,
    plain,
    read_part,
)
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.record import law_record, read_law
from slipfold.models.model import Model
from slipfold.models.structures.component import Component, Direction
from slipfold.models.structures.contacts import ConstantLoad, ContactLoad, ModulatedLoad, NormalLoad
from slipfold.models.structures.damping import Damping, ModalDamping, ProportionalDamping
from slipfold.models.structures.definition import (
    CONTACTS,
    ELEMENTS,
    FORCING,
    Definition,
    checked_length,
    checked_names,
    checked_sizes,
    checked_triangles,
    checked_watch,
)
from slipfold.models.structures.matrices import Matrix, as_matrix, check_mass, read_matrix
from slipfold.models.structures.reduction import CraigBampton, ModalReduction, Reduction
from slipfold.text.validated import type_name

FORM = (
    "give rows such as [[2, -1], [-1, 1]], { diagonal = [1, 1] }, or the name of a .npz, .npy, "
    ".mat or Matrix Market file in the same folder"
)

LARGEST = 1_000_000
"""Rows of the largest matrix: more do not fit into memory with their modes."""


def read_matrix_entry(
    source: Source, path: Keys, value: Any, folder: FilePath | None, triangles: str | None = None
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
    source: Source, path: Keys, value: Any, folder: FilePath | None
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


def _row(source: Source, path: Keys, value: Any) -> list[float]:
    if not isinstance(value, list | tuple):
        raise source.error(path, f"this part of {_named(path)} is {type_name(value)}; {FORM}")
    numbers = plain(source, path, value)
    for n, number in enumerate(numbers):
        if not isinstance(number, int | float):
            raise source.error(
                (*path, str(n)), f"an entry of {_named(path)} is {type_name(number)}; give a number"
            )
    return [float(number) for number in numbers]


def _named(path: Keys) -> str:
    return next(key for key in reversed(path) if not key.isdigit() and key != "diagonal")


def _from_file(source: Source, path: Keys, given: str, folder: FilePath | None) -> Any:
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


def _from_entries(source: Source, path: Keys, value: Mapping[str, Any]) -> Any:
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


T = TypeVar("T")

TABLES = (
    *("structure", "damping", "reduction", "elements", "contacts", "forcing", "watch"),
    "parameters",
)


_DAMPING: dict[str, type] = {item.__name__: item for item in (ProportionalDamping, ModalDamping)}
_REDUCTIONS: dict[str, type] = {item.__name__: item for item in (ModalReduction, CraigBampton)}
_LOADS: dict[str, type] = {
    item.__name__: item for item in (ConstantLoad, ModulatedLoad, ContactLoad)
}
_COMPONENTS = {"elements": ELEMENTS, "contacts": CONTACTS, "forcing": FORCING}


def read_structure(
    source: Source, folder: FilePath | None, default_name: str = "structure"
) -> dict[str, Any]:
    """Read the arguments of a structure, each checked where it is written."""
    top = Entries(source, (), source.tables, ("name", "title", *TABLES), "a structure")
    if "structure" not in top:
        raise source.error((), "there is no table [structure]; give its matrices M and K there")
    path = ("structure",)
    table = source.tables["structure"]
    entries = Entries(source, path, table, ("M", "C", "K", "triangles", "names", "length_scale"))
    triangles = entries.text("triangles", None)
    _placed(source, (*path, "triangles"), checked_triangles, triangles)
    matrices = {
        key: read_matrix_entry(source, (*path, key), table[key], folder, triangles)
        for key in ("M", "K", "C") if key in entries
    }  # fmt: skip
    for key in ("M", "K"):
        if key not in matrices:
            raise source.error(path, f"the structure has no matrix {key}; give it in [structure]")
    mass, stiffness = matrices["M"], matrices["K"]
    for key in ("C", "K"):
        if key in matrices:
            _placed(source, (*path, key), checked_sizes, mass, **{key: matrices[key]})
    names = _placed(source, (*path, "names"), checked_names, _names(source, table), mass.size)
    _placed(source, (*path, "M"), check_mass, mass, names)
    scale = entries.number("length_scale", 1.0, "m")
    return {
        "name": top.text("name", None) or default_name,
        "title": top.text("title"),
        "M": mass,
        "K": stiffness,
        "C": _damping(source, matrices.get("C")),
        "names": names,
        "length_scale": _placed(source, (*path, "length_scale"), checked_length, scale),
        "reduction": _reduction(source, mass, stiffness, names),
        **{what: _components(source, what, names, folder) for what in _COMPONENTS},
        "watch": _watch(source, names),
    }


def _placed(source: Source, path: Keys, check: Callable[..., T], *given: Any, **named: Any) -> T:
    """Return what a check returns, and give its message the place."""
    try:
        return check(*given, **named)
    except InputError as error:
        raise source.error(path, str(error)) from None


def _blamed(message: str, path: Keys) -> Keys:
    """Where a message about a part of the structure points: at the matrix or entry it names."""
    words = message.removeprefix("the ").split(" ")
    if words[0] in ("M", "C", "K"):
        return ("structure", words[0])
    return (*path, "boundary") if words[0] == "boundary" else path


def _names(source: Source, table: Mapping[str, Any]) -> Any:
    given = table.get("names")
    if given is None or isinstance(given, str):
        return given
    if not isinstance(given, list | tuple):
        raise source.error(
            ("structure", "names"),
            f'names is {type_name(given)}; give a text such as "root tip" or an array of texts',
        )
    return plain(source, ("structure", "names"), given)


def _damping(source: Source, matrix: Matrix | None) -> Matrix | Damping | None:
    if "damping" not in source.tables:
        return matrix
    if matrix is not None:
        raise source.error(
            ("damping",), "there are both a matrix C and a table [damping]; give the one meant"
        )
    damping: Damping = read_part(source, ("damping",), source.tables["damping"], _DAMPING, "type")
    return damping


def _reduction(
    source: Source, mass: Matrix, stiffness: Matrix, names: tuple[str, ...]
) -> Reduction | None:
    path = ("reduction",)
    if path[0] not in source.tables:
        return None
    reduction: Reduction = read_part(source, path, source.tables[path[0]], _REDUCTIONS, "type")
    try:
        reduction.fits(mass, stiffness, names)
    except InputError as error:
        raise source.error(_blamed(str(error), path), str(error)) from None
    return reduction


def _components(
    source: Source, what: str, names: tuple[str, ...], folder: FilePath | None
) -> tuple[Component, ...]:
    tables = source.tables.get(what, ())
    if not isinstance(tables, list | tuple):
        raise source.error(
            (what,), f"{what} is {type_name(tables)}; give each one a table, headed [[{what}]]"
        )
    if len(tables) > MOST_ENTRIES:
        raise source.error((what,), f"there are {len(tables)} {what}, more than {MOST_ENTRIES}")
    kinds = {cls.__name__: cls for cls in _COMPONENTS[what]}
    return tuple(
        _component(source, (what, str(place)), table, kinds, names, folder)
        for place, table in enumerate(tables)
    )


def _component(
    source: Source,
    path: Keys,
    table: Any,
    kinds: Mapping[str, type],
    names: tuple[str, ...],
    folder: FilePath | None,
) -> Component:
    samples = partial(read_samples_entry, folder=folder)
    readers: dict[str, Reader] = {"friction": read_law, "load": _load, "samples": samples}
    component: Component = read_part(source, path, table, kinds, "type", readers)
    _check_directions(source, path, component, names)
    return component


def _load(source: Source, path: Keys, value: Any) -> Any:
    if isinstance(value, Mapping):
        return read_part(source, path, value, _LOADS, "type")
    # A number, or text with a unit, is a constant force.
    return plain(source, path, value)


def _check_directions(source: Source, path: Keys, part: Any, names: tuple[str, ...]) -> None:
    """Refuse directions along degrees of freedom that the structure does not have."""
    for item in dataclasses.fields(part):
        value = getattr(part, item.name)
        for direction in value if isinstance(value, tuple) else (value,):
            if isinstance(direction, Direction):
                _placed(source, (*path, item.name), direction.vector, names)
            elif isinstance(direction, NormalLoad):
                _check_directions(source, (*path, item.name), direction, names)


def _watch(source: Source, names: tuple[str, ...]) -> Any:
    if "watch" not in source.tables:
        return None
    path = ("watch",)
    table = source.tables["watch"]
    if not isinstance(table, Mapping):
        raise source.error(
            path, f'watch is {type_name(table)}; give a table with e.g. u_tip = "tip"'
        )
    watched = []
    for key, value in table.items():
        given = {key: plain(source, (*path, key), value)}
        ((name, direction),) = _placed(source, (*path, key), checked_watch, given)
        _placed(source, (*path, key), direction.vector, names)
        watched.append((name, direction))
    return tuple(watched)


def read_values(source: Source, model: Model) -> dict[str, float]:
    """Read the values of parameters."""
    path = ("parameters",)
    known = [item.name for item in model.parameters]
    entries = Entries(source, path, source.tables.get(path[0], {}), known, model.name)
    values = {}
    for item in model.parameters:
        if item.name in entries:
            number = entries.number(item.name, item.default, item.unit)
            values[item.name] = _placed(source, (*path, item.name), item.check, number)
    _placed(source, path, model.check, {**model.values, **values})
    return values


def structure_tables(definition: Definition) -> dict[str, Any]:
    """Return a structure as tables that `read_structure` reads: numbers, texts, lists, mappings."""
    damping = definition.C
    tables = {
        "name": definition.name,
        "title": definition.title,
        "structure": {
            "M": matrix_table(definition.M),
            "K": matrix_table(definition.K),
            **({"C": matrix_table(damping)} if isinstance(damping, Matrix) else {}),
            **({"triangles": "whole"} if _has_whole_triangle(definition) else {}),
            "names": list(definition.names),
            "length_scale": definition.length_scale,
        },
        "damping": _part(damping) if isinstance(damping, Damping) else None,
        "reduction": None if definition.reduction is None else _part(definition.reduction),
        "elements": [_part(item) for item in definition.elements],
        "contacts": [_part(item) for item in definition.contacts],
        "forcing": [_part(item) for item in definition.forcing],
        "watch": {name: _plain(direction) for name, direction in definition.watch},
    }
    return {name: table for name, table in tables.items() if table}


def _has_whole_triangle(definition: Definition) -> bool:
    """Whether a matrix would be read as half of a symmetric one."""
    matrices = (definition.C, definition.K)
    return any(isinstance(item, Matrix) and item.one_sided for item in matrices)


def _part(part: Any) -> dict[str, Any]:
    return part_table(part, "type", _plain)


def _plain(value: Any) -> Any:
    if isinstance(value, Direction):
        name, weight = value.weights[0]
        return name if len(value.weights) == 1 and weight == 1 else dict(value.weights)
    if isinstance(value, FrictionLaw):
        return law_record(value)
    if isinstance(value, NormalLoad):
        return _part(value)
    if isinstance(value, tuple):
        if value and all(isinstance(item, tuple) for item in value):
            # Coefficients by power or harmonic: a file has them as a table.
            return {str(key): _sole(rest) for key, *rest in value}
        return [_plain(item) for item in value]
    return value


def _sole(values: list[Any]) -> Any:
    return values[0] if len(values) == 1 else values
