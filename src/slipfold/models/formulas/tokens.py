"""The words of a formula: numbers, names, operators and parentheses, each with its place."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

LONGEST_FORMULA = 10_000
"""Characters of the longest formula: twenty pages of text are no formula but an accident."""

_TOKEN = re.compile(
    r"(?P<space>\s+)"
    r"|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
    r"|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<sign>\*\*|[-+*/^(),])",
    re.ASCII,
)

_HINTS = {
    "=": "a formula gives a value and sets none: leave out the equals sign",
    "[": "write parentheses ( )",
    "]": "write parentheses ( )",
    "{": "write parentheses ( )",
    "}": "write parentheses ( )",
    "−": "write - for minus",
    "–": "write - for minus",
    "·": "write * for a product",
    "×": "write * for a product",
    "÷": "write / for a quotient",
    "²": "write ^2 for a square",
    "³": "write ^3 for a cube",
    ".": "names have no points, and a number needs a digit, e.g. 0.5",
    ";": "a formula is one expression; leave the semicolon out",
    "<": "there are no comparisons: rates must be smooth",
    ">": "there are no comparisons: rates must be smooth",
    "'": "for the derivative of a state write the name of its rate",
}


class FormulaError(Exception):
    """What is wrong with a formula, and where; `Source.error` makes a sentence for users of it.

    It begins at `place` in the text of the formula and concerns `length` characters.
    """

    def __init__(self, message: str, place: int, length: int = 1) -> None:
        super().__init__(message)
        self.message = message
        self.place = place
        self.length = length


@dataclass(frozen=True, slots=True)
class Token:
    """A word of a formula."""

    kind: str  # ``"number"``, ``"name"``, ``"sign"`` or, behind the last one, ``"end"``
    text: str  # as written
    place: int  # where it begins


def split_formula(text: str) -> list[Token]:
    """Split a formula into its words.

    >>> [token.text for token in split_formula("F*cos(W*t)")]
    ['F', '*', 'cos', '(', 'W', '*', 't', ')', '']
    """
    if len(text) > LONGEST_FORMULA:
        raise FormulaError(
            f"the formula has {len(text)} characters, more than {LONGEST_FORMULA}; split it "
            "over the table [formulas]",
            0,
        )
    tokens: list[Token] = []
    place = 0
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None:
            raise _unknown_character(text[place], place)
        token = Token(str(match.lastgroup), match.group(), place)
        _check(token)
        if token.kind != "space":
            tokens.append(token)
        place = match.end()
    return [*tokens, Token("end", "", len(text.rstrip()))]


def _check(token: Token) -> None:
    if token.text == "**":
        raise FormulaError("powers are written with ^, not with **; write e.g. q^3", token.place, 2)
    if token.kind == "number" and not math.isfinite(float(token.text)):
        raise FormulaError(
            f"the number {token.text[:20]} is larger than the largest, 1.8e308; give a smaller one",
            token.place,
            len(token.text),
        )


def _unknown_character(character: str, place: int) -> FormulaError:
    hint = _HINTS.get(
        character, "formulas have numbers, names of ASCII letters, + - * / ^ and parentheses"
    )
    return FormulaError(f"the character {character!r} has no meaning in a formula; {hint}", place)
