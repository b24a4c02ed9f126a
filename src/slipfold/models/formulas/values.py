"""The value of a formula: a symbolic expression, or a float.

Where exp(x) or cosh(x) overflows, Taylor series of quotients by it are not finite. So 1/(b +
exp(x)) and even powers of 1/cosh(x) become products of sigmoids.

Coefficients, the largest parts of a formula that depend on parameters alone, are separated from
it: they are evaluated once an orbit, the remainder at every step of an integrator, and one
compiled flow serves all parameter values. The factors of a product are gathered first, so that
``2*q*F/m`` has the one coefficient ``2*F/m``. The time is the period times the phase; so ``W*t``
is ``W*(2*pi/W)``, one number, times the phase.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

import heyoka as hy

from slipfold.models.formulas.functions import CONSTANTS, FUNCTIONS, TIME, whole_power
from slipfold.models.formulas.grammar import (
    BOUNDS,
    Binary,
    Call,
    FormulaError,
    Name,
    Negative,
    Number,
    Tree,
    fold,
    format_tree,
    names_in,
    with_children,
)
from slipfold.models.quantities import Expression


def without_overflow(node: Tree, parts: tuple[Tree, ...]) -> Tree:
    """Rewrite a node, whose children are rewritten already, without overflow."""
    bounded = None
    match node, parts:
        case Binary("/"), (left, right):
            bounded = _quotient(left, right)
        case Binary("^"), (left, Negative(exponent)):
            bounded = _reciprocal(Binary("^", left, exponent))
    return bounded or with_children(node, parts)


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
    """Return the inverse of a tree in bounded functions; None if it needs none or has none."""
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
    """Return the number b > 0 and the argument of ``b + exp(x)``."""
    match tree:
        case Binary("+", Number(b), Call("exp", (x,))) if b > 0:
            return b, x
        case Binary("+", Call("exp", (x,)), Number(b)) if b > 0:
            return b, x
    return None


_ARITHMETIC: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
}


def value_of(tree: Tree, names: Mapping[str, Expression]) -> Expression:
    """Evaluate a tree with values or symbols for its names."""

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
    if exponent.is_integer() and abs(exponent) <= BOUNDS.power:
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
    """Return a symbolic expression: the value itself, or a constant if it is a float."""
    return value if isinstance(value, hy.expression) else hy.expression(float(value))


PHASE = "@phase"
"""Name of the phase in separated trees; no name in a text begins like this."""

ONE = Number(1.0)

WHOLE = frozenset(map(float, range(-9, 10)))
"""Exponents that apply to each factor of a product."""


@dataclass(frozen=True, slots=True)
class _Product:
    """A factor of parameters and numbers times a factor that varies in time; None stands for 1."""

    constant: Tree | None
    varying: Tree | None


class CoefficientFinder:
    """Separates coefficients from formulas and collects them.

    `constant` names the parameters, and formulas of parameters alone.

    >>> from slipfold.models.formulas.grammar import parse_formula
    >>> finder = CoefficientFinder({"F", "W", "m"}, parse_formula("2*pi/W"))
    >>> format_tree(finder.rest_of(parse_formula("F*cos(W*t)/m - 0.1*2*q^3")))
    '@k2*cos(@k1*@phase) - 0.2*q^3'
    >>> {key: format_tree(tree) for key, tree in finder.coefficients.items()}
    {'k1': 'W*(2*pi/W)', 'k2': 'F/m'}
    """

    def __init__(self, constant: Collection[str], period: Tree | None) -> None:
        self._constant = frozenset(constant)
        self._period = period
        self._keys: dict[str, str] = {}
        self.coefficients: dict[str, Tree] = {}

    def rest_of(self, tree: Tree) -> Tree:
        """Return a formula with names ``@k1`` ... in the place of its coefficients."""
        return self._whole(fold(tree, self._combine))

    def _combine(self, node: Tree, values: tuple[_Product, ...]) -> _Product:
        if isinstance(node, Number):
            return _Product(node, None)
        if isinstance(node, Name):
            return self._named(node)
        if isinstance(node, Negative):
            (inner,) = values
            if inner.constant is None:
                return _Product(None, Negative(inner.varying or ONE))
            return _Product(Negative(inner.constant), inner.varying)
        if all(value.varying is None for value in values):
            return _Product(
                with_children(node, tuple(value.constant or ONE for value in values)), None
            )
        if isinstance(node, Binary):
            product = self._split(node, *values)
            if product is not None:
                return product
            if node.operator == "^":
                self._check_exponent(node, values[1])
        return _Product(None, with_children(node, tuple(self._whole(value) for value in values)))

    def _named(self, node: Name) -> _Product:
        if node.name == TIME:
            return _Product(self._period, Name(PHASE))
        if node.name in CONSTANTS or node.name in self._constant:
            return _Product(node, None)
        return _Product(None, node)

    def _split(self, node: Binary, left: _Product, right: _Product) -> _Product | None:
        """Gather the factors of a product, a quotient or an integer power."""
        if node.operator in "*/":
            return _Product(
                _joined(node, left.constant, right.constant),
                _joined(node, left.varying, right.varying),
            )
        if node.operator == "^" and right.varying is None and left.constant is not None:
            exponent = right.constant or ONE
            # Other powers of a product are not a product of powers where a factor is negative.
            if isinstance(exponent, Number) and exponent.value in WHOLE:
                return _Product(
                    Binary("^", left.constant, exponent, node.position),
                    Binary("^", left.varying or ONE, exponent, node.position),
                )
        return None

    def _check_exponent(self, node: Binary, exponent: _Product) -> None:
        tree = None if exponent.varying is not None else self._whole(exponent)
        if isinstance(tree, Number) and abs(tree.value) > BOUNDS.power:
            raise FormulaError(
                f"the exponent {tree.value:g} is beyond {BOUNDS.power}; give a smaller one",
                node.position,
            )

    def _whole(self, product: _Product) -> Tree:
        if product.constant is None:
            return product.varying or ONE
        factor = self._coefficient(product.constant)
        if product.varying is None:
            return factor
        return product.varying if factor == ONE else Binary("*", factor, product.varying)

    def _coefficient(self, tree: Tree) -> Tree:
        if names_in(tree).keys() <= CONSTANTS.keys():
            value = float(value_of(tree, CONSTANTS))
            if not math.isfinite(value):
                raise FormulaError(
                    f"{format_tree(tree)[:60]} is not a finite number; correct the formula",
                    getattr(tree, "position", 0),
                )
            return Number(value)
        text = format_tree(tree)
        if text not in self._keys:
            self._keys[text] = f"k{len(self._keys) + 1}"
            self.coefficients[self._keys[text]] = tree
        return Name(f"@{self._keys[text]}")


def _joined(node: Binary, left: Tree | None, right: Tree | None) -> Tree | None:
    if right is None:
        return left
    if left is None:
        return right if node.operator == "*" else Binary("/", ONE, right, node.position)
    return Binary(node.operator, left, right, node.position)
