"""The look of figures: fonts, colors, lines, markers, axes and their labels."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from types import MappingProxyType
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.layout_engine import PlaceHolderLayoutEngine
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.angles import REVOLUTION
from slipfold.models.levels import quantity_of
from slipfold.models.model import Model
from slipfold.models.quantities import Parameter
from slipfold.orbits.bifurcation_types import POINT_TYPES

COLUMN = 3.45
"""Width of a journal column in inches."""

LINES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "stable": {"linestyle": "-", "linewidth": 1.5},
        "period doubling": {"linestyle": (0, (4.5, 2.0)), "linewidth": 1.0},
        "fold or torus": {"linestyle": (0, (1.0, 1.2)), "linewidth": 1.2},
    }
)
"""Line properties of each kind."""

MARKERS: Mapping[str, str] = MappingProxyType(
    {
        **{name: item.marker for name, item in POINT_TYPES.items()},
        "LIMIT": "x",
        "FAILED": "|",
        "EVENT": "+",
    }
)
"""Marker of each type of special point, and of the end of a branch that could not be followed."""

MEASURE_NAMES = {
    "max": "max",
    "min": "min",
    "peak_to_peak": "peak-to-peak",
    "modulus": "max modulus of",
}
"""Measures of an output over an orbit, as axes name them."""

_STYLE: dict[Any, Any] = {
    "axes.grid": False,
    "axes.labelsize": 9,
    "axes.linewidth": 0.7,
    "axes.titlelocation": "left",
    "axes.titlesize": 9,
    "axes.xmargin": 0.0,
    "figure.dpi": 100,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "lines.dash_capstyle": "butt",
    "lines.markersize": 4.5,
    "lines.solid_capstyle": "butt",
    "mathtext.fontset": "dejavusans",
    # Type 42 keeps text as text: editable and searchable in the PDF.
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "svg.fonttype": "none",
    "savefig.dpi": 300,
    "xtick.direction": "in",
    "xtick.labelsize": 8,
    "xtick.minor.visible": True,
    "xtick.top": True,
    "ytick.direction": "in",
    "ytick.labelsize": 8,
    "ytick.minor.visible": True,
    "ytick.right": True,
}


def figure_style() -> AbstractContextManager[None]:
    """Return a context in which matplotlib draws and saves in the style of the package.

    >>> with figure_style():
    ...     mpl.rcParams["pdf.fonttype"]
    42
    """
    return mpl.rc_context(_STYLE)


def drawn(draw: Callable[[Axes], object], form: str, height: float = 1.25) -> bytes:
    """Return the content of a file with one figure, two columns wide and of a height in columns.

    >>> drawn(lambda ax: ax.plot([0, 1]), "pdf")[:4]
    b'%PDF'
    """
    with figure_style():
        # A figure of its own needs no window, whatever the environment says.
        figure = Figure(figsize=(2 * COLUMN, height * COLUMN), layout="constrained")
        draw(figure.add_subplot())
        content = io.BytesIO()
        figure.savefig(content, format=form)
    return content.getvalue()


def palette(count: int) -> tuple[str, ...]:
    """Return colors that differ in lightness too, from dark to light.

    They lie on matplotlib's perceptually uniform map *plasma*, short of its yellow, which is too
    faint for a line on white.

    >>> palette(2)[0]
    '#0d0887'
    """
    positions = np.linspace(0.0, 0.74, count) if count != 1 else [0.0]
    return tuple(to_hex(mpl.colormaps["plasma"](position)) for position in positions)


def axes_or_new(ax: Axes | None) -> Axes:
    """Return the axes given, or those of a new figure."""
    if ax is not None:
        if not isinstance(ax, Axes):
            raise InputError(f"ax = {ax!r} is no matplotlib axes; give one, or leave it out")
        return ax
    # Only here, where a figure is to be shown: it looks for a window system and takes its time.
    from matplotlib import pyplot

    return pyplot.subplots(layout="constrained")[1]


def add_title(ax: Axes, text: str) -> None:
    """Title axes that have no title, as those that a caller titled keep theirs."""
    if not any(ax.get_title(place) for place in ("left", "center", "right")):
        ax.set_title(text)


def panels_of(
    ax: Any, rows: int, columns: int, size: tuple[float, float] | None = None, **shared: bool
) -> NDArray[np.object_]:
    """Return panels in place of axes, or of a new figure, shape (rows, columns).

    A new figure has the `size` in inches for each of several. Panels that are given stay.
    """
    if isinstance(ax, Axes | None):
        given, ax = ax, axes_or_new(ax)
        if rows * columns == 1:
            return np.array([[ax]], object)
        figure, place = ax.get_figure(root=True), ax.get_subplotspec()
        if place is None:
            raise InputError("the axes are no subplot, which could be divided; give one")
        if given is None and size is not None:
            figure.set_size_inches(size[0] * columns, size[1] * rows)
        ax.remove()
        ax = place.subgridspec(rows, columns).subplots(**shared)
    panels = np.array(ax, object)
    if panels.size != rows * columns or not all(isinstance(item, Axes) for item in panels.flat):
        raise InputError(
            f"ax = {ax!r} is not {rows} x {columns} matplotlib axes; give those, or leave it out"
        )
    return panels.reshape(rows, columns)


def legend_below(ax: Axes, lines: float, **options: Any) -> None:
    """Add a legend some lines below the axes, clear of the numbers and the parameter's name."""
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0), borderaxespad=lines, **options)


def label_of(model: Model, output: str, unit: str | None = None) -> str:
    """Return the axis label of a state or output, with its own unit or another."""
    item = quantity_of(model, output)
    label = item.label or item.name
    unit = item.unit if unit is None else unit
    return label if not unit or f"({unit})" in label else f"{label} ({unit})"


def add_color_bar(ax: Axes, mesh: ScalarMappable) -> Axes:
    """Add the scale of the colors of a map and return its axes."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    return figure.colorbar(mesh, ax=ax, pad=0.02).ax


def within(ax: Axes, points: Array) -> Array:
    """Return those of the points that the axes show; shapes: points (n, 2)."""
    low, high = np.sort(np.array([ax.get_xlim(), ax.get_ylim()]).T, axis=0)
    return points[((points >= low) & (points <= high)).all(axis=1)]


def settle(ax: Axes) -> None:
    """Compute limits and layout, so that places in the figure are known."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    engine = figure.get_layout_engine()
    # A layout moves when it is drawn; a place holder stands for one that no longer does.
    if engine is not None and not isinstance(engine, PlaceHolderLayoutEngine):
        figure.draw_without_rendering()
    # Limits are computed when they are requested, and not when a transform uses them. They still
    # fit what is drawn later, as a second response in the same axes.
    ax.set_xlim(ax.get_xlim(), auto=None)
    ax.set_ylim(ax.get_ylim(), auto=None)


def cell_edges(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where the cells of increasing places begin and end: halfway to their neighbors.

    The outermost cells end at their places; one place alone gets some room.
    """
    if len(places) == 1:
        room = 0.05 * abs(places[0]) or 0.5
        return np.array([places[0] - room, places[0] + room])
    return np.concatenate([places[:1], (places[1:] + places[:-1]) / 2, places[-1:]])


class _DegreeLocator(MaxNLocator):
    """Places ticks at round numbers of degrees, on an axis of radians."""

    def __init__(self) -> None:
        super().__init__(nbins=7)

    def tick_values(self, vmin: float, vmax: float) -> Any:
        # Beyond a quarter of a revolution ticks are fractions of it, not tens of degrees.
        is_wide = np.degrees(abs(vmax - vmin)) > 90.0
        self.set_params(steps=[1, 1.5, 3, 4.5, 6, 9, 10] if is_wide else [1, 2, 5, 10])
        return np.radians(super().tick_values(np.degrees(vmin), np.degrees(vmax)))


def label_axis(ax: Axes, which: Literal["x", "y"], parameter: Parameter) -> None:
    """Label an axis with symbol and unit, and with degrees on an axis of radians."""
    angle = parameter.unit == "rad"
    label = f"{parameter.symbol or parameter.name} (°)" if angle else parameter.label
    _label(ax, which, label, angle=angle)


def label_output(
    ax: Axes, which: Literal["x", "y"], model: Model, output: str, what: str = ""
) -> None:
    """Label an axis with a state or output, and with degrees on that of an angle."""
    angle = output in _angles(model)
    label = label_of(model, output, "°" if angle else None)
    _label(ax, which, f"{what} {label}".strip(), angle=angle)


def on_circles(
    model: Model, named: Sequence[tuple[str, Array]], along: Sequence[Array] = ()
) -> list[Array]:
    """Return outputs, then what they are drawn along, with angles within half a turn of zero.

    Where an angle wraps around, the line is broken by NaN.
    """
    wrapped, breaks = [], np.empty(0, dtype=int)
    for name, column in named:
        if name in _angles(model):
            column = column - REVOLUTION * np.round(column / REVOLUTION)
            jumps = np.flatnonzero(np.abs(np.diff(column)) > REVOLUTION / 2) + 1
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


def quantity_text(parameter: Parameter, value: float) -> str:
    """Return a value with its unit as figures show it, angles in degrees.

    >>> quantity_text(Parameter("alpha", 1.0, "rad"), 1.0471975511965976)
    '60°'
    """
    if parameter.unit == "rad":
        return f"{np.degrees(value):.4g}°"
    return f"{value:.4g}{' ' * bool(parameter.unit)}{parameter.unit}"
