"""Entries and formulas with indices, such as ``"x[i=1:50]"``, written out one by one."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Annotated, Any, NamedTuple

from pydantic import Field, StrictInt, TypeAdapter

from slipfold.models.definitions.source import Keys, Source
from slipfold.models.definitions.tables import validate
from slipfold.models.formulas.grammar import (
    BOUNDS,
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

Numbers = Mapping[str, int]
"""Values of indices and sizes by name."""

_ITEM = re.compile(
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
    r"|(?P<sum>sum\s*\((?=\s*[A-Za-z_]\w*\s*=))"
    r"|(?P<element>[A-Za-z_]\w*)\s*\["
    r"|(?P<name>[A-Za-z_]\w*)",
    re.ASCII,
)
_RANGE = re.compile(r"\s*([A-Za-z_]\w*)\s*=([^:]*):([^:]*)", re.ASCII | re.DOTALL)
_KEY = re.compile(r"\s*([A-Za-z_]\w*)\s*\[(.*)\]\s*", re.ASCII | re.DOTALL)


def written_out(text: str, numbers: Numbers, offset: int = 0) -> str:
    """Return a formula with the names of elements, sums term by term, and numbers for indices.

    `offset` is the position of the text in the whole formula, for errors.

    >>> written_out("k*(x[i-1] - 2*x[i]) + i*sum(j=1:2, a[j]^2)", {"i": 3})
    'k*(x2 - 2*x3) + 3*(a1^2 + a2^2)'
    """
    parts, end, length = [], 0, 0
    while (match := _ITEM.search(text, end)) is not None:
        parts.append(text[end : match.start()])
        end = match.end()
        if match["sum"] or match["element"]:
            closing = _closing(text, end - 1, offset)
            inner, start = text[end:closing], offset + end
            if match["sum"]:
                parts.append(f"({_written_sum(inner, numbers, start)})")
            else:
                indices = [whole_number(*part) for part in _split(inner, numbers, start)]
                parts.append(element_name(match["element"], tuple(indices)))
            end = closing + 1
        else:
            parts.append(str(numbers.get(match[0], match[0])))
        length += len(parts[-2]) + len(parts[-1])
        if length > BOUNDS.formula:
            raise FormulaError(f"written out it has more than {BOUNDS.formula} characters", 0)
    return "".join(parts) + text[end:]


def _written_sum(text: str, numbers: Numbers, offset: int) -> str:
    """Write the terms of a sum: one range or more, then the term."""
    (first, _, position), *others = _split(text, numbers, offset)
    given = index_range(first, numbers, position)
    if given is None and re.match(r"\s*\w+\s*=", first) is None:
        return written_out(text, numbers, offset).strip()
    if given is None or not others:
        message = "a sum has a range and a term; write e.g. sum(i=1:3, x[i])"
        raise FormulaError(message, offset - 1)
    name, values = given
    after = others[0][2]
    term = text[after - offset :]
    terms, length = [], 0
    for value in values:
        terms.append(_written_sum(term, {**numbers, name: value}, after))
        length += len(terms[-1])
        if length > BOUNDS.formula:
            raise FormulaError(f"written out it has more than {BOUNDS.formula} characters", 0)
    return " + ".join(terms) or "0"


def _closing(text: str, opening: int, offset: int) -> int:
    """Return the position of the parenthesis or bracket that closes one."""
    pairs, wanted = {"(": ")", "[": "]"}, []
    for position in range(opening, len(text)):
        if text[position] in pairs:
            wanted.append(pairs[text[position]])
        elif text[position] == wanted[-1]:
            wanted.pop()
            if not wanted:
                return position
    sign = text[opening]
    message = f"this {sign} is never closed; add a {pairs[sign]} where it ends"
    raise FormulaError(message, offset + opening)


def _split(text: str, numbers: Numbers, offset: int) -> Iterator[tuple[str, Numbers, int]]:
    """Split at commas outside parentheses; yield text, numbers and position."""
    depth = start = 0
    for position, sign in enumerate(f"{text},"):
        depth += (sign in "([") - (sign in ")]")
        if sign == "," and depth == 0:
            yield text[start:position], numbers, offset + start
            start = position + 1


def element_name(base: str, indices: tuple[int, ...]) -> str:
    """Return the name of an element, e.g. ``x12`` of x[12] and ``u1_2`` of u[1, 2]."""
    between = "_" if base[-1].isdigit() else ""
    return base + between + "_".join(map(str, indices))


def whole_number(text: str, numbers: Numbers, offset: int = 0) -> int:
    """Return the value of an index: whole numbers, indices and sizes, + - * and parentheses."""

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
            getattr(node, "position", 0),
        )

    try:
        number = fold(parse_formula(text), combine)
    except FormulaError as error:
        raise FormulaError(error.message, error.position + offset, error.length) from None
    if not 0 <= number <= BOUNDS.index:
        raise FormulaError(
            f"the index {text.strip()[:40]} is {number}; give one from 0 to {BOUNDS.index}", offset
        )
    return number


def index_range(text: str, numbers: Numbers, offset: int = 0) -> tuple[str, range] | None:
    """Return name and values of ``i = first:last``; None if the text is not a range."""
    match = _RANGE.fullmatch(text)
    if match is None:
        return None
    first, last = (
        whole_number(match[part], numbers, offset + match.start(part)) for part in (2, 3)
    )
    if last - first >= BOUNDS.entries:
        raise FormulaError(
            f"{match[1]} takes {last - first + 1} values, more than {BOUNDS.entries}",
            offset,
            len(text),
        )
    return match[1], range(first, last + 1)


FORMULA_KEYS = ("rate", "formula", "output", "period", "slip", "normal")
"""Entries that are formulas or names in them; `formulas` and short forms of others are as well."""

TABLES = ("parameters", "formulas", "states", "contacts", "outputs", "limits", "events")

LABEL = {
    "parameters": ("symbol", "value"),
    "states": ("label", "rate"),
    "outputs": ("label", "formula"),
}
"""How figures write an element, with its index below; the entry that a value alone stands for."""

_SIZES: TypeAdapter[dict[str, int]] = TypeAdapter(
    dict[
        Annotated[str, Field(pattern=r"^[A-Za-z_]\w*$")],
        Annotated[StrictInt, Field(ge=0, le=BOUNDS.index)],
    ]
)


class _Element(NamedTuple):
    """One element of an array."""

    indices: tuple[int, ...]
    numbers: Numbers
    picks: tuple[tuple[int, int], ...] = ()
    """Position in each range, and how long that is."""


def without_arrays(source: Source) -> Source:
    """Return the same system with every element written out."""
    given = source.tables.get("sizes", {})
    read = partial(validate, _SIZES.validate_python)
    base = _Element((), source.read(read, given, ("sizes",)))
    for name in base.numbers:
        for table in _holders(source, name):
            message = f"{name} is in [sizes] and [{table}]; rename one"
            raise source.error(("sizes", name), message)
    tables = {key: value for key, value in source.tables.items() if key != "sizes"}
    locations = None if source.locations is None else dict(source.locations)
    for name in (name for name in TABLES if isinstance(tables.get(name), Mapping)):
        tables[name] = _table(source, name, base, locations)
    if isinstance(tables.get("forcing"), Mapping):
        tables["forcing"] = _value(source, ("forcing",), tables["forcing"], base)
    return replace(source, tables=tables, locations=locations)


def _holders(source: Source, name: str) -> list[str]:
    """Return the tables that have an entry of this name."""
    given = {table: source.tables.get(table) for table in TABLES}
    return [key for key, table in given.items() if isinstance(table, Mapping) and name in table]


def _table(
    source: Source, name: str, base: _Element, locations: dict[Keys, Any] | None
) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for key, value in source.tables[name].items():
        path = (name, key)
        match = _KEY.fullmatch(str(key))
        if match is None:
            result[key] = _value(source, path, value, base)
            continue
        try:
            elements = _elements(source, path, match[2].split(","), base)
        except FormulaError as error:
            raise source.error(path, f"{key[:60]}: {error.message}", key=True) from None
        for element in elements:
            single = element_name(match[1], element.indices)
            if single in result:
                message = f"{single} is given twice; leave one of the entries out"
                raise source.error(path, message, key=True)
            chosen = _value(source, path, value, element)
            result[single] = _labeled(name, match[1], element.indices, chosen)
            # Messages about an element point at the entry that it comes from.
            for part in ((), *((key,) for key in FORMULA_KEYS)):
                if locations is not None and (*path, *part) in locations:
                    locations[(name, single, *part)] = locations[(*path, *part)]
        if len(result) > BOUNDS.entries:
            raise source.error((name,), f"[{name}] has more than {BOUNDS.entries} entries")
    return result


def _elements(source: Source, path: Keys, parts: list[str], base: _Element) -> list[_Element]:
    """Return the elements of a key; a range may depend on the indices before it."""
    elements = [base]
    for part in parts:
        longer = []
        for indices, numbers, picks in elements:
            given = index_range(part, numbers)
            if given is None:
                longer.append(_Element((*indices, whole_number(part, numbers)), numbers, picks))
                continue
            name, values = given
            for table in ["sizes"] if name in base.numbers else _holders(source, name):
                message = f"{name} is an index here and stands in [{table}]; rename one"
                raise source.error(path, message, key=True)
            longer += [
                _Element(
                    (*indices, number), {**numbers, name: number}, (*picks, (position, len(values)))
                )
                for position, number in enumerate(values)
            ]
            if len(longer) > BOUNDS.entries:
                raise source.error(path[:1], f"[{path[0]}] has more than {BOUNDS.entries} entries")
        elements = longer
    return elements


def _value(source: Source, path: Keys, value: Any, element: _Element) -> Any:
    """Return the entry of one element."""
    if isinstance(value, Mapping):
        return {
            key: _value(source, (*path, str(key)), item, element) for key, item in value.items()
        }
    if isinstance(value, list | tuple) and path[0] == "contacts":
        return [_value(source, (*path, str(i)), item, element) for i, item in enumerate(value)]
    if isinstance(value, list | tuple) and element.picks:
        (position, count), *others = element.picks
        if len(value) != count:
            raise source.error(
                path,
                f"{path[-1][:60]} has {len(value)} items for {count} elements; give one for each",
            )
        return _value(source, path, value[position], element._replace(picks=tuple(others)))
    if not isinstance(value, str):
        return value
    of_contact = path[0] == "contacts" and path[-1] != "law"
    short = len(path) == 2 and path[0] not in ("parameters", "forcing")
    if path[-1] in FORMULA_KEYS or of_contact or short:
        try:
            return written_out(value, element.numbers)
        except FormulaError as error:
            raise source.formula_error(path, value, error) from None
    for name, number in element.numbers.items():
        # In TeX the braces stay: they keep an index of two digits together.
        shown = f"{{{number}}}" if path[-1] in ("symbol", "label") else str(number)
        value = value.replace(f"{{{name}}}", shown)
    return value


def _labeled(table: str, base: str, indices: tuple[int, ...], value: Any) -> Any:
    """Give an element the label ``$x_{12}$`` if it has none; names of several letters stay."""
    if table not in LABEL or len(base) > 1:
        return value
    key, sole = LABEL[table]
    entries = dict(value) if isinstance(value, Mapping) else {sole: value}
    entries.setdefault(key, f"${base}_{{{','.join(map(str, indices))}}}$")
    return entries
