"""Whole powers as products."""

from __future__ import annotations

from slipfold.models.output import Expression


def whole_power(base: Expression, exponent: int) -> Expression:
    """Return a power as a product: the series of a power divides by its base, which may be zero.

    >>> import heyoka as hy
    >>> whole_power(hy.expression("u"), 3)
    (u * (u * u))
    >>> whole_power(2.0, 7)
    128.0
    """
    result: Expression = None
    # By squaring: the squares are shared, so this stays short.
    while exponent:
        if exponent & 1:
            result = base if result is None else result * base
        exponent >>= 1
        if exponent:
            base = base * base
    return 1.0 if result is None else result
