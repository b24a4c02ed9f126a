"""What a formula amounts to: a symbolic expression, or a float."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

import heyoka as hy

from slipfold.models.formulas.bounded import without_overflow
from slipfold.models.formulas.functions import FUNCTIONS
from slipfold.models.formulas.tree import Binary, Call, Name, Negative, Number, Tree, fold
from slipfold.models.formulas.whole_power import whole_power
from slipfold.models.output import Expression

LARGEST_POWER = 1000
"""Whole exponents up to this one are written out as products; no formula needs larger ones."""

_ARITHMETIC: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
}


def value_of(tree: Tree, names: Mapping[str, Expression]) -> Expression:
    """Put values in the place of the names.

    >>> from slipfold.models.formulas.grammar import parse_formula
    >>> value_of(parse_formula("-q^2/4"), {"q": 6.0})
    -9.0
    """

    def combine(node: Tree, values: tuple[Expression, ...]) -> Expression:
        if isinstance(node, Number):
            return node.value
        if isinstance(node, Name):
            return names[node.name]
        if isinstance(node, Negative):
            return -values[0]
        if isinstance(node, Binary):
            return _combined(node.operator, *values)
        return _called(node, values)

    return fold(fold(tree, without_overflow), combine)


def _combined(sign: str, left: Expression, right: Expression) -> Expression:
    action = _power if sign == "^" else _ARITHMETIC[sign]
    try:
        return action(left, right)
    except (ArithmeticError, ValueError):
        return math.nan


def _power(base: Expression, exponent: Expression) -> Expression:
    if isinstance(exponent, hy.expression):
        # heyoka has the power of a symbol or number, but no number to the power of a symbol.
        return as_symbol(base) ** exponent
    if not isinstance(base, hy.expression):
        return math.pow(base, exponent)
    if exponent.is_integer() and abs(exponent) <= LARGEST_POWER:
        # The series of a power divides by its base, those of products work at zero as well.
        product = whole_power(base, abs(int(exponent)))
        return product if exponent >= 0 else 1.0 / product
    return base**exponent


def _called(node: Call, values: tuple[Expression, ...]) -> Expression:
    function = FUNCTIONS[node.function]
    if any(isinstance(value, hy.expression) for value in values):
        return function.symbolic(*(as_symbol(value) for value in values))
    try:
        return function.numeric(*values)
    except (ArithmeticError, ValueError):
        return math.nan


def as_symbol(value: Expression) -> Expression:
    """Return a symbolic expression: the value itself, or a constant if it is a float.

    >>> as_symbol(2.0)
    2.0000000000000000
    """
    return value if isinstance(value, hy.expression) else hy.expression(float(value))
