"""One table of a file, with entries of known names and types; anything else is refused."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

from slipfold.errors import InputError
from slipfold.models.definitions.source import Source
from slipfold.models.quantity import parse_quantity
from slipfold.models.suggestion import not_supported, suggest


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
