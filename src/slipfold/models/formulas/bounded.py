"""Formulas rewritten so that nothing overflows on the way to a value that is finite.

Where exp(x) or cosh(x) is infinite, so is what divides by it in a Taylor series, and their product
with zero is no number. 1/(b + exp(x)) and even powers of 1/cosh(x) are products of sigmoids.
"""

from __future__ import annotations

import math
from dataclasses import replace

from slipfold.models.formulas.tree import Binary, Call, Negative, Number, Tree


def without_overflow(node: Tree, parts: tuple[Tree, ...]) -> Tree:
    """Rewrite a node whose children are.

    >>> from slipfold.models.formulas.grammar import parse_formula
    >>> from slipfold.models.formulas.tree import fold, format_tree
    >>> format_tree(fold(parse_formula("exp(v)/(1 + exp(v)) + sinh(v)/cosh(v)"), without_overflow))
    'sigmoid(v) + tanh(v)'
    """
    if isinstance(node, Negative):
        return Negative(*parts)
    if isinstance(node, Call):
        return replace(node, arguments=parts)
    if not isinstance(node, Binary):
        return node
    left, right = parts
    found = None
    if node.operator == "/":
        found = _quotient(left, right)
    elif node.operator == "^" and isinstance(right, Negative):
        found = _reciprocal(Binary("^", left, right.argument))
    return found or replace(node, left=left, right=right)


def _quotient(left: Tree, right: Tree) -> Tree | None:
    match left, right:
        case Call("sinh", x), Call("cosh", y) if x == y:
            return Call("tanh", x)
        case Call("exp", (x,)), _ if (found := _offset(right)) is not None and found[1] == x:
            b = found[0]
            return Call("sigmoid", (x if b == 1 else Binary("-", x, Number(math.log(b))),))
    inverse = _reciprocal(right)
    return inverse and Binary("*", left, inverse)


def _reciprocal(tree: Tree) -> Tree | None:
    """One over a tree in what is bounded; None if there is no need or no such form."""
    match tree:
        case Binary("^", Call("cosh", (x,)), Number(n)) if n > 0 and n % 2 == 0:
            double = Binary("*", Number(2.0), x)
            shares = (Call("sigmoid", (double,)), Call("sigmoid", (Negative(double),)))
            square = Binary("*", Number(4.0), Binary("*", *shares))
            return Binary("^", square, Number(n / 2))
        case Binary("*", left, right):
            inverses = _reciprocal(left), _reciprocal(right)
            if inverses == (None, None):
                return None
            one = Number(1.0)
            first, second = (
                inverse or Binary("/", one, factor)
                for inverse, factor in zip(inverses, (left, right), strict=True)
            )
            return Binary("*", first, second)
    offset = _offset(tree)
    if offset is None:
        return None
    b, x = offset
    below = Negative(x) if b == 1 else Binary("-", Number(math.log(b)), x)
    return Binary("*", Binary("/", Number(1.0), Number(b)), Call("sigmoid", (below,)))


def _offset(tree: Tree) -> tuple[float, Tree] | None:
    """The number b > 0 and the argument of ``b + exp(x)``."""
    match tree:
        case Binary("+", Number(b), Call("exp", (x,))) if b > 0:
            return b, x
        case Binary("+", Call("exp", (x,)), Number(b)) if b > 0:
            return b, x
    return None
