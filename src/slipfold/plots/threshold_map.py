"""Maps of thresholds: a colour for each point of the plane, a hatch where there is no threshold."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.models.parameter import Parameter
from slipfold.plots.angles import label_axis, quantity_text
from slipfold.plots.axes import axes_or_new, cell_edges
from slipfold.thresholds.search import INTERRUPTED
from slipfold.thresholds.threshold_map import GridThresholds

COLOURS = "plasma"
"""Colours of the thresholds, from low to high: they grow lighter."""

HATCHES = ("//", "xx", "..", "\\\\", "--", "||", "++")
"""Hatches of failures, the most frequent kind first; later kinds get them again, closer."""

PALE = "0.93"
"""Ground of the hatches: no colour of a threshold."""

INK = "0.55"
"""Colour of the hatches."""

LABEL_SIZE = 6.5
"""Font size of the values of contour lines in points."""


def draw_threshold_map(
    found: GridThresholds,
    ax: Axes | None = None,
    *,
    limits: tuple[float, float] | None = None,
    contours: bool = True,
    annotate: bool = True,
    legend: bool = True,
) -> Axes:
    """Draw thresholds as colours over the plane of the grid's parameters.

    Each point of the grid colours the part of the plane that is nearest to it. Contour lines are
    interpolated. Parts without a threshold are hatched, each kind of failure in its own way; what
    an interruption left is white. Angles are shown in degrees; the data of the axes are radians.
    """
    ax = axes_or_new(ax)
    first, second = found.axes
    orders = [np.argsort(values) for values in found.over.values()]
    x, y = (values[order] for values, order in zip(found.over.values(), orders, strict=True))
    values = found.values[np.ix_(*orders)].T
    kinds = found.kinds[np.ix_(*orders)].T
    edges = cell_edges(x), cell_edges(y)
    if np.isfinite(values).any():
        _draw_values(ax, found, (x, y), edges, values, limits, contours, annotate)
    failures = _draw_failures(ax, found, edges, kinds)
    ax.set_xlim(edges[0][0], edges[0][-1])
    ax.set_ylim(edges[1][0], edges[1][-1])
    label_axis(ax, "x", found.model.parameter(first))
    label_axis(ax, "y", found.model.parameter(second))
    if legend and failures:
        # Four lines below the axes: clear of the numbers and the name of the parameter.
        ax.legend(
            handles=failures,
            title="no threshold",
            loc="upper center",
            bbox_to_anchor=(0.5, 0.0),
            borderaxespad=4.0,
            handlelength=2.8,
        )
    return ax


def _draw_values(
    ax: Axes,
    found: GridThresholds,
    places: tuple[Array, Array],
    edges: tuple[Array, Array],
    values: Array,
    limits: tuple[float, float] | None,
    contours: bool,
    annotate: bool,
) -> None:
    low, high = (np.nanmin(values), np.nanmax(values)) if limits is None else limits
    scale = Normalize(low, high)
    shown = np.ma.masked_invalid(values)
    # As a picture: between cells of a vector drawing, viewers show hairlines.
    mesh = ax.pcolormesh(*edges, shown, cmap=COLOURS, norm=scale, rasterized=True, zorder=0)
    figure = ax.get_figure(root=True)
    assert figure is not None
    bar = figure.colorbar(mesh, ax=ax, pad=0.02)
    parameter = found.model.parameter(found.threshold)
    label_axis(bar.ax, "y", parameter)
    bar.ax.set_ylabel(f"{bar.ax.get_ylabel()} at the first {found.type}")
    ticks = np.asarray(bar.ax.get_yticks(), dtype=float)
    levels = ticks[(ticks > np.nanmin(values)) & (ticks < np.nanmax(values))]
    if not contours or min(values.shape) < 2 or not len(levels):
        return
    # White on the dark half of the colours, black on the light one.
    colours = ["white" if scale(level) < 0.5 else "black" for level in levels]
    lines = ax.contour(*places, shown, levels=levels, colors=colours, linewidths=0.6)
    if annotate:
        texts = {level: _level_text(parameter, float(level)) for level in levels}
        ax.clabel(lines, fmt=texts, fontsize=LABEL_SIZE)


def _level_text(parameter: Parameter, level: float) -> str:
    """Return a value without its unit, which stands at the colour bar."""
    return quantity_text(parameter, level).removesuffix(f" {parameter.unit}")


def _draw_failures(
    ax: Axes,
    found: GridThresholds,
    edges: tuple[Array, Array],
    kinds: NDArray[np.str_],
) -> list[Patch]:
    """Hatch the parts without a threshold; return what the legend shows."""
    handles: list[Patch] = []
    names = [name for name in found.failures if name != INTERRUPTED]
    for number, name in enumerate(names):
        turns, which = divmod(number, len(HATCHES))
        style: dict[str, Any] = {
            "facecolor": PALE,
            "edgecolor": INK,
            "hatch": HATCHES[which] * (turns + 1),
        }
        area = cells(edges, kinds == name)
        ax.add_patch(PathPatch(area, linewidth=0.0, zorder=0.5, label=name, **style))
        handles.append(Patch(linewidth=0.4, label=name, **style))
    if found.interrupted:
        handles.append(Patch(facecolor="white", edgecolor=INK, linewidth=0.4, label=INTERRUPTED))
    return handles


def cells(edges: tuple[Array, Array], mask: NDArray[np.bool_]) -> Path:
    """Return the outline of some cells together, so that a hatch runs on from one to the next."""
    rows, columns = np.nonzero(mask)
    x, y = edges
    left, right, bottom, top = x[columns], x[columns + 1], y[rows], y[rows + 1]
    corners = [(left, bottom), (right, bottom), (right, top), (left, top), (left, bottom)]
    vertices = np.array(corners).transpose(2, 0, 1).reshape(-1, 2)
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
    return Path(vertices, np.tile(codes, len(rows)))
