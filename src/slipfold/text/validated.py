"""Tables checked by pydantic; the first thing that is wrong with one is one sentence."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from typing import Any

from slipfold.errors import InputError

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
    """What is wrong with an entry.

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
    """Return what pydantic makes of a value; raise `WrongEntry` if it refuses.

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


def validated(check: Callable[[Any], Any], given: Any, place: str, key: str = "") -> Any:
    """Return what pydantic makes of a table that stands in some place.

    Where a key says what else the table has, pydantic puts its value before the other keys.
    """
    kind = given.get(key) if isinstance(given, Mapping) else None
    try:
        return validate(check, given, "float", "str", *([str(kind)] if key else []))
    except WrongEntry as wrong:
        keys = place.split(".") if " " not in place else []  # words name no table of a file
        raise InputError(wrong.below(keys).sentence(place)) from None


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
        message = f"= {context['tag']!r} is unknown; give {context['expected_tags']}"
        return message, context["discriminator"].strip("'")
    if kind == "literal_error":
        return (f"= {_shown(value)} is unknown; give {context['expected']}",)
    if kind == "greater_than":
        return (f"= {_shown(value)} is not > {context['gt']:g}",)
    if kind == "too_long":
        return (f"has {context['actual_length']} entries, more than {context['max_length']}",)
    if expected is not None and kind.endswith("_type"):
        return (f"is {type_name(value)}; give {expected}",)
    message = first["msg"]
    return (f"= {_shown(value)} cannot be used: {message[:1].lower()}{message[1:]}",)


def _shown(value: object) -> str:
    return repr(value[:80] if isinstance(value, str) else value)


def entry_name(path: Sequence[str]) -> str:
    """Return what a message calls an entry.

    >>> entry_name(["elements", "0", "k"])
    'elements[0].k'
    """
    plain = re.compile(r"[\w-]+", re.ASCII)
    parts = (
        f"[{key}]" if key.isdigit() else f".{key}" if plain.fullmatch(key) else f'."{key[:60]}"'
        for key in path
    )
    return "".join(parts).removeprefix(".")


def type_name(value: object) -> str:
    """Return what a value is, in the words of TOML.

    >>> type_name([1, 2]), type_name(True)
    ('an array', 'true or false')
    """
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
