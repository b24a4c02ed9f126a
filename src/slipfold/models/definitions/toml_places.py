"""Where each key and value of a TOML text stands, which `tomllib` does not tell."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

Path = tuple[str, ...]

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


def find_places(text: str) -> dict[Path, Place]:
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
        self.places: dict[Path, Place] = {}
        self._arrays: dict[Path, int] = {}
        self._words = [
            (str(match.lastgroup), match.group(), match.start())
            for match in _TOKEN.finditer(text)
            if match.lastgroup != "space"
        ]
        self._index = 0

    def scan(self) -> None:
        table: Path = ()
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

    def _header(self, place: int) -> Path:
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

    def _inside(self, keys: Sequence[str]) -> Path:
        """Return the path of a table; of tables in an array the last one is meant."""
        path: Path = ()
        for key in keys:
            path = (*path, key)
            if path in self._arrays:
                path = (*path, str(self._arrays[path]))
        return path

    def _key(self) -> Path:
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

    def _entry(self, table: Path, depth: int) -> None:
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

    def _value(self, path: Path, depth: int) -> None:
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

    def _items(self, path: Path, depth: int) -> None:
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
