"""Elementary functions of numbers and of symbols alike."""

from __future__ import annotations

from typing import Any

import heyoka as hy
import numpy as np

from slipfold.models.output import Expression


def is_symbolic(*values: Any) -> bool:
    """Whether any of the values is a symbolic expression."""
    return any(isinstance(value, hy.expression) for value in values)


def exp(value: Expression) -> Expression:
    """Return the exponential."""
    return hy.exp(value) if is_symbolic(value) else _plain(np.exp(value))


def tanh(value: Expression) -> Expression:
    """Return the hyperbolic tangent."""
    return hy.tanh(value) if is_symbolic(value) else _plain(np.tanh(value))


def arctan(value: Expression) -> Expression:
    """Return the inverse tangent."""
    return hy.atan(value) if is_symbolic(value) else _plain(np.arctan(value))


def sqrt(value: Expression) -> Expression:
    """Return the square root."""
    return hy.sqrt(value) if is_symbolic(value) else _plain(np.sqrt(value))


def _plain(value: Any) -> Any:
    """Return a number of NumPy's as one of Python's, which prints as it is typed."""
    return value.item() if np.ndim(value) == 0 else value
