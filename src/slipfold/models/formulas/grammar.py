"""The grammar of formulas: text becomes a tree, or a message about a position in the text.

Nothing is evaluated. The parser is not Python's: ``lambda`` may name a parameter, sums may have
thousands of terms, and each message says what to write. From the loosest to the tightest binding::

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
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeVar

from slipfold.models.formulas.functions import FUNCTIONS, explain_unknown_function


class BOUNDS:
    """How large texts of models may be: larger ones are accidents, or take minutes to compile."""

    file: int = 300_000  # characters of a file
    entries: int = 1000  # entries of a table, elements of an array or terms of a sum
    formula: int = 10_000  # characters of a formula
    depth: int = 60  # nested parentheses, signs and powers; formulas have fewer than ten
    power: int = 1000  # whole exponent, up to which powers are products
    index: int = 100_000  # index of an element
    rows: int = 1_000_000  # rows of a matrix: more do not fit into memory with their modes


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

_MEANT = "formulas have numbers, names of ASCII letters, + - * / ^ and parentheses"


class FormulaError(Exception):
    """An error in a formula, in `length` characters of its text from `position`.

    `Source.error` adds the position in the file.
    """

    def __init__(self, message: str, position: int, length: int = 1) -> None:
        super().__init__(message)
        self.message = message
        self.position = position
        self.length = length


class Token(NamedTuple):
    """A word of a formula."""

    kind: str  # ``"number"``, ``"name"``, ``"sign"`` or, after the last one, ``"end"``
    text: str  # as written
    position: int  # where it begins


def split_formula(text: str) -> list[Token]:
    """Split a formula into its words."""
    if len(text) > BOUNDS.formula:
        raise FormulaError(
            f"the formula has {len(text)} characters, more than {BOUNDS.formula}; split it "
            "over the table [formulas]",
            0,
        )
    tokens: list[Token] = []
    position = 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            raise FormulaError(
                f"the character {text[position]!r} has no meaning in a formula; "
                + _HINTS.get(text[position], _MEANT),
                position,
            )
        kind, word = str(match.lastgroup), match.group()
        if word == "**":
            raise FormulaError(
                "powers are written with ^, not with **; write e.g. q^3", position, 2
            )
        if kind == "number" and not math.isfinite(float(word)):
            raise FormulaError(
                f"the number {word[:20]} is larger than the largest, 1.8e308; give a smaller one",
                position,
                len(word),
            )
        if kind != "space":
            tokens.append(Token(kind, word, position))
        position = match.end()
    return [*tokens, Token("end", "", len(text.rstrip()))]


T = TypeVar("T")

SUM, PRODUCT, SIGN, POWER, ATOM = range(1, 6)
"""How tightly each kind of node binds; the parser and the writer must agree."""

BINDING = {"+": SUM, "-": SUM, "*": PRODUCT, "/": PRODUCT, "^": POWER}


def _position() -> Any:
    """Return the field for the position of a node in the text, which comparisons ignore."""
    return field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Number:
    """A finite number in the formula."""

    value: float


@dataclass(frozen=True, slots=True)
class Name:
    """A state, parameter, formula, constant or the time."""

    name: str
    position: int = _position()


@dataclass(frozen=True, slots=True)
class Negative:
    """The argument with its sign changed."""

    argument: Tree


@dataclass(frozen=True, slots=True)
class Binary:
    """Two operands and the operator between them, one of ``+ - * / ^``."""

    operator: str
    left: Tree
    right: Tree
    position: int = _position()


@dataclass(frozen=True, slots=True)
class Call:
    """A function of as many arguments as it takes."""

    function: str
    arguments: tuple[Tree, ...]
    position: int = _position()


Tree = Number | Name | Negative | Binary | Call


def fold(tree: Tree, combine: Callable[[Tree, tuple[T, ...]], T]) -> T:
    """Combine the values of all nodes, from the leaves to the root.

    An explicit stack replaces recursion: trees of long sums are thousands of levels deep.
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


def with_children(node: Tree, children: tuple[Tree, ...]) -> Tree:
    """Return a node with other children."""
    if isinstance(node, Binary):
        left, right = children
        return replace(node, left=left, right=right)
    if isinstance(node, Negative):
        return Negative(*children)
    return replace(node, arguments=children) if isinstance(node, Call) else node


def _children(node: Tree) -> tuple[Tree, ...]:
    if isinstance(node, Binary):
        return node.left, node.right
    if isinstance(node, Negative):
        return (node.argument,)
    return node.arguments if isinstance(node, Call) else ()


def names_in(tree: Tree) -> dict[str, int]:
    """Return the names that a formula uses, each with its first position."""
    found: dict[str, int] = {}

    def note(node: Tree, values: tuple[None, ...]) -> None:
        if isinstance(node, Name):
            found.setdefault(node.name, node.position)

    fold(tree, note)
    return found


def format_tree(tree: Tree) -> str:
    """Write a tree as a formula with the minimum of parentheses."""
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
    minima = (own + 1, SIGN) if node.operator == "^" else (own, own + 1)
    left, right = (_enclosed(part, need) for part, need in zip(parts, minima, strict=True))
    space = " " if own == SUM else ""
    return f"{left}{space}{node.operator}{space}{right}", own


def _enclosed(part: tuple[str, int], minimum: int) -> str:
    text, binding = part
    return text if binding >= minimum else f"({text})"


def parse_formula(text: str) -> Tree:
    """Read a formula."""
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
        # After the last token there is nothing to take.
        self._index = min(self._index + 1, len(self._tokens) - 1)
        return token

    def formula(self, minimum: int) -> Tree:
        """Read operands and the operators that bind at least as tightly as `minimum`."""
        self._depth += 1
        if self._depth > BOUNDS.depth:
            raise FormulaError(
                f"the formula is nested more than {BOUNDS.depth} deep here; name parts of it in "
                "the table [formulas]",
                self.next.position,
            )
        tree = self._operand()
        while (binding := BINDING.get(self.next.text, 0)) >= max(minimum, 1):
            sign = self._take()
            # An equal operator to the right belongs to the right operand only for powers.
            right = self.formula(binding if sign.text == "^" else binding + 1)
            tree = Binary(sign.text, tree, right, sign.position)
        self._depth -= 1
        return tree

    def _operand(self) -> Tree:
        token = self._take()
        if token.kind == "number":
            return Number(float(token.text))
        if token.kind == "name":
            return self._call(token) if self.next.text == "(" else Name(token.text, token.position)
        if token.text == "-":
            return Negative(self.formula(SIGN))
        if token.text == "+":
            return self.formula(SIGN)
        if token.text == "(":
            tree = self.formula(0)
            self._close(token)
            return tree
        found = "the formula ends" if token.kind == "end" else f"{token.text!r} stands"
        raise FormulaError(
            f"{found} where a number, a name or a parenthesis should; complete the formula",
            token.position,
            max(len(token.text), 1),
        )

    def _call(self, name: Token) -> Call:
        opening = self._take()
        arguments = [] if self.next.text == ")" else [self.formula(0)]
        while arguments and self.next.text == ",":
            self._take()
            arguments.append(self.formula(0))
        self._close(opening)
        if name.text not in FUNCTIONS:
            raise FormulaError(_unknown(name.text, arguments), name.position, len(name.text))
        count = FUNCTIONS[name.text].count
        if len(arguments) != count:
            wanted = "1 argument" if count == 1 else f"{count} arguments"
            form = "(y, x)" if count == 2 else "(x)"
            raise FormulaError(
                f"{name.text} takes {wanted}, not {len(arguments)}; write {name.text}{form}",
                name.position,
                len(name.text),
            )
        return Call(name.text, tuple(arguments), name.position)

    def _close(self, opening: Token) -> None:
        if self.next.kind == "end":
            raise FormulaError(
                "this parenthesis is never closed; add a ) where it ends", opening.position
            )
        if self.next.text != ")":
            raise self.unexpected()
        self._take()

    def unexpected(self) -> FormulaError:
        """Return the error about a token that cannot follow an operand."""
        token, before = self.next, self._tokens[self._index - 1].text[-20:]
        text = token.text[:20]
        messages = {
            ")": "this parenthesis was never opened; leave it out or add a ( before",
            ",": "a comma stands between arguments of a function only; numbers have a point, e.g. "
            "0.5",
        }
        message = messages.get(
            token.text,
            f"there is no operator between {before} and {text}; for a product write "
            f"{before}*{text}",
        )
        return FormulaError(message, token.position, len(token.text))


def _unknown(name: str, arguments: list[Tree]) -> str:
    """Return the message about an unknown function, which may be a state at another time."""
    time = arguments[0] if len(arguments) == 1 else None
    if isinstance(time, Binary) and time.operator == "-" and time.left == Name("t"):
        return f"{name}({format_tree(time)}) is a state at another time; delays are not supported"
    message = explain_unknown_function(name)
    if isinstance(time, Number):
        message += (
            f"; if {name} is a state, its value at one time belongs to a boundary-value problem, "
            "and these are not supported"
        )
    return message
