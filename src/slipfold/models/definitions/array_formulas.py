"""Formulas with indices, such as ``x[i+1]`` and ``sum(j=1:n, x[j])``, written out."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import pairwise

from slipfold.models.formulas.grammar import parse_formula
from slipfold.models.formulas.tokens import LONGEST_FORMULA, FormulaError
from slipfold.models.formulas.tree import Binary, Name, Negative, Number, Tree, fold, format_tree

LARGEST_INDEX = 100_000
"""A number beyond is a slip of the pen; tables hold a thousand entries."""

MOST_TERMS = 1000
"""Terms of a sum."""

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
            f"{format_tree(node)[:40]} is no index; give whole numbers with + - * and the names of "
            f"indices and sizes, known here: {known}",
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
    if last - first >= MOST_TERMS:
        raise FormulaError(
            f"{match[1]} takes {last - first + 1} values, more than {MOST_TERMS}", offset, len(text)
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
