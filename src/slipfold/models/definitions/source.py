"""Where a model was written, so that messages can point at the place."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slipfold.errors import InputError
from slipfold.models.formulas.grammar import FormulaError

Keys = tuple[str, ...]

DEEPEST = 20
"""Nested tables and arrays that are looked into."""

_TOKEN = re.compile(
    r"(?P<space>[ \t\r]+|#[^\n]*)"
    r"|(?P<newline>\n)"
    r'|(?P<string>"""(?:[^"\\]|\\.|"(?!""))*"{3,5}'
    r"|'''(?:[^']|'(?!''))*'{3,5}"
    r'|"(?:[^"\\\n]|\\.)*"'
    r"|'[^'\n]*')"
    r"|(?P<sign>[\[\]{}=,.])"
    r"|(?P<word>[^\s\[\]{}=,.#\"']+)"
    r"|(?P<other>.)",
    re.DOTALL,
)


@dataclass(frozen=True)
class Place:
    """Offsets of an entry in the text."""

    key: int  # where its key or table header begins
    value: int  # where its value begins; the same as `key` for a table header


def find_places(text: str) -> dict[Keys, Place]:
    r"""Find keys and values of a valid TOML text.

    >>> find_places('[states]\nq = "v"')[("states", "q")]
    Place(key=9, value=13)
    >>> find_places('[[forces]]\nF = [1, 2]')[("forces", "0", "F", "1")]
    Place(key=19, value=19)
    """
    scanner = _Scanner(text)
    scanner.scan()
    return scanner.places


class _Scanner:
    """Walks over the words of the text; as it is valid, little needs to be understood."""

    def __init__(self, text: str) -> None:
        self.places: dict[Keys, Place] = {}
        self._arrays: dict[Keys, int] = {}
        self._words = [
            (str(match.lastgroup), match.group(), match.start())
            for match in _TOKEN.finditer(text)
            if match.lastgroup != "space"
        ]
        self._index = 0

    def scan(self) -> None:
        table: Keys = ()
        while self._index < len(self._words):
            kind, text, place = self._words[self._index]
            if kind == "newline":
                self._index += 1
            elif text == "[":
                table = self._header(place)
            else:
                self._entry(table, 0)

    def _text(self) -> str:
        return self._words[self._index][1] if self._index < len(self._words) else ""

    def _header(self, place: int) -> Keys:
        first = self._index
        while self._text() == "[":
            self._index += 1
        several = self._index > first + 1
        *above, last = self._key() or ("",)
        table = self._inside(above)
        if several:
            self._arrays[(*table, last)] = self._arrays.get((*table, last), -1) + 1
        self.places.setdefault((*table, last), Place(place, place))
        table = self._inside((*above, last))
        self.places.setdefault(table, Place(place, place))
        while self._text() == "]":
            self._index += 1
        return table

    def _inside(self, keys: Sequence[str]) -> Keys:
        """Return the path of a table; of tables in an array the last one is meant."""
        path: Keys = ()
        for key in keys:
            path = (*path, key)
            if path in self._arrays:
                path = (*path, str(self._arrays[path]))
        return path

    def _key(self) -> Keys:
        """Read a dotted key up to the sign behind it."""
        parts: list[str] = []
        while self._index < len(self._words):
            kind, text, _ = self._words[self._index]
            if kind not in ("word", "string") and text != ".":
                break
            if text != ".":
                parts.append(text[1:-1] if kind == "string" else text)
            self._index += 1
        return tuple(parts)

    def _entry(self, table: Keys, depth: int) -> None:
        """Read ``key = value``; whatever else stands here is skipped."""
        begin, index = self._words[self._index][2], self._index
        path = table + self._key()
        if self._text() != "=":
            self._index = max(self._index, index + 1)
            return
        self._index += 1
        if self._index < len(self._words):
            self.places[path] = Place(begin, self._words[self._index][2])
        self._value(path, depth + 1)

    def _value(self, path: Keys, depth: int) -> None:
        opening = self._text()
        if opening == "{" and depth < DEEPEST:
            self._index += 1
            while self._text() not in ("}", ""):
                if self._text() in (",", "\n"):
                    self._index += 1
                else:
                    self._entry(path, depth)
            self._index += 1
        elif opening == "[" and depth < DEEPEST:
            self._items(path, depth)
        elif opening in ("[", "{"):
            self._skip_nested()
        else:
            while self._text() not in ("\n", ",", "}", "]", ""):
                self._index += 1

    def _items(self, path: Keys, depth: int) -> None:
        """Read the items of an array."""
        self._index += 1
        number = 0
        while self._text() not in ("]", ""):
            if self._text() in (",", "\n"):
                self._index += 1
                continue
            index, begin = self._index, self._words[self._index][2]
            item = (*path, str(number))
            self.places[item] = Place(begin, begin)
            self._value(item, depth + 1)
            self._index = max(self._index, index + 1)
            number += 1
        self._index += 1

    def _skip_nested(self) -> None:
        depth = 0
        while self._index < len(self._words):
            depth += {"[": 1, "{": 1, "]": -1, "}": -1}.get(self._text(), 0)
            self._index += 1
            if depth <= 0:
                return


LONGEST_FILE = 300_000
"""Characters of the longest file."""

MOST_ENTRIES = 1000
"""Entries of a table, elements of an array or terms of a sum: each is compiled."""

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
