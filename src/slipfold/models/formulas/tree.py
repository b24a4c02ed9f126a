"""A formula as an immutable tree: numbers, names, signs, operators and calls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

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
