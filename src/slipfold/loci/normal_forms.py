"""Normal form coefficients at points of codimension two."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.normal_form import StroboscopicMap

__all__ = ["codimension_two_coefficients"]

Array = NDArray[np.float64]


def codimension_two_coefficients(
    map_: StroboscopicMap, monodromy: Array, kind: str, locus: str
) -> dict[str, float]:
    return {}
