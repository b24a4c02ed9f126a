"""Floquet multipliers and what they say."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def floquet_multipliers(monodromy: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Return the multipliers, largest modulus first, the upper one of a pair before the lower.

    Shapes: monodromy (..., n, n); returns (..., n).
    """
    values = np.linalg.eigvals(monodromy).astype(complex)
    # Moduli of a pair differ by rounding: compared to twelve digits, pairs stay together.
    modulus = np.abs(values)
    largest = modulus.max(axis=-1, keepdims=True, initial=0.0)
    modulus = np.round(modulus / (largest + (largest == 0)), 12)
    order = np.lexsort((-values.imag, -values.real, -modulus), axis=-1)
    # One set of multipliers is indexed in a tenth of the time.
    return values[order] if values.ndim == 1 else np.take_along_axis(values, order, axis=-1)


def match_multipliers(
    values: NDArray[np.complex128], others: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Return `others` in the order in which they lie nearest `values`.

    Shapes: values, others (n,).
    """
    distance = np.abs(values[:, None] - others[None, :])
    result = np.empty_like(others)
    for _ in values:  # nearest pairs first
        i, j = np.unravel_index(distance.argmin(), distance.shape)
        result[i] = others[j]
        distance[i, :] = np.inf
        distance[:, j] = np.inf
    return result
