"""Thresholds at many values of scattered parameters."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.design_space.placed import Lost
from slipfold.design_space.placed_point import PlacedPoint

INTERRUPTED = "interrupted before this sample was reached"


def thresholds_at(
    point: PlacedPoint,
    places: Array,
    tell: Callable[[int, int], None] = lambda done, lost: None,
) -> tuple[Array, NDArray[np.str_]]:
    """Return the threshold at each place, and why there is none, both of shape (n,).

    `tell` is called with how many are done and how many of them have none; if it raises
    `KeyboardInterrupt`, the others say so. Shapes: places (n, d).
    """
    values, reasons = np.full(len(places), np.nan), [INTERRUPTED] * len(places)
    lost = 0
    try:
        for row, place in enumerate(places.tolist()):
            tell(row, lost)
            try:
                values[row] = point.moved_to(dict(zip(point.names, place, strict=True))).value
                reasons[row] = ""
            except Lost as error:
                reasons[row], lost = str(error), lost + 1
    except KeyboardInterrupt:
        pass
    return values, np.array(reasons, dtype=np.str_)
