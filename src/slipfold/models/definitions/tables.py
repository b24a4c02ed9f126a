"""Tables of files: checked by pydantic, or made into objects whose class they name.

The first thing that is wrong with a table is one sentence.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from typing import Any, TypeVar

from slipfold.errors import InputError, not_supported, suggest

_EXPECTED = {
    "string": "a text in quotes",
    "bool": "true or false",
    "int": "a whole number",
    "dict": "a table",
    "list": "an array",
    "tuple": "an array",
}
"""What pydantic asks for, in the words of TOML, by the first words of its errors."""


class WrongEntry(ValueError):
    """An entry that cannot be used.

    The message follows the name of the entry in the sentence, unless it is `complete`. `part` is
    the key of what to point at in the entry; `at_key` says to point at the key, not the value.
    """

    def __init__(
        self,
        message: str,
        part: str | None = None,
        *,
        at_key: bool = False,
        complete: bool = False,
        path: Sequence[str] = (),
    ) -> None:
        super().__init__(message)
        self.message, self.part, self.path = message, part, tuple(path)
        self.at_key, self.complete = at_key, complete

    def below(self, path: Sequence[str]) -> WrongEntry:
        """Return the same of an entry whose table has a path."""
        options = {"at_key": self.at_key, "complete": self.complete}
        return WrongEntry(self.message, self.part, path=(*path, *self.path), **options)

    def sentence(self, root: str) -> str:
        """Return the sentence; `root` is the name of the outermost table."""
        return self.message if self.complete else f"{entry_name(self.path) or root} {self.message}"


def validate(check: Callable[[Any], Any], given: Any, *skipped: str) -> Any:
    """Validate a value with pydantic; raise `WrongEntry` if it refuses.

    `skipped` are names of types that pydantic may put among the keys of a path.
    """
    from pydantic import ValidationError

    try:
        return check(given)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
    keys = [str(key) for key in first["loc"]]
    path = [key for key in keys if key != "[key]" and key not in skipped]
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, WrongEntry):
        wrong = cause
    elif isinstance(cause, InputError):
        wrong = WrongEntry(str(cause), complete=True)
    else:
        message, *entry = _message(first)
        wrong = WrongEntry(message, path=entry)
    wrong.at_key |= keys[-1:] == ["[key]"]
    raise wrong.below(path) from None


def validated(check: Callable[[Any], Any], given: Any, position: str, key: str = "") -> Any:
    """Validate a table with pydantic; raise `InputError` that names the entry.

    Where a key says what else the table has, pydantic puts its value before the other keys.
    """
    kind = given.get(key) if isinstance(given, Mapping) else None
    try:
        return validate(check, given, "float", "str", *([str(kind)] if key else []))
    except WrongEntry as wrong:
        keys = position.split(".") if " " not in position else []  # words name no table of a file
        raise InputError(wrong.below(keys).sentence(position)) from None


def _message(first: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the message about the first error, and the key of the entry in the table."""
    context: Mapping[str, Any] = first.get("ctx", {})
    kind, value = first["type"], first["input"]
    expected = next((words for name, words in _EXPECTED.items() if kind.startswith(name)), None)
    if kind == "list_type" and isinstance(value, Mapping):
        return (f"is a table; give an array of tables, each headed [[{first['loc'][-1]}]]",)
    if kind == "missing":
        return ("is missing; give it",)
    if kind == "extra_forbidden":
        return ("is unknown; leave it out",)
    if kind == "union_tag_not_found":
        return "is missing; give it", context["discriminator"].strip("'")
    if kind == "union_tag_invalid":
        message = _unknown(context["tag"], context["expected_tags"])
        return message, context["discriminator"].strip("'")
    if kind == "literal_error":
        return (_unknown(value, context["expected"]),)
    if kind == "greater_than":
        return (f"= {_shown(value)} is not > {context['gt']:g}",)
    if kind == "too_short":
        return (f"is empty; give at least {context['min_length']}",)
    if kind == "too_long":
        return (f"has {context['actual_length']} entries, more than {context['max_length']}",)
    if expected is not None and kind.endswith("_type"):
        return (f"is {type_name(value)}; give {expected}",)
    message = first["msg"]
    return (f"= {_shown(value)} cannot be used: {message[:1].lower()}{message[1:]}",)


def _unknown(value: object, expected: str) -> str:
    """Say that a value is none of those that are expected, and which of them may be meant."""
    meant = suggest(str(value), re.findall(r"'([^']*)'", expected))
    return f"= {_shown(value)} is unknown; {meant}give {expected}"


def _shown(value: object) -> str:
    return repr(value[:80] if isinstance(value, str) else value)


def entry_name(path: Sequence[str]) -> str:
    """Return the name of an entry in messages, such as ``elements[0].k``."""
    plain = re.compile(r"[\w-]+", re.ASCII)
    parts = (
        f"[{key}]" if key.isdigit() else f".{key}" if plain.fullmatch(key) else f'."{key[:60]}"'
        for key in path
    )
    return "".join(parts).removeprefix(".")


def type_name(value: object) -> str:
    """Return the kind of a value in the words of TOML."""
    if isinstance(value, bool):
        return "true or false"
    for kind, words in (
        (str, "a text"),
        (Real, "a number"),
        (Mapping, "a table"),
        (Sequence, "an array"),
    ):
        if isinstance(value, kind):
            return words
    return "empty" if value is None else f"a {type(value).__name__}"


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
    given: Any, kinds: Mapping[str, type[P]], key: str, readers: Mapping[str, Callable[[Any], Any]]
) -> P:
    """Make an object from a table: the entry `key` names the class, the others are arguments.

    `readers` convert entries that are not numbers, texts or arrays.
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
        position = error.entry or ([first] if first in table else [])
        raise WrongEntry(str(error), complete=True, path=position) from None
    return made


def _plain(given: Any) -> Any:
    """Convert keys that are integers, such as powers and harmonics."""
    if not isinstance(given, Mapping):
        return given
    return {int(key) if str(key).isdecimal() else key: value for key, value in given.items()}


def part_table(part: Any, key: str, write: Callable[[Any], Any]) -> dict[str, Any]:
    """Return the table from which `read_part` makes the part."""
    values = {_entry_name(item): getattr(part, item.name) for item in dataclasses.fields(part)}
    given = {name: write(value) for name, value in values.items() if value not in (None, "")}
    return {key: type(part).__name__, **given}


def _entry_name(item: dataclasses.Field[Any]) -> str:
    return str(item.metadata.get("entry", item.name))
