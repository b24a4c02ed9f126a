"""Types of arrays, for annotations, and arrays of what is given."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Indices = NDArray[np.intp]
Complex = NDArray[np.complex128]


def as_numbers(given: Any) -> Array:
    """Return a new array of floats, one without entries if that cannot be made."""
    try:
        return np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        return np.empty((0, 0))
