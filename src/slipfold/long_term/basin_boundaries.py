"""Basins of attraction on a plane of starts, and the cells in which their boundaries lie."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.long_term.attractor import Attractor
from slipfold.long_term.released_search import search_released
from slipfold.long_term.repeats import FLOOR
from slipfold.long_term.search import UNFINISHED, Searched
from slipfold.models.model import Model
from slipfold.progress import Observer

KNOWN, WITHIN_CELL, WITHIN_ERROR = 0, 1, 2
"""Whether a cell has one label: also at its corners; not there; nor where the start is moved by as
much as errors of steps are."""


@dataclass(frozen=True, eq=False)
class FoundBasins:
    """What was found; shapes of arrays (n_second, n_first)."""

    searched: Searched  # of the centres of cells
    labels: NDArray[np.int64]
    uncertain: NDArray[np.int64]
    attractors: tuple[Attractor, ...]
    interrupted: bool


def find_basins(
    model: Model,
    axes: tuple[Array, Array],
    starts_at: Callable[[Array, Array], tuple[Array, Array]],
    periods: int | None,
    observer: Observer | None,
) -> FoundBasins:
    """Label the cells of a plane by what their starts settle on, and see where that is uncertain.

    Motions start at the centres of cells, then at their corners. Cells whose labels differ, and
    those beside them, are labelled again from states that are moved by errors of steps. `starts_at`
    returns states and phases of coordinates. Shapes: axes (n_first,), (n_second,).
    """

    def searched_on(starts: Array, phases: Array) -> Searched:
        return search_released(last.model, starts, phases, periods, observer, last.known)

    starts, phases = starts_at(*_grid(*axes))
    first = last = search_released(model, starts, phases, periods, observer)
    labels = first.labels.reshape(len(axes[1]), -1)
    uncertain = np.full_like(labels, KNOWN)
    if not last.interrupted:
        last = searched_on(*starts_at(*_grid(*map(_edges, axes))))
        corners = last.labels.reshape(len(labels) + 1, -1)
        for up, across in product((slice(1, None), slice(-1)), repeat=2):
            uncertain[_differ(labels, corners[up, across])] = WITHIN_CELL
    cells = np.flatnonzero(_with_neighbours(uncertain > KNOWN))
    moved = FLOOR * last.model.state_scales()
    for sign in (-1.0, 1.0) if len(cells) else ():
        if not last.interrupted:
            last = searched_on(starts[cells] + sign * moved, phases[cells])
            uncertain.flat[cells[_differ(labels.flat[cells], last.labels)]] = WITHIN_ERROR
    attractors = tuple(item.attractor for item in last.known)
    return FoundBasins(first, labels, uncertain, attractors, last.interrupted)


def _grid(first: Array, second: Array) -> tuple[Array, Array]:
    across, up = np.meshgrid(first, second)
    return across.ravel(), up.ravel()


def _edges(values: Array) -> Array:
    """Return the ends of cells within the plane. Shapes: values (n,), returns (n + 1,)."""
    return np.concatenate([values[:1], 0.5 * (values[1:] + values[:-1]), values[-1:]])


def _differ(one: NDArray[np.int64], other: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether labels differ, as far as they are known."""
    return np.asarray((one != other) & (one != UNFINISHED) & (other != UNFINISHED))


def _with_neighbours(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(mask, np.ones((3, 3), bool)))
