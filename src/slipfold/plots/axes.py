"""Axes: new ones where none are given, and what stands beside them."""

from __future__ import annotations

from matplotlib import pyplot
from matplotlib.axes import Axes

from slipfold.errors import InputError
from slipfold.models.model import Model

__all__ = ["axes_or_new", "label_of"]


def axes_or_new(ax: Axes | None) -> Axes:
    """Return the axes given, or those of a new figure.

    Parameters
    ----------
    ax
        Axes, or None.
    """
    return pyplot.subplots(layout="constrained")[1] if ax is None else ax


def label_of(model: Model, output: str) -> str:
    """Return the axis label of a state or output.

    Parameters
    ----------
    model
        The model.
    output
        Name of a state or output.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    items = (*model.states, *model.outputs())
    for item in items:
        if item.name == output:
            return item.label or item.name
    known = ", ".join(item.name for item in items)
    raise InputError(f"{model.name} has no output {output!r}; it has {known}")
