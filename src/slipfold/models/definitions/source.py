"""Where a system of equations was written, so that messages can point at the place."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slipfold.errors import InputError
from slipfold.models.definitions.toml_places import Path as Keys
from slipfold.models.definitions.toml_places import Place, find_places
from slipfold.models.formulas.tokens import FormulaError

LONGEST_FILE = 300_000
"""Characters of the longest file."""

WIDTH = 88
"""Characters of a line that a message shows."""


@dataclass(frozen=True)
class Source:
    """The tables of a system, and the text that they were read from."""

    tables: Mapping[str, Any]  # the entries, as `tomllib` gives them
    label: str = ""  # what messages call it, e.g. the name of the file
    text: str | None = None  # the text; None for tables made in Python
    places: Mapping[Keys, Place] | None = None  # where the entries stand in the text

    def error(self, path: Keys, message: str, key: bool = False) -> InputError:
        """Return the error about an entry."""
        place = self._find(path)
        if place is None or self.text is None:
            return InputError(f"{self.label}: {message}" if self.label else message)
        return self._located(message, place.key if key else place.value, 1)

    def formula_error(self, path: Keys, formula: str, error: FormulaError) -> InputError:
        """Return the error about a place in a formula."""
        place = self.places.get(path) if self.places else None
        if place is None or self.text is None:
            return self._inside(".".join(path), formula, error)
        begin = _begin_of_string(self.text, place.value)
        # Escapes move the letters: then the beginning of the text must do.
        same = self.text.startswith(formula, begin)
        offset = begin + error.place if same else place.value
        return self._located(error.message, offset, error.length)

    def _find(self, path: Keys) -> Place | None:
        places = self.places or {}
        while path:
            if path in places:
                return places[path]
            path = path[:-1]
        return None

    def _located(self, message: str, offset: int, length: int) -> InputError:
        assert self.text is not None
        line = self.text.count("\n", 0, offset) + 1
        column = offset - (self.text.rfind("\n", 0, offset) + 1)
        where = f"line {line}, column {column + 1}"
        shown = _excerpt(self.text.split("\n")[line - 1], column, length, f"{line:>4} | ")
        return InputError(f"{_joined(self.label, where)}: {message}\n{shown}")

    def _inside(self, entry: str, formula: str, error: FormulaError) -> InputError:
        before = formula[: error.place]
        line, column = before.count("\n"), error.place - (before.rfind("\n") + 1)
        where = f"{entry}, column {column + 1}"
        shown = _excerpt(formula.split("\n")[line], column, error.length, "     | ")
        return InputError(f"{_joined(self.label, where)}: {error.message}\n{shown}")


def _joined(label: str, where: str) -> str:
    return f"{label}, {where}" if label else where


def _begin_of_string(text: str, place: int) -> int:
    """Return where the content of the string that begins at a place begins."""
    for quotes in ('"""', "'''"):
        if text.startswith(quotes, place):
            # A newline right behind the quotes does not count.
            return place + (4 if text.startswith("\n", place + 3) else 3)
    return place + 1


def _excerpt(line: str, column: int, length: int, margin: str) -> str:
    """Return a line, or the part of it around a column, with carets below."""
    first = max(0, min(column - WIDTH // 2, len(line) - WIDTH))
    shown = "".join(c if c.isprintable() else " " for c in line[first : first + WIDTH])
    carets = "^" * max(1, min(length, len(shown) - (column - first)))
    return f"{margin}{shown}\n{' ' * len(margin)}{' ' * (column - first)}{carets}"


def source_of_tables(tables: Mapping[str, Any], label: str = "") -> Source:
    """Return the source of a system that is made in Python."""
    return Source(tables, label)


def source_of_file(path: Path) -> Source:
    """Read a TOML file."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"{path} cannot be read ({str(why).lower()}); give the path of a TOML file"
        ) from error
    return source_of_text(text, str(path))


def source_of_text(text: str, label: str = "") -> Source:
    r"""Read a TOML text.

    >>> source_of_text('[states]\nq = "-q"').tables
    {'states': {'q': '-q'}}
    """
    if len(text) > LONGEST_FILE:
        raise InputError(
            f"{label or 'the text'} has {len(text)} characters, more than {LONGEST_FILE}; a system "
            "of equations is shorter, give its file"
        )
    # Some editors begin a file with a byte order mark.
    text = text.removeprefix("\ufeff").replace("\r\n", "\n")
    try:
        tables = tomllib.loads(text)
    except RecursionError:
        raise InputError(
            f"{label or 'the text'} is nested too deeply; a system has tables of entries"
        ) from None
    # Besides its own error, tomllib lets through those of numbers and dates.
    except (ValueError, OverflowError) as error:
        raise _not_toml(text, label, str(error)) from None
    return Source(tables, label, text, find_places(text))


def _not_toml(text: str, label: str, reason: str) -> InputError:
    match = re.search(r" \(at line (\d+), column (\d+)\)$", reason)
    message = f"this is not TOML ({reason[: match.start()] if match else reason}); "
    message += 'an entry reads like F = 0.18 or q = "v", a table begins with [states]'
    if match is None:
        return Source({}, label).error((), message)
    line, column = int(match[1]), int(match[2])
    offset = sum(len(item) + 1 for item in text.split("\n")[: line - 1]) + column - 1
    return Source({}, label, text)._located(message, min(offset, len(text)), 1)
