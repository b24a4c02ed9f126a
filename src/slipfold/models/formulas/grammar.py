"""The grammar of formulas: text becomes a tree, or a message about a place in the text.

Nothing is evaluated. From the loosest to the tightest binding::

    formula  = formula ("+" | "-") formula        from the left
             | formula ("*" | "/") formula        from the left
             | ("-" | "+") formula                so that -q^2 is -(q^2)
             | formula "^" formula                from the right, and 2^-3 is 2^(-3)
             | number | name | name "(" formula ("," formula)* ")" | "(" formula ")"
    number   = 2, 2.5, .5, 1e-3
    name     = a letter or _, then letters, digits and _
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

from slipfold.models.formulas.functions import FUNCTIONS, explain_unknown_function

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


T = TypeVar("T")

SUM, PRODUCT, SIGN, POWER, ATOM = range(1, 6)
"""How tightly each kind of node binds; the parser and the writer must agree."""

BINDING = {"+": SUM, "-": SUM, "*": PRODUCT, "/": PRODUCT, "^": POWER}


@dataclass(frozen=True, slots=True)
class Number:
    """A number that stands in the formula."""

    value: float  # finite


@dataclass(frozen=True, slots=True)
class Name:
    """A state, parameter, formula, constant or the time."""

    name: str  # as written
    # Where it begins in the text; plays no part in comparisons
    place: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Negative:
    """The argument with its sign changed."""

    argument: Tree  # what stands behind the sign


@dataclass(frozen=True, slots=True)
class Binary:
    """Two operands and the operator between them."""

    operator: str  # one of ``+ - * / ^``
    # The operands
    left: Tree
    right: Tree
    # Where the operator stands in the text; plays no part in comparisons
    place: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Call:
    """A function of arguments."""

    function: str  # its name
    arguments: tuple[Tree, ...]  # as many as the function takes
    # Where the name begins in the text; plays no part in comparisons
    place: int = field(default=0, compare=False)


Tree = Number | Name | Negative | Binary | Call


def fold(tree: Tree, combine: Callable[[Tree, tuple[T, ...]], T]) -> T:
    """Combine the values of all nodes, from the leaves to the root.

    Works through a stack of its own: a sum of thousands of terms is a tree as deep as that, too
    deep for functions that call themselves.

    >>> fold(Binary("+", Name("q"), Number(1.0)), lambda node, values: 1 + sum(values))
    3
    """
    waiting: list[tuple[Tree, bool]] = [(tree, False)]
    values: list[T] = []
    while waiting:
        node, opened = waiting.pop()
        children = _children(node)
        if opened or not children:
            first = len(values) - len(children)
            found = tuple(values[first:])
            del values[first:]
            values.append(combine(node, found))
            continue
        waiting.append((node, True))
        waiting += [(child, False) for child in reversed(children)]
    return values[0]


def _children(node: Tree) -> tuple[Tree, ...]:
    if isinstance(node, Binary):
        return node.left, node.right
    if isinstance(node, Negative):
        return (node.argument,)
    return node.arguments if isinstance(node, Call) else ()


def names_in(tree: Tree) -> dict[str, int]:
    """Return the names that a formula uses, each with its first place.

    >>> names_in(Binary("+", Name("q", 0), Name("v", 4)))
    {'q': 0, 'v': 4}
    """
    found: dict[str, int] = {}

    def note(node: Tree, values: tuple[None, ...]) -> None:
        if isinstance(node, Name):
            found.setdefault(node.name, node.place)

    fold(tree, note)
    return found


def format_tree(tree: Tree) -> str:
    """Write a tree as a formula with as few parentheses as give the same tree again.

    >>> format_tree(Negative(Binary("^", Binary("+", Name("a"), Number(1.0)), Number(2.0))))
    '-(a + 1)^2'
    """
    return fold(tree, _written)[0]


def _written(node: Tree, parts: tuple[tuple[str, int], ...]) -> tuple[str, int]:
    """Text of a node and how tightly it binds."""
    if isinstance(node, Number):
        whole = node.value.is_integer() and abs(node.value) < 1e15
        text = str(int(node.value)) if whole else repr(node.value)
        return text, SIGN if text.startswith("-") else ATOM
    if isinstance(node, Name):
        return node.name, ATOM
    if isinstance(node, Call):
        return f"{node.function}({', '.join(text for text, _ in parts)})", ATOM
    if isinstance(node, Negative):
        return f"-{_enclosed(parts[0], SIGN)}", SIGN
    own = BINDING[node.operator]
    # Powers are read from the right, everything else from the left; an exponent may have a sign.
    least = (own + 1, SIGN) if node.operator == "^" else (own, own + 1)
    left, right = (_enclosed(part, need) for part, need in zip(parts, least, strict=True))
    space = " " if own == SUM else ""
    return f"{left}{space}{node.operator}{space}{right}", own


def _enclosed(part: tuple[str, int], least: int) -> str:
    text, binding = part
    return text if binding >= least else f"({text})"


DEEPEST = 60
"""Nested parentheses, signs and powers: what people write stays below ten."""


def parse_formula(text: str) -> Tree:
    """Read a formula.

    >>> from slipfold.models.formulas.grammar import format_tree
    >>> format_tree(parse_formula("-(q)^2 + 2 * (a*b)"))
    '-q^2 + 2*(a*b)'
    """
    parser = _Parser(split_formula(text))
    if parser.next.kind == "end":
        raise FormulaError("the formula is empty; give at least a number, e.g. 0", 0)
    tree = parser.formula(0)
    if parser.next.kind != "end":
        raise parser.unexpected()
    return tree


class _Parser:
    """Operator precedence parsing (Pratt): one function for all binary operators."""

    def __init__(self, tokens: list[Token]) -> None:
        self._tokens = tokens
        self._index = 0
        self._depth = 0

    @property
    def next(self) -> Token:
        return self._tokens[self._index]

    def _take(self) -> Token:
        token = self.next
        # Behind the last token there is nothing to take.
        self._index = min(self._index + 1, len(self._tokens) - 1)
        return token

    def formula(self, least: int) -> Tree:
        """Read operands and the operators that bind at least as tightly as `least`."""
        self._depth += 1
        if self._depth > DEEPEST:
            raise FormulaError(
                f"the formula is nested more than {DEEPEST} deep here; name parts of it in the "
                "table [formulas]",
                self.next.place,
            )
        tree = self._operand()
        while (binding := self._operator()) >= max(least, 1):
            sign = self._take()
            # An equal operator to the right belongs to the right operand only for powers.
            right = self.formula(binding if sign.text == "^" else binding + 1)
            tree = Binary(sign.text, tree, right, sign.place)
        self._depth -= 1
        return tree

    def _operator(self) -> int:
        return BINDING.get(self.next.text, 0) if self.next.kind == "sign" else 0

    def _operand(self) -> Tree:
        token = self._take()
        if token.kind == "number":
            return Number(float(token.text))
        if token.kind == "name":
            follows = self.next.kind == "sign" and self.next.text == "("
            return self._call(token) if follows else Name(token.text, token.place)
        if token.text == "-":
            return Negative(self.formula(SIGN))
        if token.text == "+":
            return self.formula(SIGN)
        if token.text == "(":
            tree = self.formula(0)
            self._close(token)
            return tree
        raise self._missing_operand(token)

    def _call(self, name: Token) -> Call:
        opening = self._take()
        arguments = []
        if self.next.text != ")":
            arguments.append(self.formula(0))
            while self.next.text == ",":
                self._take()
                arguments.append(self.formula(0))
        self._close(opening)
        if name.text not in FUNCTIONS:
            raise FormulaError(_unknown(name.text, arguments), name.place, len(name.text))
        count = FUNCTIONS[name.text].count
        if len(arguments) != count:
            wanted = "1 argument" if count == 1 else f"{count} arguments"
            form = "(y, x)" if count == 2 else "(x)"
            raise FormulaError(
                f"{name.text} takes {wanted}, not {len(arguments)}; write {name.text}{form}",
                name.place,
                len(name.text),
            )
        return Call(name.text, tuple(arguments), name.place)

    def _close(self, opening: Token) -> None:
        if self.next.text == ")":
            self._take()
        elif self.next.kind == "end":
            raise FormulaError(
                "this parenthesis is never closed; add a ) where it ends", opening.place
            )
        else:
            raise self.unexpected()

    def unexpected(self) -> FormulaError:
        """What to say about a token that cannot follow an operand."""
        token = self.next
        if token.text == ")":
            return FormulaError(
                "this parenthesis was never opened; leave it out or add a ( before", token.place
            )
        if token.text == ",":
            return FormulaError(
                "a comma stands between arguments of a function only; numbers have a point, e.g. "
                "0.5",
                token.place,
            )
        before = self._tokens[self._index - 1].text
        return FormulaError(
            f"there is no operator between {before[-20:]} and {token.text[:20]}; for a product "
            f"write {before[-20:]}*{token.text[:20]}",
            token.place,
            len(token.text),
        )

    def _missing_operand(self, token: Token) -> FormulaError:
        found = "the formula ends" if token.kind == "end" else f"{token.text!r} stands"
        return FormulaError(
            f"{found} where a number, a name or a parenthesis should; complete the formula",
            token.place,
            max(len(token.text), 1),
        )


def _unknown(name: str, arguments: list[Tree]) -> str:
    """Return the sentence about a function that there is not, as if a state is taken at a time."""
    time = arguments[0] if len(arguments) == 1 else None
    if isinstance(time, Binary) and time.operator == "-" and time.left == Name("t"):
        return f"{name}({format_tree(time)}) is a state at another time; delays are not supported"
    if isinstance(time, Number):
        return (
            f"{explain_unknown_function(name)}; if {name} is a state, its value at one time "
            "belongs to a boundary-value problem, and these are not supported"
        )
    return explain_unknown_function(name)
