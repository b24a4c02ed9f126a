"""Entries for many elements at once, such as ``"x[i=1:50]"``, written out one by one."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from slipfold.models.definitions.array_formulas import (
    LARGEST_INDEX,
    element_name,
    index_range,
    whole_number,
    written_out,
)
from slipfold.models.definitions.source import Source
from slipfold.models.definitions.toml_entries import type_name
from slipfold.models.definitions.toml_places import Path
from slipfold.models.formulas.tokens import FormulaError

FORMULA_KEYS = ("rate", "formula", "output", "period", "slip", "normal")
"""Entries that are formulas or names in them; `formulas` and short forms of others are as well."""

PLAIN = ("parameters",)
"""Tables whose texts are no formulas but numbers with a unit."""

TABLES = ("parameters", "formulas", "states", "contacts", "outputs", "limits", "events")

LABEL = {"parameters": "symbol", "states": "label", "outputs": "label"}
"""How figures write an element: with its index below."""

_KEY = re.compile(r"\s*([A-Za-z_]\w*)\s*\[(.*)\]\s*", re.ASCII | re.DOTALL)

MOST = 1000
"""Entries of a table when written out."""

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
            raise source.error(path, f"{str(name)[:60]!r} is no name of a size; give letters")
        if isinstance(value, bool) or not isinstance(value, int):
            raise source.error(path, f"{name} is {type_name(value)}; give a whole number, e.g. 50")
        if not 0 <= value <= LARGEST_INDEX:
            raise source.error(path, f"{name} = {value}; give a size from 0 to {LARGEST_INDEX}")
        taken = _holders(source, str(name), TABLES)
        if taken:
            raise source.error(path, f"{name} is in [sizes] and [{taken[0]}]; rename one")
    return {str(name): int(value) for name, value in given.items()}


def _table(
    source: Source, name: str, table: Mapping[str, Any], numbers: Numbers, places: dict[Path, Any]
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
            if len(found) > MOST:
                raise source.error((name,), f"[{name}] has more than {MOST} entries")
            chosen = _value(source, path, value, element.numbers, element.picks)
            found[whole] = _labelled(name, match[1], element.indices, chosen)
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
    source: Source, path: Path, match: re.Match[str], numbers: Numbers
) -> Iterator[_Element]:
    """Yield the elements that a key means; a range may depend on the indices before it."""
    try:
        yield from _continued(source, path, match[2].split(","), _Element((), numbers, ()))
    except FormulaError as error:
        raise source.error(path, f"{path[1][:60]}: {error.message}", key=True) from None


def _continued(
    source: Source, path: Path, parts: Sequence[str], begun: _Element
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


def _check_index(source: Source, path: Path, name: str) -> None:
    for table in _holders(source, name, (*TABLES, "sizes")):
        raise source.error(
            path, f"{name} is an index here and stands in [{table}]; rename one", key=True
        )


def _holders(source: Source, name: str, tables: Sequence[str]) -> list[str]:
    """Return the tables that have an entry of this name."""
    given = {table: source.tables.get(table) for table in tables}
    return [key for key, table in given.items() if isinstance(table, Mapping) and name in table]


def _value(
    source: Source, path: Path, value: Any, numbers: Numbers, picks: tuple[tuple[int, int], ...]
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
    path: Path,
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


def _labelled(table: str, base: str, indices: tuple[int, ...], value: Any) -> Any:
    """Give an element the label ``$x_{12}$`` if it has none; names of several letters stay."""
    key = LABEL.get(table)
    if key is None or len(base) > 1:
        return value
    short = {"parameters": "value", "states": "rate", "outputs": "formula"}[table]
    entries = dict(value) if isinstance(value, Mapping) else {short: value}
    entries.setdefault(key, f"${base}_{{{','.join(map(str, indices))}}}$")
    return entries


def _note_places(places: dict[Path, Any], written: Path, element: Path) -> None:
    """Let messages about an element point at the entry that it comes from."""
    if written in places:
        places[element] = places[written]
        for key in FORMULA_KEYS:
            if (*written, key) in places:
                places[(*element, key)] = places[(*written, key)]
