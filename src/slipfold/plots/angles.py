"""Axes of angles: data in radians, ticks in degrees."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MaxNLocator

from slipfold.models.parameter import Parameter

__all__ = ["label_axis", "quantity_text"]


class _DegreeLocator(MaxNLocator):
    """Places ticks at round numbers of degrees, on an axis of radians."""

    def __init__(self) -> None:
        super().__init__(nbins=7, steps=[1, 1.5, 2, 3, 4.5, 5, 6, 9, 10])

    def tick_values(self, vmin: float, vmax: float) -> Any:
        return np.radians(super().tick_values(np.degrees(vmin), np.degrees(vmax)))


def label_axis(ax: Axes, which: Literal["x", "y"], parameter: Parameter) -> None:
    """Write symbol and unit beside an axis, and degrees on an axis of radians."""
    axis = ax.xaxis if which == "x" else ax.yaxis
    label = parameter.label
    if parameter.unit == "rad":
        label = f"{parameter.symbol or parameter.name} (°)"
        axis.set_major_locator(_DegreeLocator())
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{np.degrees(value):.6g}"))
    axis.set_label_text(label)


def quantity_text(parameter: Parameter, value: float, digits: int = 4) -> str:
    """Return a value with its unit as figures show it, angles in degrees.

    >>> quantity_text(Parameter("alpha", 1.0, "rad"), 1.0471975511965976)
    '60°'
    """
    if parameter.unit == "rad":
        return f"{np.degrees(value):.{digits}g}°"
    return f"{value:.{digits}g}{' ' * bool(parameter.unit)}{parameter.unit}"
