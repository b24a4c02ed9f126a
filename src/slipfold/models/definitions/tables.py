"""Tables of a file, checked against the names and types that they may have."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from typing import Any

from slipfold.errors import InputError
from slipfold.models.definitions.source import Keys, Source
from slipfold.models.parameter import Parameter
from slipfold.models.quantity import parse_quantity
from slipfold.models.suggestion import not_supported, suggest
from slipfold.text.validated import type_name


class Entries:
    """The entries of a table.

    `path` holds the keys that lead to it, `known` the names it may have; another one, or no table
    at all, raises `InputError`. Messages call it `what`, or its name in brackets.
    """

    def __init__(
        self,
        source: Source,
        path: tuple[str, ...],
        table: object,
        known: Sequence[str],
        what: str = "",
    ) -> None:
        if not isinstance(table, Mapping):
            raise source.error(
                path,
                f"{'.'.join(path)} is {type_name(table)}, not a table; give a table with "
                f"{', '.join(known)}",
            )
        self._source, self._path, self._table = source, path, table
        for key in table:
            if key not in known:
                where = what or (f"[{'.'.join(path)}]" if path else "a system")
                raise source.error(
                    (*path, str(key)),
                    f"{where} has no entry {str(key)[:80]!r}; "
                    f"{not_supported(str(key)) or suggest(str(key)[:80], known)}"
                    f"there are {', '.join(known)}",
                    key=True,
                )

    def __contains__(self, key: str) -> bool:
        return key in self._table

    def need(self, key: str, message: str) -> None:
        """Refuse a table without an entry."""
        if key not in self._table:
            raise self._source.error(self._path, message)

    def error(self, key: str, message: str) -> InputError:
        """Return the error about an entry."""
        return self._source.error((*self._path, key), message)

    def text(self, key: str, default: str | None = "", lines: bool = False) -> Any:
        """Return a text."""
        value = self._table.get(key, default)
        if value is default:
            return default
        if not isinstance(value, str):
            raise self.error(key, f"{key} is {type_name(value)}; give a text in quotes")
        if not lines and not value.isprintable():
            raise self.error(key, f"{key} = {value[:80]!r} is more than one line; give one line")
        return value

    def number(self, key: str, default: float, unit: str = "") -> float:
        """Return a finite number, given as one or as text with a unit."""
        if key not in self._table:
            return default
        value = self._table[key]
        if isinstance(value, bool) or not isinstance(value, (Real, str)):
            raise self.error(key, f"{key} is {type_name(value)}; give a number")
        try:
            number = parse_quantity(value if isinstance(value, str) else float(value), unit, key)
        except InputError as error:
            raise self.error(key, str(error)) from None
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.error(
                key, f"{key} = {number} is not a finite number; leave it out or give one"
            )
        return number

    def flag(self, key: str) -> bool:
        """Return true or false; false if it is not given."""
        value = self._table.get(key, False)
        if not isinstance(value, bool):
            raise self.error(key, f"{key} is {type_name(value)}; give true or false")
        return value


DEEPEST = 20
"""Nested tables and arrays that are looked into."""

Reader = Callable[[Source, Keys, Any], Any]
"""What makes an argument of an entry: of where it was written, the path to it and its value."""


def read_part(
    source: Source,
    path: Keys,
    value: object,
    kinds: Mapping[str, type],
    key: str,
    readers: Mapping[str, Reader] | None = None,
) -> Any:
    """Make an object of a table that says which class and with which arguments."""
    table = {key: value} if isinstance(value, str) else value
    if not isinstance(table, Mapping):
        raise source.error(
            path,
            f'{path[-1]} is {type_name(value)}; give a table with {key} = "{next(iter(kinds))}"',
        )
    cls = kinds[_kind_name(source, path, table, kinds, key)]
    known = {_entry_name(item): item for item in dataclasses.fields(cls)}
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


def part_table(part: Any, key: str, write: Callable[[Any], Any]) -> dict[str, Any]:
    """Return the table of which `read_part` makes a part again."""
    values = {_entry_name(item): getattr(part, item.name) for item in dataclasses.fields(part)}
    given = {name: write(value) for name, value in values.items() if value not in (None, "")}
    return {key: type(part).__name__, **given}


def _entry_name(item: dataclasses.Field[Any]) -> str:
    return str(item.metadata.get("entry", item.name))


def _kind_name(
    source: Source, path: Keys, table: Mapping[str, Any], kinds: Mapping[str, type], key: str
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


def _last_name(path: Keys) -> str:
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


def plain(source: Source, path: Keys, value: Any) -> Any:
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
    number = value if abs(value) <= 2**53 else _float(value)
    if not math.isfinite(number):
        raise source.error(path, f"{_item_name(path)} is {number}; give a finite number")
    return number


def _float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _item_name(path: Keys) -> str:
    """What a message calls a value; one of an array by the name of the array."""
    names = [key for key in path if not key.isdigit()]
    return f"an entry of {names[-1]}" if names and path[-1].isdigit() else path[-1]


def _whole(key: str) -> str | int:
    return int(key) if key.isascii() and key.isdigit() and len(key) < 6 else key
