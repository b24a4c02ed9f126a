"""A table of a file made into an object whose parameters are described: an element, a law."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Any

from slipfold.errors import InputError
from slipfold.models.definitions.source import Source
from slipfold.models.definitions.toml_entries import Entries, type_name
from slipfold.models.definitions.toml_places import Path
from slipfold.models.parameter import Parameter
from slipfold.models.suggestion import suggest

Reader = Callable[[Source, Path, Any], Any]
"""What makes an argument of an entry: of where it was written, the path to it and its value."""

DEEPEST = 8
"""Tables and arrays in each other that an entry may have."""


EXACT = 2**53
"""Largest whole number up to which a float holds all of them."""


def read_part(
    source: Source,
    path: Path,
    value: object,
    kinds: Mapping[str, type],
    key: str,
    readers: Mapping[str, Reader] | None = None,
    fields: Mapping[str, str] | None = None,
) -> Any:
    """Make an object of a table that says which class and with which arguments."""
    table = {key: value} if isinstance(value, str) else value
    if not isinstance(table, Mapping):
        raise source.error(
            path,
            f'{path[-1]} is {type_name(value)}; give a table with {key} = "{next(iter(kinds))}"',
        )
    cls = kinds[_kind_name(source, path, table, kinds, key)]
    called = {argument: entry for entry, argument in (fields or {}).items()}
    known = {called.get(item.name, item.name): item for item in dataclasses.fields(cls)}
    entries = Entries(source, path, table, (key, *known), cls.__name__)
    arguments = {}
    for entry, item in known.items():
        if entry in entries:
            reader = (readers or {}).get(entry, plain)
            parameter = item.metadata.get("parameter")
            if parameter is not None:
                arguments[item.name] = _number(entries, parameter)
            else:
                arguments[item.name] = reader(source, (*path, entry), table[entry])
        elif item.default is item.default_factory is dataclasses.MISSING:
            raise source.error(path, f"{cls.__name__} has no {entry}; give it")
    try:
        return cls(**arguments)
    except InputError as error:
        # A message about one argument begins with its name.
        words = str(error).removeprefix("the ").split(" ")
        where = (*path, words[0]) if words[0] in known else path
        raise source.error(where, str(error)) from None


def _kind_name(
    source: Source, path: Path, table: Mapping[str, Any], kinds: Mapping[str, type], key: str
) -> str:
    if key not in table and len(kinds) == 1:
        return next(iter(kinds))
    name = table.get(key)
    if name is None:
        raise source.error(path, f"{_last_name(path)} has no {key}; give one of {', '.join(kinds)}")
    if not isinstance(name, str) or name not in kinds:
        shown = name[:80] if isinstance(name, str) else type_name(name)
        near = suggest(shown, kinds) if isinstance(name, str) else ""
        raise source.error(
            (*path, key), f"there is no {key} {shown!r}; {near}there are {', '.join(kinds)}"
        )
    return name


def _last_name(path: Path) -> str:
    """What a message calls a table; one of several is called by their name and its number."""
    if len(path) > 1 and path[-1].isdigit():
        return f"number {int(path[-1]) + 1} of {path[-2]}"
    return f"the table {path[-1]}"


def _number(entries: Entries, parameter: Parameter) -> float:
    number = entries.number(parameter.name, parameter.default, parameter.unit)
    try:
        return parameter.check(number)
    except InputError as error:
        raise entries.error(parameter.name, str(error)) from None


def plain(source: Source, path: Path, value: Any) -> Any:
    """Return numbers, texts, arrays and tables; keys that are whole numbers become such."""
    if len(path) > DEEPEST:
        raise source.error(path, f"{path[0]} is nested too deeply; give numbers, texts or names")
    if isinstance(value, Mapping):
        return {_whole(key): plain(source, (*path, key), item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(source, (*path, str(n)), item) for n, item in enumerate(value)]
    if isinstance(value, str):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise source.error(
            path, f"{_item_name(path)} is {type_name(value)}; give a number or a text"
        )
    # A whole number beyond what a float holds exactly is no count.
    number = value if abs(value) <= EXACT else _float(value)
    if not math.isfinite(number):
        raise source.error(path, f"{_item_name(path)} is {number}; give a finite number")
    return number


def _float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _item_name(path: Path) -> str:
    """What a message calls a value; one of an array by the name of the array."""
    names = [key for key in path if not key.isdigit()]
    return f"an entry of {names[-1]}" if names and path[-1].isdigit() else path[-1]


def _whole(key: str) -> str | int:
    return int(key) if key.isascii() and key.isdigit() and len(key) < 6 else key
