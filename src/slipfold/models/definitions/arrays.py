"""Entries and formulas with indices, such as ``"x[i=1:50]"``, written out one by one."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

from slipfold.models.definitions.source import MOST_ENTRIES, Keys, Source
from slipfold.models.formulas.grammar import (
    LONGEST_FORMULA,
    Binary,
    FormulaError,
    Name,
    Negative,
    Number,
    Tree,
    fold,
    format_tree,
    parse_formula,
)
from slipfold.text.validated import type_name

LARGEST_INDEX = 100_000
"""A number beyond is a slip of the pen; tables hold a thousand entries."""


_WORD = re.compile(r"\s+|(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[A-Za-z_]\w*|.", re.ASCII | re.DOTALL)
_RANGE = re.compile(r"\s*([A-Za-z_]\w*)\s*=([^:]*):([^:]*)", re.ASCII | re.DOTALL)

CLOSING = {"(": ")", "[": "]"}


def written_out(text: str, numbers: Mapping[str, int]) -> str:
    """Return a formula with the names of elements, sums term by term, and numbers for indices.

    >>> written_out("k*(x[i-1] - 2*x[i]) + i*sum(j=1:2, a[j]^2)", {"i": 3})
    'k*(x2 - 2*x3) + 3*(a1^2 + a2^2)'
    """
    return _Writer(text).write(0, None, numbers)


def element_name(base: str, indices: tuple[int, ...]) -> str:
    """Return the name of an element, e.g. ``x12`` of x[12] and ``u1_2`` of u[1, 2].

    >>> element_name("x", (12,)), element_name("k1", (2,))
    ('x12', 'k1_2')
    """
    between = "_" if base[-1].isdigit() else ""
    return base + between + "_".join(map(str, indices))


def whole_number(text: str, numbers: Mapping[str, int], offset: int = 0) -> int:
    """Return what an index amounts to: whole numbers, indices and sizes, + - * and parentheses.

    >>> whole_number("2*(n - i)", {"n": 5, "i": 4})
    2
    """

    def combine(node: Tree, values: tuple[int, ...]) -> int:
        if isinstance(node, Number) and node.value.is_integer():
            return int(node.value)
        if isinstance(node, Name) and node.name in numbers:
            return numbers[node.name]
        if isinstance(node, Negative):
            return -values[0]
        if isinstance(node, Binary) and node.operator in "+-*":
            left, right = values
            return {"+": left + right, "-": left - right, "*": left * right}[node.operator]
        known = ", ".join(numbers) or "none"
        raise FormulaError(
            f"{format_tree(node)[:40]} is not an index; give whole numbers with + - * and the "
            f"names of indices and sizes, known here: {known}",
            getattr(node, "place", 0),
        )

    try:
        number = fold(parse_formula(text), combine)
    except FormulaError as error:
        raise FormulaError(error.message, error.place + offset, error.length) from None
    if not 0 <= number <= LARGEST_INDEX:
        raise FormulaError(
            f"the index {text.strip()[:40]} is {number}; give one from 0 to {LARGEST_INDEX}", offset
        )
    return number


def index_range(text: str, numbers: Mapping[str, int], offset: int = 0) -> tuple[str, range] | None:
    """Return name and values of ``i = first:last``; None if it is no range."""
    match = _RANGE.fullmatch(text)
    if match is None:
        return None
    first, last = (
        whole_number(match[part], numbers, offset + match.start(part)) for part in (2, 3)
    )
    if last - first >= MOST_ENTRIES:
        raise FormulaError(
            f"{match[1]} takes {last - first + 1} values, more than {MOST_ENTRIES}",
            offset,
            len(text),
        )
    return match[1], range(first, last + 1)


class _Writer:
    """One formula, word by word."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._words = [(match.group(), match.start()) for match in _WORD.finditer(text)]
        self._length = 0

    def write(self, first: int, last: int | None, numbers: Mapping[str, int]) -> str:
        """Write the words of a stretch out."""
        found, place = [], first
        end = len(self._words) if last is None else last
        while place < end:
            word, _ = self._words[place]
            opening = self._behind(place, end)
            if _is_name(word) and self._word(opening) == "[":
                closing = self._closing(opening)
                indices = [whole_number(*part) for part in self._parts(opening, closing, numbers)]
                found.append(element_name(word, tuple(indices)))
                place = closing
            elif word == "sum" and self._word(opening) == "(" and self._has_range(opening):
                closing = self._closing(opening)
                found.append(f"({self._sum(opening, closing, numbers)})")
                place = closing
            else:
                found.append(str(numbers.get(word, word)))
            self._count(found[-1])
            place += 1
        return "".join(found)

    def _sum(self, opening: int, closing: int, numbers: Mapping[str, int]) -> str:
        """Write the terms of a sum: one range or more, then what is summed."""
        commas = list(self._commas(opening, closing))
        text, _, offset = next(self._parts(opening, closing, numbers))
        given = index_range(text, numbers, offset)
        if given is None or not commas:
            raise FormulaError(
                "a sum has a range and a term; write e.g. sum(i=1:3, x[i])",
                self._words[opening][1],
            )
        name, values = given
        terms = []
        for value in values:
            inner = {**numbers, name: value}
            if len(commas) > 1:  # the next range
                terms.append(self._sum(commas[0], closing, inner))
            else:
                terms.append(self.write(commas[0] + 1, closing, inner).strip())
        return " + ".join(terms) or "0"

    def _count(self, written: str) -> None:
        self._length += len(written)
        if self._length > LONGEST_FORMULA:
            raise FormulaError(f"written out it has more than {LONGEST_FORMULA} characters", 0)

    def _word(self, place: int) -> str:
        return self._words[place][0] if place < len(self._words) else ""

    def _behind(self, place: int, end: int) -> int:
        """Return the place of the next word that is no space."""
        place += 1
        while place < end and self._words[place][0].isspace():
            place += 1
        return place if place < end else len(self._words)

    def _has_range(self, opening: int) -> bool:
        name = self._behind(opening, len(self._words))
        return self._word(self._behind(name, len(self._words))) == "="

    def _closing(self, opening: int) -> int:
        wanted: list[str] = []
        for place in range(opening, len(self._words)):
            word = self._words[place][0]
            if word in CLOSING:
                wanted.append(CLOSING[word])
            elif wanted and word == wanted[-1]:
                wanted.pop()
                if not wanted:
                    return place
        sign = self._words[opening][0]
        raise FormulaError(
            f"this {sign} is never closed; add a {CLOSING[sign]} where it ends",
            self._words[opening][1],
        )

    def _commas(self, opening: int, closing: int) -> Iterator[int]:
        """Yield the places of the commas that part what stands between parentheses."""
        depth = 0
        for place in range(opening + 1, closing):
            word = self._words[place][0]
            depth += (word in CLOSING) - (word in CLOSING.values())
            if word == "," and depth == 0:
                yield place

    def _parts(
        self, opening: int, closing: int, numbers: Mapping[str, int]
    ) -> Iterator[tuple[str, Mapping[str, int], int]]:
        """Yield what stands between commas: text, numbers, place."""
        bounds = [opening, *self._commas(opening, closing), closing]
        for left, right in pairwise(bounds):
            begin = self._words[left][1] + 1
            yield self._text[begin : self._words[right][1]], numbers, begin


def _is_name(word: str) -> bool:
    return word.isidentifier()


FORMULA_KEYS = ("rate", "formula", "output", "period", "slip", "normal")
"""Entries that are formulas or names in them; `formulas` and short forms of others are as well."""

PLAIN = ("parameters",)
"""Tables whose texts are no formulas but numbers with a unit."""

TABLES = ("parameters", "formulas", "states", "contacts", "outputs", "limits", "events")

LABEL = {"parameters": "symbol", "states": "label", "outputs": "label"}
"""How figures write an element: with its index below."""

_KEY = re.compile(r"\s*([A-Za-z_]\w*)\s*\[(.*)\]\s*", re.ASCII | re.DOTALL)


Numbers = Mapping[str, int]


def without_arrays(source: Source) -> Source:
    """Return the same system with every element written out; itself if it has no arrays."""
    numbers = _sizes(source)
    tables = {key: value for key, value in source.tables.items() if key != "sizes"}
    places = dict(source.places or {})
    for name in TABLES:
        table = tables.get(name)
        if isinstance(table, Mapping):
            tables[name] = _table(source, name, table, numbers, places)
    forcing = tables.get("forcing")
    if isinstance(forcing, Mapping):
        tables["forcing"] = {
            key: _value(source, ("forcing", key), value, numbers, ())
            for key, value in forcing.items()
        }
    return replace(source, tables=tables, places=places if source.places is not None else None)


def _sizes(source: Source) -> dict[str, int]:
    given = source.tables.get("sizes", {})
    if not isinstance(given, Mapping):
        raise source.error(("sizes",), f"sizes is {type_name(given)}; write a table [sizes]")
    for name, value in given.items():
        path = ("sizes", str(name))
        if not str(name).isidentifier():
            raise source.error(path, f"{str(name)[:60]!r} is not the name of a size; give letters")
        if isinstance(value, bool) or not isinstance(value, int):
            raise source.error(path, f"{name} is {type_name(value)}; give a whole number, e.g. 50")
        if not 0 <= value <= LARGEST_INDEX:
            raise source.error(path, f"{name} = {value}; give a size from 0 to {LARGEST_INDEX}")
        taken = _holders(source, str(name), TABLES)
        if taken:
            raise source.error(path, f"{name} is in [sizes] and [{taken[0]}]; rename one")
    return {str(name): int(value) for name, value in given.items()}


def _table(
    source: Source, name: str, table: Mapping[str, Any], numbers: Numbers, places: dict[Keys, Any]
) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in table.items():
        path = (name, key)
        match = _KEY.fullmatch(str(key))
        if match is None:
            found[key] = _value(source, path, value, numbers, ())
            continue
        for element in _elements(source, path, match, numbers):
            whole = element_name(match[1], element.indices)
            if whole in found:
                raise source.error(
                    path, f"{whole} is given twice; leave one of the entries out", key=True
                )
            if len(found) > MOST_ENTRIES:
                raise source.error((name,), f"[{name}] has more than {MOST_ENTRIES} entries")
            chosen = _value(source, path, value, element.numbers, element.picks)
            found[whole] = _labeled(name, match[1], element.indices, chosen)
            _note_places(places, path, (name, whole))
    return found


class _Element(NamedTuple):
    """One element of an array that is being written out."""

    indices: tuple[int, ...]
    numbers: Numbers
    """What stands for the names of indices and sizes."""
    picks: tuple[tuple[int, int], ...]
    """Position in each range, and how long that is."""


def _elements(
    source: Source, path: Keys, match: re.Match[str], numbers: Numbers
) -> Iterator[_Element]:
    """Yield the elements that a key means; a range may depend on the indices before it."""
    try:
        yield from _continued(source, path, match[2].split(","), _Element((), numbers, ()))
    except FormulaError as error:
        raise source.error(path, f"{path[1][:60]}: {error.message}", key=True) from None


def _continued(
    source: Source, path: Keys, parts: Sequence[str], begun: _Element
) -> Iterator[_Element]:
    if not parts:
        yield begun
        return
    first, *rest = parts
    given = index_range(first, begun.numbers)
    if given is None:
        number = whole_number(first, begun.numbers)
        element = begun._replace(indices=(*begun.indices, number))
        yield from _continued(source, path, rest, element)
        return
    name, values = given
    _check_index(source, path, name)
    for position, number in enumerate(values):
        element = _Element(
            (*begun.indices, number),
            {**begun.numbers, name: number},
            (*begun.picks, (position, len(values))),
        )
        yield from _continued(source, path, rest, element)


def _check_index(source: Source, path: Keys, name: str) -> None:
    for table in _holders(source, name, (*TABLES, "sizes")):
        raise source.error(
            path, f"{name} is an index here and stands in [{table}]; rename one", key=True
        )


def _holders(source: Source, name: str, tables: Sequence[str]) -> list[str]:
    """Return the tables that have an entry of this name."""
    given = {table: source.tables.get(table) for table in tables}
    return [key for key, table in given.items() if isinstance(table, Mapping) and name in table]


def _value(
    source: Source, path: Keys, value: Any, numbers: Numbers, picks: tuple[tuple[int, int], ...]
) -> Any:
    """Return what an entry is for one element."""
    if isinstance(value, Mapping):
        return {
            key: _value(source, (*path, str(key)), item, numbers, picks)
            for key, item in value.items()
        }
    if isinstance(value, list | tuple) and path[0] == "contacts":
        return [
            _value(source, (*path, str(i)), item, numbers, picks) for i, item in enumerate(value)
        ]
    if isinstance(value, list | tuple) and picks:
        return _picked(source, path, value, numbers, picks)
    if not isinstance(value, str):
        return value
    of_contact = path[0] == "contacts" and path[-1] != "law"
    short = len(path) == 2 and path[0] not in (*PLAIN, "forcing")
    if path[-1] in FORMULA_KEYS or of_contact or short:
        try:
            return written_out(value, numbers)
        except FormulaError as error:
            raise source.formula_error(path, value, error) from None
    for name, number in numbers.items():
        # In TeX the braces stay: they keep an index of two digits together.
        shown = f"{{{number}}}" if path[-1] in LABEL.values() else str(number)
        value = value.replace(f"{{{name}}}", shown)
    return value


def _picked(
    source: Source,
    path: Keys,
    value: list[Any] | tuple[Any, ...],
    numbers: Numbers,
    picks: tuple[tuple[int, int], ...],
) -> Any:
    """Return the item of an array that belongs to an element."""
    (position, count), *rest = picks
    if len(value) != count:
        raise source.error(
            path, f"{path[-1][:60]} has {len(value)} items for {count} elements; give one for each"
        )
    return _value(source, path, value[position], numbers, tuple(rest))


def _labeled(table: str, base: str, indices: tuple[int, ...], value: Any) -> Any:
    """Give an element the label ``$x_{12}$`` if it has none; names of several letters stay."""
    key = LABEL.get(table)
    if key is None or len(base) > 1:
        return value
    short = {"parameters": "value", "states": "rate", "outputs": "formula"}[table]
    entries = dict(value) if isinstance(value, Mapping) else {short: value}
    entries.setdefault(key, f"${base}_{{{','.join(map(str, indices))}}}$")
    return entries


def _note_places(places: dict[Keys, Any], written: Keys, element: Keys) -> None:
    """Let messages about an element point at the entry that it comes from."""
    if written in places:
        places[element] = places[written]
        for key in FORMULA_KEYS:
            if (*written, key) in places:
                places[(*element, key)] = places[(*written, key)]
