"""Axes: new ones where none are given, and what stands beside them."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.layout_engine import PlaceHolderLayoutEngine
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.output import Output
from slipfold.models.parameter import State


def axes_or_new(ax: Axes | None) -> Axes:
    """Return the axes given, or those of a new figure."""
    if ax is not None:
        return ax
    # Only here, where a figure is to be shown: it looks for a window system and takes its time.
    from matplotlib import pyplot

    return pyplot.subplots(layout="constrained")[1]


def label_of(model: Model, output: str) -> str:
    """Return the axis label of a state or output."""
    items: list[State | Output] = [*model.states, *model.outputs()]
    for item in items:
        if item.name == output:
            return item.label or item.name
    known = ", ".join(item.name for item in items)
    raise InputError(f"{model.name} has no output {output!r}; it has {known}")


def settle(ax: Axes) -> None:
    """Fix limits and layout, so that places in the figure can be computed."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    engine = figure.get_layout_engine()
    # A layout moves when it is drawn; a place holder stands for one that no longer does.
    if engine is not None and not isinstance(engine, PlaceHolderLayoutEngine):
        figure.draw_without_rendering()
    # Limits are computed when they are asked for, and not when a transform uses them.
    ax.set_xlim(ax.get_xlim())
    ax.set_ylim(ax.get_ylim())


def cell_edges(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where the cells of increasing places begin and end: halfway to their neighbours.

    The outermost cells end at their places; one place alone gets some room.
    """
    if len(places) == 1:
        room = 0.05 * abs(places[0]) or 0.5
        return np.array([places[0] - room, places[0] + room])
    return np.concatenate([places[:1], (places[1:] + places[:-1]) / 2, places[-1:]])
