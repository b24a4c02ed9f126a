"""A window cut into cells, on which regions are told apart."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.loci.window import Window

__all__ = ["CELLS", "Raster"]

Array = NDArray[np.float64]

CELLS = 480
"""Cells in either direction: half a line's width in a figure."""


@dataclass(frozen=True)
class Raster:
    """Cells of a window.

    Parameters
    ----------
    window
        Least and largest value of two parameters.
    """

    window: Window

    def columns(self, values: Array, axis: int) -> NDArray[np.int64]:
        """Return the cells that values of a parameter lie in, shape (n,).

        Parameters
        ----------
        values
            Shape (n,).
        axis
            0 for the first parameter, 1 for the second.
        """
        low, high = self.window[axis]
        cells = ((np.asarray(values) - low) / (high - low) * CELLS).astype(int)
        return np.clip(cells, 0, CELLS - 1)

    def centres(self, axis: int) -> Array:
        """Return the values of a parameter at the centres of the cells, shape (CELLS,).

        Parameters
        ----------
        axis
            0 for the first parameter, 1 for the second.
        """
        low, high = self.window[axis]
        return np.linspace(low, high, 2 * CELLS + 1)[1::2]

    def draw(self, mask: NDArray[np.bool_], values: Array) -> None:
        """Mark the cells that a polyline passes, without gaps.

        Parameters
        ----------
        mask
            Shape (CELLS, CELLS), the second parameter first; changed.
        values
            Values of both parameters, shape (n, 2).
        """
        for a, b in pairwise(values):
            length = [
                abs(b[i] - a[i]) / (high - low) * CELLS for i, (low, high) in enumerate(self.window)
            ]
            count = int(2 * max(length)) + 2
            between = a + np.linspace(0, 1, count)[:, None] * (b - a)
            mask[self.columns(between[:, 1], 1), self.columns(between[:, 0], 0)] = True
