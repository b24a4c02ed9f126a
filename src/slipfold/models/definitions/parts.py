"""Parts of models as tables that name their class and its arguments: read, and written."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from slipfold.errors import InputError
from slipfold.models.suggestion import not_supported, suggest
from slipfold.text.validated import WrongEntry, type_name

P = TypeVar("P")


def check_keys(given: Any, known: Sequence[str], required: Mapping[str, str]) -> None:
    """Refuse what is not a table with known entries and all those that are required.

    `required` has an example of each such entry, or an empty text.
    """
    there_are = ", ".join(known)
    if not isinstance(given, Mapping):
        raise WrongEntry(f"is {type_name(given)}, not a table; give a table with {there_are}")
    for key in map(str, given):
        if key not in known:
            near = not_supported(key) or suggest(key[:80], known)
            message = f"has no entry {key[:80]!r}; {near}there are {there_are}"
            raise WrongEntry(message, key, at_key=True)
    for key, example in required.items():
        if key not in given:
            raise WrongEntry(f"has no {key}; give {f'e.g. {example}' if example else 'it'}")


def read_part(
    given: Any,
    kinds: Mapping[str, type[P]],
    key: str,
    readers: Mapping[str, Callable[[Any], Any]],
) -> P:
    """Make an object of a table whose entry `key` says which class; the others are arguments.

    `readers` make arguments of entries that are more than numbers, texts and arrays.
    """
    table = {key: given} if isinstance(given, str) else given
    if not isinstance(table, Mapping):
        example = f'{key} = "{next(iter(kinds))}"'
        raise WrongEntry(f"is {type_name(given)}, not a table; give a table with {example}")
    if key not in table and len(kinds) > 1:
        raise WrongEntry(f"has no {key}; give one of {', '.join(kinds)}")
    name = table.get(key, next(iter(kinds)))
    if not isinstance(name, str) or name not in kinds:
        shown = repr(name[:80]) if isinstance(name, str) else type_name(name)
        near = suggest(name[:80], kinds) if isinstance(name, str) else ""
        message = f"= {shown} is unknown; {near}there are {', '.join(kinds)}"
        raise WrongEntry(message, path=[key])
    cls: Any = kinds[name]
    fields = {_entry_name(item): item for item in dataclasses.fields(cls)}
    missing = dataclasses.MISSING
    required = [
        entry for entry, item in fields.items() if item.default is item.default_factory is missing
    ]
    check_keys(table, [key, *fields], dict.fromkeys(required, ""))
    arguments = {}
    for entry in (entry for entry in fields if entry in table):
        try:
            arguments[fields[entry].name] = readers.get(entry, _plain)(table[entry])
        except WrongEntry as wrong:
            raise wrong.below([entry]) from None
        except InputError as error:
            raise WrongEntry(str(error), complete=True, path=[entry]) from None
    try:
        made: P = cls(**arguments)
    except InputError as error:
        # A message about several arguments begins with the name of one.
        first = str(error).removeprefix("the ").split(" ")[0]
        place = error.entry or ([first] if first in table else [])
        raise WrongEntry(str(error), complete=True, path=place) from None
    return made


def _plain(given: Any) -> Any:
    """Return keys of tables that are whole numbers as such: powers and harmonics."""
    if not isinstance(given, Mapping):
        return given
    return {int(key) if str(key).isdecimal() else key: value for key, value in given.items()}


def part_table(part: Any, key: str, write: Callable[[Any], Any]) -> dict[str, Any]:
    """Return the table of which `read_part` makes a part again."""
    values = {_entry_name(item): getattr(part, item.name) for item in dataclasses.fields(part)}
    given = {name: write(value) for name, value in values.items() if value not in (None, "")}
    return {key: type(part).__name__, **given}


def _entry_name(item: dataclasses.Field[Any]) -> str:
    return str(item.metadata.get("entry", item.name))
