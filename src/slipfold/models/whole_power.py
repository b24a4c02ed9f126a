"""Whole powers of symbols as products."""

from __future__ import annotations

import heyoka as hy

from slipfold.models.output import Expression

__all__ = ["whole_power"]


def whole_power(base: Expression, exponent: int) -> Expression:
    """Return a power as a product: the series of a power divides by its base, which may be zero.

    Parameters
    ----------
    base
        A symbol.
    exponent
        A whole number of at least 0.

    Examples
    --------
    >>> whole_power(hy.expression("u"), 3)
    (u * (u * u))
    """
    result: Expression = 1.0
    # By squaring: the squares are shared, so this stays short.
    while exponent:
        if exponent & 1:
            result = result * base if isinstance(result, hy.expression) else base
        exponent >>= 1
        if exponent:
            base = base * base
    return result
