"""A box of starting states, and starts spread evenly over it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.quantity import parse_quantity
from slipfold.models.suggestion import unknown

REACH = 1.5
"""Of a box that nobody gives: times the typical size of each state, about the model's start."""


@dataclass(frozen=True, eq=False)
class Box:
    """States between two corners; where they agree a state is the same in all starts."""

    low: Array  # shape (n,)
    high: Array  # shape (n,)

    def starts(self, number: int, seed: int) -> Array:
        """Return starts of low discrepancy (scrambled Sobol points), shape (number, n)."""
        from scipy.stats import qmc  # takes a second, which only a search should

        moves = self.high > self.low
        states = np.tile(self.low, (number, 1))
        if moves.any():
            points = qmc.Sobol(int(moves.sum()), rng=np.random.default_rng(seed))
            shares = points.random_base2(int(np.ceil(np.log2(max(number, 2)))))[:number]
            states[:, moves] += shares * (self.high - self.low)[moves]
        return states


def checked_box(model: Model, given: Any) -> Box:
    """Read a box from intervals by state; the other states are those of the model's start.

    >>> from slipfold.models import SlidingOscillator
    >>> checked_box(SlidingOscillator(), {"y": (-0.5, "0.5")}).high.tolist()
    [0.0, 0.5, 0.0, 0.0]
    """
    units = {state.name: state.unit for state in model.states}
    low, high = model.start.copy(), model.start.copy()
    if not isinstance(given, Mapping) or not given:
        example = {next(iter(units)): (-1, 1)}
        raise InputError(f"box = {given!r} does not say which states; give e.g. {example!r}")
    for name, ends in given.items():
        if name not in units:
            raise unknown(f"{model.name} has no state", name, units)
        try:
            first, last = ends
        except (TypeError, ValueError):
            raise InputError(
                f"the box of {name}, {ends!r}, is not a pair of numbers; give its least and its "
                "largest value"
            ) from None
        place = list(units).index(name)
        low[place], high[place] = (parse_quantity(end, units[name], name) for end in (first, last))
        if not (np.isfinite([low[place], high[place]]).all() and low[place] < high[place]):
            raise InputError(
                f"the box of {name} from {low[place]:g} to {high[place]:g} is empty; give its "
                "least value first"
            )
    return Box(low, high)


def box_around(model: Model, reached: Array | None = None) -> Box:
    """Return the box that is meant where nobody gives one.

    It is about the model's start, by the typical sizes of states or how far orbits reach from it,
    whichever is larger. Shapes: reached (n,).
    """
    sizes = model.state_scales() if reached is None else np.maximum(model.state_scales(), reached)
    half = np.where(model.whole_turns > 0, model.whole_turns / 2, REACH * sizes)
    return Box(model.start - half, model.start + half)
