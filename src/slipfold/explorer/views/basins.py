"""Basins of attraction as a picture that becomes finer while it is computed."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from slipfold.computations.long_term import basins
from slipfold.explorer.messages import BasinsRequest
from slipfold.explorer.views.labels import axis_of
from slipfold.explorer.views.numbers import number, short
from slipfold.long_term.attractor import Attractor
from slipfold.models.model import Model
from slipfold.progress import Progress
from slipfold.results.attractors import Basins, in_words

FINER = (16, 48, 144)
"""Starts along both states, picture after picture; the last has eight times those before it."""

BETWEEN = 0.1
"""Least time between two notes of progress, in s."""


def tell_basins(
    model: Model,
    request: BasinsRequest,
    tell: Callable[[dict[str, Any]], None],
    check: Callable[[], None],
) -> None:
    """Compute basins, coarse ones first, and tell each picture as soon as it is there."""
    told = perf_counter()

    def watch(progress: Progress) -> None:
        nonlocal told
        check()
        if perf_counter() - told >= BETWEEN:
            told = perf_counter()
            tell({"far": [progress.done, progress.total], "done": False})

    plane = {axis.name: axis.span for axis in (request.x, request.y)}
    for points in FINER:
        found = basins(model, plane, points=points, observer=watch)
        tell({**_picture(found), "done": points == FINER[-1]})


def _picture(found: Basins) -> dict[str, Any]:
    """Return labels row by row from below, numbered so that finer pictures keep the numbers."""
    order = sorted(found, key=_character)
    labels = found.labels.copy()
    for place, item in enumerate(order, 1):
        labels[found.labels == item.id] = place
    first, second = found.plane
    return {
        "x": {**axis_of(found.model, first), "values": short(found.first)},
        "y": {**axis_of(found.model, second), "values": short(found.second)},
        "labels": labels.tolist(),
        "attractors": [
            {"name": in_words(item), "share": number(found.share(item).value)} for item in order
        ],
    }


def _character(item: Attractor) -> tuple[Any, ...]:
    """What tells attractors apart however they were found."""
    return item.kind, item.period or 0, np.round(item.maximum, 6).tolist()
