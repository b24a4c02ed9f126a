"""Text of models, with the locations of entries that messages point at."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any, TypeVar

from slipfold.errors import InputError
from slipfold.models.definitions.tables import WrongEntry
from slipfold.models.formulas.grammar import BOUNDS, FormulaError
from slipfold.writing import to_read

T = TypeVar("T")

Keys = tuple[str, ...]

_TOKEN = re.compile(
    r"(?P<space>[ \t\r]+|#[^\n]*)"
    r'|(?P<string>"""(?:[^"\\]|\\.|"(?!""))*"{3,5}'
    r"|'''(?:[^']|'(?!''))*'{3,5}"
    r'|"(?:[^"\\\n]|\\.)*"'
    r"|'[^'\n]*')"
    r"|(?P<sign>[\[\]{}=,.\n])"
    r"|(?P<word>[^\s\[\]{}=,.#\"']+)"
    r"|(?P<other>.)",
    re.DOTALL,
)


@dataclass(frozen=True)
class Location:
    """Offsets of an entry in the text."""

    key: int  # where its key or table header begins
    value: int  # where its value begins; the same as `key` for a table header


def find_locations(text: str) -> dict[Keys, Location]:
    r"""Find keys and values of a valid TOML text.

    >>> find_locations('[states]\nq = "v"')[("states", "q")]
    Location(key=9, value=13)
    >>> find_locations('[[forces]]\nF = [1, 2]')[("forces", "0", "F", "1")]
    Location(key=19, value=19)
    """
    locations: dict[Keys, Location] = {}
    arrays: dict[Keys, int] = {}  # position of the last table in an array of tables
    table: Keys = ()
    opened: list[tuple[Keys, Iterator[int] | None]] = []  # arrays, with positions; inline tables
    expected, key, start = "key", list[str](), 0
    for match in _TOKEN.finditer(text + "\n"):
        kind, word, offset = match.lastgroup, match.group(), match.start()
        if kind == "space":
            continue
        if expected == "scalar" and word in ("\n", ",", "]", "}"):
            expected = "value" if opened and opened[-1][1] else "key"
        if word == "\n":
            if expected == "header":
                table = _note_header(locations, arrays, key, text.startswith("[[", start), start)
            if not opened:
                expected, key = "key", []
        elif word == "," and opened:
            key = []
        elif word in ("]", "}") and opened:
            opened.pop()
            expected = "scalar"
        elif expected == "key" and word == "[":
            expected, start = "header", offset
        elif expected == "key" and word == "=":
            expected = "value"
        elif expected in ("key", "header") and kind in ("word", "string"):
            start = start if key or expected == "header" else offset
            key.append(word[1:-1] if kind == "string" else word)
        elif expected == "value":
            above, items = opened[-1] if opened else (table, None)
            path = (*above, *(key if items is None else [str(next(items))]))
            locations[path] = Location(start if items is None else offset, offset)
            expected, key = "scalar", []
            if word in ("[", "{"):
                opened.append((path, count() if word == "[" else None))
                expected = "value" if word == "[" else "key"
    return locations


def value_end(text: str, start: int) -> int:
    r"""Return where the value ends that begins at an offset of a valid TOML text.

    >>> value_end('a = { b = "}" } # c', 4)
    15
    """
    depth = 0
    for match in _TOKEN.finditer(text, start):
        word = match.group()
        if depth == 0 and word in ("\n", ",", "]", "}"):
            break
        depth += (word in ("[", "{")) - (word in ("]", "}"))
        if match.lastgroup != "space":
            start = match.end()
        if depth == 0 and word in ("]", "}"):
            break
    return start


def _note_header(
    locations: dict[Keys, Location],
    arrays: dict[Keys, int],
    key: list[str],
    several: bool,
    offset: int,
) -> Keys:
    """Store the location of a table header; return the path of the table."""
    path: Keys = ()
    for name in key[: BOUNDS.depth]:  # no table that is read lies deeper
        path = (*path, name)
        if several and len(path) == len(key):
            arrays[path] = arrays.get(path, -1) + 1
        locations.setdefault(path, Location(offset, offset))
        if path in arrays:
            path = (*path, str(arrays[path]))
    locations.setdefault(path, Location(offset, offset))
    return path


@dataclass(frozen=True)
class Source:
    """The tables of a system, and the text that they were read from."""

    tables: Mapping[str, Any]  # the entries, as `tomllib` gives them
    label: str = ""  # what messages call it, e.g. the name of the file
    text: str | None = None  # the text; None for tables made in Python
    locations: Mapping[Keys, Location] | None = None  # where the entries stand in the text

    def read(
        self, read: Callable[[Any], T], given: Any, path: Keys = (), root: str = "a system"
    ) -> T:
        """Read the value at a path; raise `InputError` that points at it.

        `root` is what messages call the outermost table.
        """
        try:
            return read(given)
        except WrongEntry as wrong:
            wrong = wrong.below(path)
            position = wrong.path if wrong.part is None else (*wrong.path, wrong.part)
            raise self.error(position, wrong.sentence(root), key=wrong.at_key) from None
        except InputError as error:
            raise self.error((*path, *error.entry), str(error)) from None

    def error(self, path: Keys, message: str, key: bool = False) -> InputError:
        """Return the error about an entry, or the table around it if its position is not known."""
        locations = self.locations or {}
        while path and path not in locations:
            path = path[:-1]
        if not path or self.text is None:
            return InputError(f"{self.label}: {message}" if self.label else message)
        return self.error_at(locations[path].key if key else locations[path].value, message)

    def formula_error(self, path: Keys, formula: str, error: FormulaError) -> InputError:
        """Return the error about a position in a formula."""
        position = self.locations.get(path) if self.locations else None
        if position is None or self.text is None:
            inside = Source({}, self.label, formula)
            return inside.error_at(error.position, error.message, error.length, ".".join(path))
        # The content begins behind the quotes, and a newline behind three of them.
        quotes = re.compile(r"(?:\"\"\"|''')\n?|.", re.DOTALL).match(self.text, position.value)
        start = quotes.end() if quotes else position.value
        # Escapes shift the characters: then point at the beginning of the text.
        same = self.text.startswith(formula, start)
        offset = start + error.position if same else position.value
        return self.error_at(offset, error.message, error.length)

    def error_at(self, offset: int, message: str, length: int = 1, entry: str = "") -> InputError:
        """Return the error about a part of the text of a file or an entry."""
        assert self.text is not None
        before = self.text[:offset].split("\n")
        line, column = len(before), len(before[-1])
        where = f"{entry or f'line {line}'}, column {column + 1}"
        where = f"{self.label}, {where}" if self.label else where
        margin = f"{'' if entry else line:>4} | "
        shown = _excerpt(self.text.split("\n")[line - 1], column, length, margin)
        return InputError(f"{where}: {message}\n{shown}")


def _excerpt(line: str, column: int, length: int, margin: str) -> str:
    """Return a line, or the part of it around a column, with carets below."""
    width = 88
    first = max(0, min(column - width // 2, len(line) - width))
    shown = "".join(c if c.isprintable() else " " for c in line[first : first + width])
    carets = "^" * max(1, min(length, len(shown) - (column - first)))
    return f"{margin}{shown}\n{' ' * len(margin)}{' ' * (column - first)}{carets}"


def source_of_file(path: Path, wanted: str = "the path of a TOML file") -> Source:
    """Read a TOML file; messages ask for `wanted` if it cannot be read."""
    path = to_read(path)
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is not TOML ({error}); give {wanted}") from error
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{path} cannot be read ({str(why).lower()}); give {wanted}") from error
    return source_of_text(text, str(path))


def source_of_text(text: str, label: str = "") -> Source:
    r"""Read a TOML text."""
    if len(text) > BOUNDS.file:
        raise InputError(
            f"{label or 'the text'} has {len(text)} characters, more than {BOUNDS.file}; a system "
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
    # tomllib raises its own error, and those of numbers and dates.
    except (ValueError, OverflowError) as error:
        raise _not_toml(text, label, str(error)) from None
    return Source(tables, label, text, find_locations(text))


def _not_toml(text: str, label: str, reason: str) -> InputError:
    match = re.search(r" \(at line (\d+), column (\d+)\)$", reason)
    message = f"this is not TOML ({reason[: match.start()] if match else reason}); "
    message += 'an entry reads like F = 0.18 or q = "v", a table begins with [states]'
    source = Source({}, label, text)
    if match is None:
        return source.error((), message)
    line, column = int(match[1]), int(match[2])
    offset = sum(len(item) + 1 for item in text.split("\n")[: line - 1]) + column - 1
    return source.error_at(min(offset, len(text)), message)
