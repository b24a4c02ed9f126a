"""Formulas taken apart into coefficients, which depend on parameters alone, and the rest.

Coefficients are evaluated once an orbit, the rest at every step of an integrator, and one compiled
flow serves every value of the parameters. The largest parts without states and time are found; in
products the factors are gathered first, so that ``2*q*F/m`` has the one coefficient ``2*F/m``.
The time is the period times the phase; so ``W*t`` is ``W*(2*pi/W)``, one number, times the phase.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

from slipfold.models.definitions.names import TIME
from slipfold.models.formulas.functions import CONSTANTS
from slipfold.models.formulas.tokens import FormulaError
from slipfold.models.formulas.tree import (
    Binary,
    Call,
    Name,
    Negative,
    Number,
    Tree,
    fold,
    format_tree,
    names_in,
)
from slipfold.models.formulas.values import LARGEST_POWER, value_of

PHASE = "@phase"
"""The phase in trees that are taken apart; no name in a text begins like this."""

ONE = Number(1.0)

WHOLE = frozenset(map(float, range(-9, 10)))
"""Exponents that are taken with the factors of a product one by one."""


@dataclass(frozen=True, slots=True)
class _Product:
    """A factor of parameters and numbers times a factor that varies in time; None stands for 1."""

    constant: Tree | None
    varying: Tree | None


class CoefficientFinder:
    """Takes formulas apart, and collects the coefficients of them all.

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
            return _Product(_rebuilt(node, tuple(value.constant or ONE for value in values)), None)
        if isinstance(node, Binary):
            product = self._split(node, *values)
            if product is not None:
                return product
            if node.operator == "^":
                self._check_exponent(node, values[1])
        return _Product(None, _rebuilt(node, tuple(self._whole(value) for value in values)))

    def _named(self, node: Name) -> _Product:
        if node.name == TIME:
            return _Product(self._period, Name(PHASE))
        if node.name in CONSTANTS or node.name in self._constant:
            return _Product(node, None)
        return _Product(None, node)

    def _split(self, node: Binary, left: _Product, right: _Product) -> _Product | None:
        """Gather the factors of a product, quotient or whole power."""
        if node.operator in "*/":
            return _Product(
                _joined(node, left.constant, right.constant),
                _joined(node, left.varying, right.varying),
            )
        if node.operator == "^" and right.varying is None and left.constant is not None:
            exponent = right.constant or ONE
            # Other powers of a product are no product of powers where a factor is negative.
            if isinstance(exponent, Number) and exponent.value in WHOLE:
                return _Product(
                    Binary("^", left.constant, exponent, node.place),
                    Binary("^", left.varying or ONE, exponent, node.place),
                )
        return None

    def _check_exponent(self, node: Binary, exponent: _Product) -> None:
        tree = None if exponent.varying is not None else self._whole(exponent)
        if isinstance(tree, Number) and abs(tree.value) > LARGEST_POWER:
            raise FormulaError(
                f"the exponent {tree.value:g} is beyond {LARGEST_POWER}; give a smaller one",
                node.place,
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
                    getattr(tree, "place", 0),
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
        return right if node.operator == "*" else Binary("/", ONE, right, node.place)
    return Binary(node.operator, left, right, node.place)


def _rebuilt(node: Tree, children: tuple[Tree, ...]) -> Tree:
    if isinstance(node, Call):
        return Call(node.function, children, node.place)
    assert isinstance(node, Binary)
    left, right = children
    return Binary(node.operator, left, right, node.place)
