"""What motions do over a plane of two parameters, which of them coexist included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.long_term.neighbours import continue_to_neighbours
from slipfold.long_term.places import Places
from slipfold.models.model import Model
from slipfold.progress import Observer

RUNS = ("rest", "up", "down")
"""The first runs; those after them are motions continued from neighbouring cells."""


@dataclass(frozen=True, eq=False)
class Plane:
    """What was found; the first axis of arrays is that of the runs, then those of the plane."""

    model: Model
    runs: tuple[str, ...]
    kinds: NDArray[np.str_]
    periods: NDArray[np.int64]  # 0 of what does not repeat
    exponents: Array  # the largest one, per forcing period; NaN where it was not needed
    states: Array  # the last ones; NaN where there are none
    means: Array  # of the states at phase zero of a response that repeats, else NaN
    interrupted: bool


def find_regimes(
    model: Model,
    axes: tuple[str, str],
    places: tuple[Array, Array],
    start: Array,
    transient: int,
    observer: Observer | None = None,
) -> Plane:
    """Follow motions in all cells: from the start, and from the motions of cells beside them.

    Runs up and down along the second parameter come first. Then every motion is continued to all
    neighbours until none is new. Shapes: places (n1,), (n2,); start (n,).
    """
    shape = len(places[0]), len(places[1])
    first, second = (grid.ravel() for grid in np.meshgrid(*places, indexing="ij"))
    values = {axes[0]: first, axes[1]: second}
    work = Places(model, values, len(RUNS), start, transient, observer)
    interrupted = False
    try:
        work.from_rest(0)
        cells = np.arange(first.size).reshape(shape)
        _sweep(work, cells)
        work.tell_open()
        continue_to_neighbours(work, cells)
    except KeyboardInterrupt:
        interrupted = True
    return _plane(work, shape, interrupted)


def _sweep(work: Places, lines: NDArray[np.intp]) -> None:
    """Continue motions along the second parameter, up and down again."""
    states = np.tile(work.start, (lines.shape[0], 1))
    for place in range(lines.shape[1]):
        states = work.follow(1, lines[:, place], states)
    for place in reversed(range(lines.shape[1])):
        states = work.follow(2, lines[:, place], states)


def _plane(work: Places, cells: tuple[int, int], interrupted: bool) -> Plane:
    further = len(work.kinds) - len(RUNS)
    shape = len(work.kinds), *cells
    return Plane(
        work.model,
        (*RUNS, *(f"continued {number}" for number in range(1, further + 1))),
        work.told_kinds.reshape(shape),
        work.periods.reshape(shape),
        work.exponents.reshape(shape),
        work.states.reshape(*shape, -1),
        work.means.reshape(*shape, -1),
        interrupted,
    )
