"""Where an element, a contact or a force acts: a degree of freedom, or a sum of several."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.structures.shown import shown
from slipfold.models.suggestion import suggest

SHOWN = 12
"""Names that a message lists before it breaks off."""


@dataclass(frozen=True)
class Direction:
    """A weighted sum of degrees of freedom: the displacement ``u = sum w_i q_i``.

    A force F along it acts on each degree of freedom with ``w_i F``, so that its power is ``F u'``.
    The weights are taken as they are given, so that ``{"a": 1, "b": -1}`` is the displacement of a
    relative to b.

    >>> print(Direction((("x", 0.6), ("y", 0.8))))
    0.6 x + 0.8 y
    """

    weights: tuple[tuple[str, float], ...]  # name and weight of each degree of freedom; no unit

    def __str__(self) -> str:
        """Write the sum."""
        parts = [name if weight == 1 else f"{weight:g} {name}" for name, weight in self.weights]
        return " + ".join(parts).replace("+ -", "- ")

    def vector(self, names: Sequence[str]) -> NDArray[np.float64]:
        """Return the weights in the order of the degrees of freedom, shape (n,)."""
        result = np.zeros(len(names))
        places = {name: place for place, name in enumerate(names)}
        for name, weight in self.weights:
            if name not in places:
                raise InputError(
                    f"the structure has no degree of freedom {shown(name)}; {suggest(name, names)}"
                    f"it has {listed(names)}"
                )
            result[places[name]] = weight
        return result


def as_direction(value: Any, what: str) -> Direction:
    """Make a direction of a name or of weights by name.

    >>> as_direction("tip", "a spring")
    Direction(weights=(('tip', 1.0),))
    """
    if isinstance(value, Direction):
        return value
    if isinstance(value, str):
        return Direction(((value, 1.0),))
    if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
        raise InputError(
            f"{what} acts at {shown(value)}, which is no direction; give the name of a degree of "
            'freedom, or weights by name such as {"x": 0.6, "y": 0.8}'
        )
    weights = {name: _weight(name, weight, what) for name, weight in value.items()}
    kept = tuple((name, weight) for name, weight in weights.items() if weight)
    if not kept:
        raise InputError(
            f"the direction of {what} is zero; give at least one degree of freedom a weight that "
            "is not zero"
        )
    return Direction(kept)


def as_directions(value: Any, what: str, most: int) -> tuple[Direction, ...]:
    """Make one to `most` directions of one, or of a sequence of them."""
    several = value if isinstance(value, list | tuple) else (value,)
    if not 1 <= len(several) <= most:
        raise InputError(f"{what} acts along {len(several)} directions; give 1 to {most} of them")
    directions = tuple(as_direction(item, what) for item in several)
    names = sorted({name for item in directions for name, _ in item.weights})
    vectors = np.array([item.vector(names) for item in directions])
    sizes = np.linalg.norm(vectors, axis=1, keepdims=True)
    if np.linalg.matrix_rank(vectors / sizes) < len(directions):
        listed_directions = ", ".join(str(item) for item in directions)
        raise InputError(
            f"the directions {listed_directions} of {what} lie in one another; give directions at "
            "right angles"
        )
    return directions


def listed(names: Sequence[str]) -> str:
    """Return names as a list that breaks off when it grows long."""
    more = f", ... ({len(names)} in all)" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more


def _weight(name: str, weight: Any, what: str) -> float:
    try:
        number = float(weight)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError(
            f"the direction of {what} has the weight {shown(weight)} for {name}; give a "
            "finite number"
        )
    return number
