"""The tables of a file read as the arguments of a structure."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path as FilePath
from typing import Any, TypeVar

from slipfold.errors import InputError
from slipfold.models.definitions.source import Source
from slipfold.models.definitions.toml_entries import Entries, type_name
from slipfold.models.definitions.toml_parts import Reader, plain, read_part
from slipfold.models.definitions.toml_places import Path
from slipfold.models.friction.law_reader import read_law
from slipfold.models.model import Model
from slipfold.models.structures.components.component import Component
from slipfold.models.structures.components.direction import Direction
from slipfold.models.structures.components.normal_loads import (
    ConstantLoad,
    ContactLoad,
    ModulatedLoad,
    NormalLoad,
)
from slipfold.models.structures.definition import (
    CONTACTS,
    ELEMENTS,
    FORCING,
    checked_length,
    checked_names,
    checked_sizes,
    checked_triangles,
    checked_watch,
)
from slipfold.models.structures.matrices.damping import Damping, ModalDamping, ProportionalDamping
from slipfold.models.structures.matrices.matrices import Matrix, check_mass
from slipfold.models.structures.matrices.matrix_reader import read_matrix_entry, read_samples_entry
from slipfold.models.structures.matrices.reduction import CraigBampton, ModalReduction, Reduction

T = TypeVar("T")

TABLES = (
    *("structure", "damping", "reduction", "elements", "contacts", "forcing", "watch"),
    "parameters",
)

MOST = 1000
"""Elements, contacts or forces of a structure: their formulas are compiled one by one."""

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


def _placed(source: Source, path: Path, check: Callable[..., T], *given: Any, **named: Any) -> T:
    """Return what a check returns, and give its message the place."""
    try:
        return check(*given, **named)
    except InputError as error:
        raise source.error(path, str(error)) from None


def _blamed(message: str, path: Path) -> Path:
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
    if len(tables) > MOST:
        raise source.error((what,), f"there are {len(tables)} {what}, more than {MOST}")
    kinds = {cls.__name__: cls for cls in _COMPONENTS[what]}
    return tuple(
        _component(source, (what, str(place)), table, kinds, names, folder)
        for place, table in enumerate(tables)
    )


def _component(
    source: Source,
    path: Path,
    table: Any,
    kinds: Mapping[str, type],
    names: tuple[str, ...],
    folder: FilePath | None,
) -> Component:
    samples = partial(read_samples_entry, folder=folder)
    readers: dict[str, Reader] = {"friction": read_law, "load": _load, "samples": samples}
    component: Component = read_part(
        source, path, table, kinds, "type", readers, {"friction": "law"}
    )
    _check_directions(source, path, component, names)
    return component


def _load(source: Source, path: Path, value: Any) -> Any:
    if isinstance(value, Mapping):
        return read_part(source, path, value, _LOADS, "type")
    # A number, or text with a unit, is a constant force.
    return plain(source, path, value)


def _check_directions(source: Source, path: Path, part: Any, names: tuple[str, ...]) -> None:
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
