"""Numbers as they go to the page: short, and never NaN."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

DIGITS = 7
"""Significant digits of what is drawn: a screen shows four, a zoom a hundredfold six."""

SMALLEST = 1e-290
"""Below this rounding would overflow; nothing that is drawn is so small."""


def short(values: ArrayLike) -> list[float]:
    """Round an array for drawing, relative to its largest value.

    Shapes: values (n,).

    >>> short([1 / 3, 1e-9])
    [0.3333333, 0.0]
    """
    array = np.asarray(values, dtype=float)
    largest = float(np.abs(array).max(initial=0.0))
    if largest < SMALLEST:
        return [0.0] * len(array)
    decimals = DIGITS - 1 - math.floor(math.log10(largest))
    rounded: list[float] = (np.round(array, decimals) + 0.0).tolist()
    return rounded


def number(value: float | None) -> float | None:
    """Return a number in full, or None where it is not finite.

    >>> number(float("nan")) is None
    True
    """
    return float(value) if value is not None and math.isfinite(value) else None
