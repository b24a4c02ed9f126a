"""What motions do over a plane of two parameters: from rest, and carried up and down."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.strobes.strobe_many import StrobeProgress
from slipfold.long_term.places import Places
from slipfold.models.model import Model

__all__ = ["RUNS", "Plane", "find_regimes"]

Array = NDArray[np.float64]

RUNS = ("rest", "up", "down")


@dataclass(frozen=True, eq=False)
class Plane:
    """What was found; the first axis of arrays is that of `RUNS`, then those of the plane."""

    model: Model
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
    observer: Callable[[StrobeProgress], None] | None = None,
) -> Plane:
    """Follow motions in all cells; carried ones begin with the last state of the neighbour.

    Carried are motions along the second parameter. Shapes: places (n1,), (n2,); start (n,).
    """
    shape = len(places[0]), len(places[1])
    first, second = (grid.ravel() for grid in np.meshgrid(*places, indexing="ij"))
    values = {axes[0]: first, axes[1]: second}
    work = Places(model, values, len(RUNS), start, transient, observer)
    interrupted = False
    try:
        work.from_rest(0)
        _carry(work, np.arange(first.size).reshape(shape))
        work.tell_open()
    except KeyboardInterrupt:
        interrupted = True
    return _plane(work, (len(RUNS), *shape), interrupted)


def _carry(work: Places, lines: NDArray[np.intp]) -> None:
    """Carry motions along the second parameter, up and down again."""
    states = np.tile(work.start, (lines.shape[0], 1))
    for place in range(lines.shape[1]):
        states = work.follow(1, lines[:, place], states)
    for place in reversed(range(lines.shape[1])):
        states = work.follow(2, lines[:, place], states)


def _plane(work: Places, shape: tuple[int, ...], interrupted: bool) -> Plane:
    return Plane(
        work.model,
        work.told_kinds.reshape(shape),
        work.periods.reshape(shape),
        work.exponents.reshape(shape),
        work.states.reshape(*shape, -1),
        work.means.reshape(*shape, -1),
        interrupted,
    )
