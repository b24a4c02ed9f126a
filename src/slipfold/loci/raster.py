"""A window cut into cells, on which regions are told apart."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.loci.window import Window
from slipfold.models.model import Model

CELLS = 480
"""Cells in either direction: half a line's width in a figure."""

BLOCK = 8
"""Cells in either direction that are first asked for at once whether a model exists there."""


@dataclass(frozen=True)
class Raster:
    """Cells of a window."""

    window: Window  # least and largest value of two parameters

    def columns(self, values: Array, axis: int) -> NDArray[np.int64]:
        """Return the cells that values of a parameter lie in, shape (n,). Shapes: values (n,)."""
        low, high = self.window[axis]
        cells = ((np.asarray(values) - low) / (high - low) * CELLS).astype(int)
        return np.clip(cells, 0, CELLS - 1)

    def centres(self, axis: int) -> Array:
        """Return the values of a parameter at the centres of the cells, shape (CELLS,)."""
        low, high = self.window[axis]
        return np.linspace(low, high, 2 * CELLS + 1)[1::2]

    def draw(self, mask: NDArray[np.bool_], values: Array) -> None:
        """Mark the cells that a polyline passes, without gaps.

        Shapes: mask (CELLS, CELLS); values (n, 2).
        """
        for a, b in pairwise(values):
            length = [
                abs(b[i] - a[i]) / (high - low) * CELLS for i, (low, high) in enumerate(self.window)
            ]
            count = int(2 * max(length)) + 2
            between = a + np.linspace(0, 1, count)[:, None] * (b - a)
            inside = np.all(
                [
                    (low <= v) & (v <= high)
                    for v, (low, high) in zip(between.T, self.window, strict=True)
                ],
                axis=0,
            )
            kept = between[inside]
            mask[self.columns(kept[:, 1], 1), self.columns(kept[:, 0], 0)] = True


def where_models_exist(model: Model, plane: tuple[str, str], raster: Raster) -> NDArray[np.bool_]:
    """Tell the cells at whose centre the parameters contradict each other from the others.

    Returns shape (CELLS, CELLS).
    """
    first, second = raster.centres(0), raster.centres(1)
    middles = np.arange(BLOCK // 2, CELLS, BLOCK)
    coarse = np.array(
        [[model_exists(model, plane, first[i], second[j]) for i in middles] for j in middles]
    )
    fine = np.kron(coarse, np.ones((BLOCK, BLOCK), dtype=bool)).astype(bool)
    for row, column in zip(*np.nonzero(_beside_others(coarse)), strict=True):
        for j in range(row * BLOCK, (row + 1) * BLOCK):
            for i in range(column * BLOCK, (column + 1) * BLOCK):
                fine[j, i] = model_exists(model, plane, first[i], second[j])
    return fine


def model_exists(model: Model, plane: tuple[str, str], first: float, second: float) -> bool:
    """Whether the parameters do not contradict each other at a place."""
    try:
        model.replace(**{plane[0]: float(first), plane[1]: float(second)})
    except InputError:
        return False
    return True


def _beside_others(coarse: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Blocks that have a neighbour of the other sort, diagonals included."""
    padded = np.pad(coarse, 1, mode="edge")
    n, m = coarse.shape
    around = [padded[i : i + n, j : j + m] for i in range(3) for j in range(3)]
    return np.asarray(np.any([other != coarse for other in around], axis=0))
