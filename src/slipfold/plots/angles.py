"""Axes of angles: data in radians, ticks in degrees, lines that break where a turn begins anew."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, MaxNLocator

from slipfold.arrays import Array
from slipfold.models.model import Model
from slipfold.models.parameter import Parameter
from slipfold.models.turns import TURN
from slipfold.plots.axes import label_of

QUARTER = 90.0
"""Degrees beyond which ticks are parts of a turn, not tens."""


class _DegreeLocator(MaxNLocator):
    """Places ticks at round numbers of degrees, on an axis of radians."""

    def __init__(self) -> None:
        super().__init__(nbins=7)

    def tick_values(self, vmin: float, vmax: float) -> Any:
        is_wide = np.degrees(abs(vmax - vmin)) > QUARTER
        self.set_params(steps=[1, 1.5, 3, 4.5, 6, 9, 10] if is_wide else [1, 2, 5, 10])
        return np.radians(super().tick_values(np.degrees(vmin), np.degrees(vmax)))


def label_axis(ax: Axes, which: Literal["x", "y"], parameter: Parameter) -> None:
    """Write symbol and unit beside an axis, and degrees on an axis of radians."""
    angle = parameter.unit == "rad"
    label = f"{parameter.symbol or parameter.name} (°)" if angle else parameter.label
    _label(ax, which, label, angle=angle)


def label_output(
    ax: Axes, which: Literal["x", "y"], model: Model, output: str, what: str = ""
) -> None:
    """Write what is shown of a state or output beside an axis, and degrees on that of an angle."""
    angle = output in _angles(model)
    label = f"{label_of(model, output)} (°)" if angle else label_of(model, output)
    _label(ax, which, f"{what} {label}".strip(), angle=angle)


def on_circles(
    model: Model, named: Sequence[tuple[str, Array]], along: Sequence[Array] = ()
) -> list[Array]:
    """Return outputs, then what they are drawn along, with angles within half a turn of zero.

    Where an angle begins anew the line is broken, by what is no number.
    """
    wrapped, breaks = [], np.empty(0, dtype=int)
    for name, column in named:
        if name in _angles(model):
            column = column - TURN * np.round(column / TURN)
            jumps = np.flatnonzero(np.abs(np.diff(column)) > TURN / 2) + 1
            breaks = np.union1d(breaks, jumps).astype(int)
        wrapped.append(column)
    return [np.insert(column, breaks, np.nan) for column in (*wrapped, *along)]


def _angles(model: Model) -> set[str]:
    return {state.name for state in model.states if state.angle}


def _label(ax: Axes, which: Literal["x", "y"], label: str, *, angle: bool) -> None:
    axis = ax.xaxis if which == "x" else ax.yaxis
    if angle:
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
