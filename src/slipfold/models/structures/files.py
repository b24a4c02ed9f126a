"""A structure as the tables of a file: read, and written."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field, ValidationInfo

from slipfold.models.definitions.source import Source
from slipfold.models.definitions.system_file import Line, Named, ParameterTable, Table, write_tables
from slipfold.models.definitions.tables import (
    WrongEntry,
    check_keys,
    part_table,
    read_part,
    type_name,
    validate,
)
from slipfold.models.formulas.grammar import BOUNDS
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.record import law_record, read_law
from slipfold.models.quantities import Parameter
from slipfold.models.structures.component import Direction
from slipfold.models.structures.contacts import (
    ComplianceLoad,
    ConstantLoad,
    ContactLoad,
    ModulatedLoad,
    NormalLoad,
)
from slipfold.models.structures.cyclic import CyclicSymmetry
from slipfold.models.structures.damping import Damping, ModalDamping, ProportionalDamping
from slipfold.models.structures.definition import COMPONENTS, Definition
from slipfold.models.structures.matrices import Matrix
from slipfold.models.structures.matrix_files import read_matrix
from slipfold.models.structures.reduction import CraigBampton, FreeInterface, ModalReduction

FORM = (
    "give rows such as [[2, -1], [-1, 1]], { diagonal = [1, 1] }, or the name of a file such as "
    "K.mtx in the same folder"
)


ROWS = 20
"""Largest size of a matrix that is written as rows, which then fit on a line."""


def _matrix(given: Any, info: ValidationInfo) -> Any:
    """Return the rows of a matrix; validation has the folder of the file as its context."""
    if isinstance(given, str):
        return _beside(given, info.context)
    if isinstance(given, Mapping) and "entries" in given:
        return _from_entries(given)
    if isinstance(given, Mapping) and given and all(map(_is_matrix, given.values())):
        # Matrices by the formulas that multiply them
        return {key: _below(key, matrix, info) for key, matrix in given.items()}
    if isinstance(given, Mapping):
        check_keys(given, ["diagonal"], {"diagonal": "diagonal = [1, 1]"})
        return np.diag(_row(given["diagonal"], "diagonal"))
    if not isinstance(given, list | tuple):
        raise WrongEntry(f"is {type_name(given)}, not a matrix; {FORM}")
    rows = [_row(row, str(number)) for number, row in enumerate(given)]
    for number, row in enumerate(rows):
        if len(row) != len(rows[0]):
            raise WrongEntry(
                f"has {len(row)} numbers in row {number + 1} and {len(rows[0])} in row 1; give "
                "rows of one length",
                str(number),
            )
    return rows


def _is_matrix(given: Any) -> bool:
    rows = isinstance(given, list | tuple) and any(isinstance(row, list | tuple) for row in given)
    return rows or isinstance(given, str | Mapping)


def _below(key: str, given: Any, info: ValidationInfo) -> Any:
    try:
        return _matrix(given, info)
    except WrongEntry as wrong:
        raise wrong.below([key]) from None


def _row(given: Any, key: str) -> list[float]:
    """Return the numbers of an array that stands under a key."""
    if not isinstance(given, list | tuple):
        raise WrongEntry(f"is {type_name(given)}; {FORM}", path=[key])
    for position, number in enumerate(given):
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise WrongEntry(f"is {type_name(number)}; give a number", path=[key, str(position)])
    try:
        return [float(number) for number in given]
    except OverflowError:
        raise WrongEntry("has a number beyond floats; give finite numbers", path=[key]) from None


def _beside(given: str, folder: Path | None) -> Path:
    """Return the path of a file in the folder of this one."""
    if folder is None:
        raise WrongEntry("is the name of a file, but this text is in none; write the matrix")
    absolute = PurePosixPath(given).is_absolute() or PureWindowsPath(given).anchor
    if absolute or ".." in PureWindowsPath(given).parts or not given.isprintable():
        raise WrongEntry(
            f"= {given[:80]!r} leads out of the folder of this file; put the file there and give "
            "its name"
        )
    return folder / given


def _names(given: Any, info: ValidationInfo) -> Any:
    """Return names, or the path of a table that has them."""
    is_file = isinstance(given, str) and given.endswith(".csv")
    return _beside(given, info.context) if is_file else given


def _from_entries(given: Mapping[str, Any]) -> Any:
    keys = ("size", "rows", "columns", "entries")
    check_keys(given, keys, dict.fromkeys(keys, ""))
    size = given["size"]
    if not isinstance(size, int) or isinstance(size, bool) or not 0 < size <= BOUNDS.rows:
        raise WrongEntry("is not the number of rows of a matrix", path=["size"])
    rows, columns, entries = (np.array(_row(given[key], key)) for key in keys[1:])
    if not len(rows) == len(columns) == len(entries):
        raise WrongEntry("has rows, columns and entries of different lengths; give one each")
    locations = np.concatenate([rows, columns])
    if len(locations) and not (
        np.all(locations == np.floor(locations)) and locations.min() >= 0 and locations.max() < size
    ):
        raise WrongEntry(f"has entries outside its {size} rows; give rows and columns from 0")
    from scipy.sparse import coo_array

    indices = (rows.astype(np.int64), columns.astype(np.int64))
    return coo_array((entries, indices), (size, size))


def _samples(given: Any, folder: Path | None) -> Any:
    """Return the samples of a tabulated force."""
    if not isinstance(given, str):
        return given
    values = np.asarray(read_matrix(_beside(given, folder), "samples"))
    if values.dtype.kind not in "fiu" or values.size != max(values.shape, default=0):
        raise WrongEntry(f"= {given!r} holds no row of numbers; save one period of the force")
    return values.ravel().tolist()


def _rows(given: Any, folder: Path | None) -> Any:
    """Return the rows of a tabulated spring."""
    if not isinstance(given, str):
        return given
    values = np.asarray(read_matrix(_beside(given, folder), "table"))
    if values.dtype.kind not in "fiu" or values.ndim != 2:
        raise WrongEntry(f"= {given!r} holds no rows of displacement and force; save those")
    return values.tolist()


def _load(given: Any) -> Any:
    """Return a normal force; a number, or text with a unit, is a constant one."""
    loads = (ConstantLoad, ModulatedLoad, ContactLoad, ComplianceLoad)
    kinds = {kind.__name__: kind for kind in loads}
    return read_part(given, kinds, "type", {}) if isinstance(given, Mapping) else given


def _one_of(*classes: type) -> BeforeValidator:
    """Return what reads a part of one of some classes."""
    kinds = {kind.__name__: kind for kind in classes}

    def read(given: Any, info: ValidationInfo) -> Any:
        samples = partial(_samples, folder=info.context)
        readers: dict[str, Callable[[Any], Any]] = {
            "friction": read_law,
            "load": _load,
            "samples": samples,
            "table": partial(_rows, folder=info.context),
        }
        return read_part(given, kinds, "type", readers)

    return BeforeValidator(read)


ELEMENTS, CONTACTS, FORCING = (_one_of(*classes) for classes in COMPONENTS.values())
MatrixEntry = Annotated[Any, BeforeValidator(_matrix)]


class MatricesTable(Table):
    """Matrices and names of the degrees of freedom; what they mean is checked in `define`."""

    M: MatrixEntry
    C: MatrixEntry = None
    K: MatrixEntry
    G: MatrixEntry = None
    H: MatrixEntry = None
    triangles: Any = None
    units: Any = None
    names: Annotated[Any, BeforeValidator(_names)] = None
    length_scale: Any = 1.0


class StructureFile(Table):
    """What a file with a structure may hold."""

    name: Line = ""
    title: Line = ""
    structure: MatricesTable = Field(examples=["a table [structure] with its matrices M and K"])
    damping: Annotated[Any, _one_of(ProportionalDamping, ModalDamping)] = None
    reduction: Annotated[Any, _one_of(FreeInterface, ModalReduction, CraigBampton)] = None
    cyclic: Annotated[Any, _one_of(CyclicSymmetry)] = None
    elements: list[Annotated[Any, ELEMENTS]] = Field([], max_length=BOUNDS.entries)
    contacts: list[Annotated[Any, CONTACTS]] = Field([], max_length=BOUNDS.entries)
    forcing: list[Annotated[Any, FORCING]] = Field([], max_length=BOUNDS.entries)
    watch: dict[str, Any] | None = None
    variables: Named[ParameterTable] = Field(default_factory=dict)
    parameters: dict[str, Any] = Field(default_factory=dict)


def read_structure(
    source: Source, folder: Path | None, default_name: str = "structure"
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Read the arguments of a structure, and the values of its parameters."""
    check = partial(StructureFile.model_validate, context=folder)
    given: StructureFile = source.read(partial(validate, check), source.tables, root="a structure")
    if given.damping is not None and given.structure.C is not None:
        raise source.error(
            ("damping",), "there are both a matrix C and a table [damping]; give the one meant"
        )
    arguments = {name: getattr(given.structure, name) for name in MatricesTable.model_fields}
    parts = ("title", "reduction", "cyclic", "elements", "contacts", "forcing", "watch")
    arguments |= {name: getattr(given, name) for name in parts}
    arguments["variables"] = [item.parameter(name) for name, item in given.variables.items()]
    if given.damping is not None:
        arguments["C"] = given.damping
    arguments["name"] = given.name or default_name
    for name in (name for name in given.parameters if name in arguments):
        raise source.error(("parameters", name), f"no parameter of a structure is called {name}")
    return arguments, given.parameters


def matrix_table(matrix: Matrix) -> dict[str, Any]:
    """Return a matrix as plain data; rows and columns count from 0."""
    if matrix.terms:
        terms = {text: matrix_table(part) for text, part in matrix.terms}
        return {"1": matrix_table(replace(matrix, terms=())), **terms}
    return {
        "size": matrix.size,
        "rows": matrix.rows.tolist(),
        "columns": matrix.columns.tolist(),
        "entries": matrix.entries.tolist(),
    }


def structure_tables(definition: Definition) -> dict[str, Any]:
    """Return a structure as tables that `read_structure` reads: numbers, texts, lists, mappings."""
    damping = definition.C
    tables = {
        "name": definition.name,
        "title": definition.title,
        "structure": {
            "M": matrix_table(definition.M),
            "K": matrix_table(definition.K),
            **{
                key: matrix_table(getattr(definition, key))
                for key in ("C", "G", "H")
                if isinstance(getattr(definition, key), Matrix)
            },
            **({"triangles": "whole"} if _takes_whole(definition) else {}),
            "names": list(definition.names),
            "length_scale": definition.length_scale,
        },
        "damping": _part(damping) if isinstance(damping, Damping) else None,
        "reduction": None if definition.reduction is None else _part(definition.reduction),
        "cyclic": None if definition.cyclic is None else _part(definition.cyclic),
        "elements": [_part(item) for item in definition.elements],
        "contacts": [_part(item) for item in definition.contacts],
        "forcing": [_part(item) for item in definition.forcing],
        "variables": {item.name: _parameter_table(item) for item in definition.variables},
        "watch": {name: _plain(direction) for name, direction in definition.watch},
    }
    return {name: table for name, table in tables.items() if table}


def structure_text(definition: Definition, values: Mapping[str, float]) -> str:
    """Return the text of a file with a structure; small matrices as rows."""
    tables = structure_tables(definition)
    matrices = tables["structure"]
    for key in ("M", "K", "C", "G", "H"):
        given = getattr(definition, key)
        if isinstance(given, Matrix) and not given.terms and given.size <= ROWS:
            matrices[key] = given.dense().tolist()
    return write_tables({**tables, "parameters": dict(values)})


def _parameter_table(item: Parameter) -> dict[str, Any]:
    """Return the table of a parameter, without what says nothing."""
    table: dict[str, Any] = {"value": item.default}
    table |= {key: getattr(item, key) for key in ("unit", "doc", "symbol") if getattr(item, key)}
    if math.isfinite(item.lower):
        table["above" if item.lower_open else "min"] = item.lower
    if math.isfinite(item.upper):
        table["below" if item.upper_open else "max"] = item.upper
    return table


def _takes_whole(definition: Definition) -> bool:
    """Whether a matrix would be refused, or read as half of a symmetric one."""
    stiffness, damping = definition.K, definition.C
    parts = (*stiffness.parts, *(damping.parts if isinstance(damping, Matrix) else ()))
    return not stiffness.symmetric or any(part.one_sided for part in parts)


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
            return {str(key): rest[0] if len(rest) == 1 else rest for key, *rest in value}
        return [_plain(item) for item in value]
    return value
