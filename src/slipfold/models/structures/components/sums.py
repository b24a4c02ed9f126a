"""Weighted sums of symbols, without the terms that are zero."""

from __future__ import annotations

from collections.abc import Iterable

import heyoka as hy

from slipfold.models.output import Expression


def product(weight: float, symbol: Expression) -> Expression:
    """Return ``weight * symbol``, without a factor of 1."""
    return symbol if weight == 1 else weight * symbol


def weighted_sum(weights: Iterable[float], symbols: Iterable[Expression]) -> list[Expression]:
    """Return the terms of a sum, those with a weight of zero left out."""
    pairs = zip(weights, symbols, strict=True)
    return [product(float(weight), symbol) for weight, symbol in pairs if weight != 0]


def total(terms: list[Expression]) -> Expression:
    """Return the sum of expressions; zero if there are none."""
    # One sum of many terms compiles faster than a chain of sums of two.
    return hy.sum(terms) if terms else hy.expression(0.0)
