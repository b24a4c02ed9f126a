"""Maps over a plane: thresholds, basins, regimes and studies.

Each is cells in colors, of numbers with a bar and of words with a legend, and hatches over some.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from slipfold.arrays import Array, Mask
from slipfold.errors import InputError, unknown
from slipfold.long_term.regimes import NONE
from slipfold.long_term.search import ENDED, UNDECIDED, UNFINISHED, WITHIN_CELL, WITHIN_ERROR
from slipfold.models.quantities import Parameter
from slipfold.parameter_space.threshold_map import INTERRUPTED
from slipfold.plots.loci import draw_loci, legend_options
from slipfold.plots.regions import COLORS, OTHERS, grouped
from slipfold.plots.style import (
    add_color_bar,
    axes_or_new,
    cell_edges,
    label_axis,
    label_of,
    legend_below,
    panels_of,
    quantity_text,
)
from slipfold.results.attractors import PHASE, Basins, in_words
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.study import StudyResult
from slipfold.results.thresholds import ThresholdMap
from slipfold.results.trajectories import RegimeMap
from slipfold.studies.plan import Grid
from slipfold.studies.works import CaseField
from slipfold.text import headed

Edges = tuple[Array, Array]

NUMBERS = "plasma"
"""Colors of numbers, from low to high: they grow lighter."""

WORDS = "tab10"
"""Colors of words."""

HATCHES = ("//", "xx", "..", "\\\\", "--", "||", "++")
"""Hatches of failures, the most frequent kind first; later kinds get them again, closer."""

PALE, INK = "0.93", "0.55"
"""Ground and ink of hatched failures: no color of a threshold."""

BASINS = ("#c3ded6", "#0d0887", *OTHERS)
"""Colors of basins, in the order of their attractors: the first two differ most in lightness."""

NO_ATTRACTOR = {
    UNFINISHED: ("white", "not finished"),
    ENDED: ("0.35", "ended"),
    UNDECIDED: ("0.75", "undecided"),
}
"""Colors and names of starts that converged to no attractor."""

UNCERTAIN = {
    WITHIN_CELL: ((1.0, 1.0, 1.0, 0.6), "changes within the cell"),
    WITHIN_ERROR: ((0.55, 0.55, 0.55, 1.0), "changes within the error"),
}
"""What is laid over cells whose label is uncertain."""

DOTTED, COEXISTING, SAME_KIND = "....", "////", "\\\\\\\\"
"""Hatches of regimes: undecided, others that coexist, and others of the same kind."""

MAX_PARAMETERS = 4
"""Parameters that a matrix of maps shows."""

PANEL = (3.2, 2.6)
"""Inches that one of many panels gets."""


def draw_threshold_map(found: ThresholdMap, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Draw thresholds as colors over the plane of the grid's parameters.

    Each point of the grid colors the part of the plane that is nearest to it. Contour lines are
    interpolated. Parts without a threshold are hatched, each kind of failure in its own way; what
    an interruption left is white. Angles are shown in degrees; the data of the axes are radians.
    """
    ax = axes_or_new(ax)
    orders = [np.argsort(values) for values in found.over.values()]
    x, y = (values[order] for values, order in zip(found.over.values(), orders, strict=True))
    chosen = np.ix_(*orders)
    values, kinds = found.values[chosen].T, found.kinds[chosen].T
    edges = cell_edges(x), cell_edges(y)
    if np.isfinite(values).any():
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        mesh = _color(ax, edges, values, NUMBERS, low, high)
        parameter, bar = found.model.parameter(found.threshold), add_color_bar(ax, mesh)
        label_axis(bar, "y", parameter)
        bar.set_ylabel(f"{bar.get_ylabel()} at the first {found.type}")
        if min(values.shape) > 1:
            _draw_contours(ax, (x, y), values, np.asarray(bar.get_yticks()), mesh, parameter)
    handles = []
    names = [name for name in found.failures if name != INTERRUPTED]
    for number, name in enumerate(names):
        closer, which = divmod(number, len(HATCHES))
        style: dict[str, Any] = {
            "facecolor": PALE,
            "edgecolor": INK,
            "hatch": HATCHES[which] * (closer + 1),
        }
        _hatch(ax, edges, kinds == name, zorder=0.5, label=name, **style)
        handles.append(Patch(linewidth=0.4, label=name, **style))
    if found.interrupted:
        handles.append(Patch(facecolor="white", edgecolor=INK, linewidth=0.4, label=INTERRUPTED))
    _frame(ax, edges, [found.model.parameter(name) for name in found.axes])
    if legend and handles:
        legend_below(ax, 4.0, handles=handles, title="no threshold", handlelength=2.8)
    return ax


def _draw_contours(
    ax: Axes,
    places: tuple[Array, Array],
    values: Array,
    ticks: Array,
    mesh: Any,
    parameter: Parameter,
) -> None:
    levels = ticks[(ticks > np.nanmin(values)) & (ticks < np.nanmax(values))]
    if not len(levels):
        return
    # White on the dark half of the colors, black on the light one.
    colors = ["white" if mesh.norm(level) < 0.5 else "black" for level in levels]
    shown = np.ma.masked_invalid(values)
    lines = ax.contour(*places, shown, levels=levels, colors=colors, linewidths=0.6)
    texts = {  # without the unit, which stands at the color bar
        level: quantity_text(parameter, float(level)).removesuffix(f" {parameter.unit}")
        for level in levels
    }
    ax.clabel(lines, fmt=texts, fontsize=6.5)


def draw_basins(found: Basins, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Draw each start in the color of the attractor that its trajectory converged to.

    Cells within which the label changes are paler, those where it changes within the error of the
    integration are gray.
    """
    ax = axes_or_new(ax)
    own = [BASINS[number % len(BASINS)] for number in range(len(found))]
    colors = [*(color for color, _ in NO_ATTRACTOR.values()), *own]
    place: dict[str, Any] = {
        "origin": "lower",
        "extent": (*_around(found.first), *_around(found.second)),
        "aspect": "auto",
        "interpolation": "nearest",
    }
    shown = found.labels - UNFINISHED  # from zero
    ax.imshow(shown, cmap=ListedColormap(colors), vmin=-0.5, vmax=len(colors) - 0.5, **place)
    levels = [(level, *UNCERTAIN[level]) for level in UNCERTAIN if (found.uncertain == level).any()]
    if levels:
        over = np.zeros((*found.labels.shape, 4))
        for level, color, _ in levels:
            over[found.uncertain == level] = color
        ax.imshow(over, **place)
    across, up = (
        f"{axis.name} ({axis.unit})" if axis is PHASE else label_of(found.model, axis.name)
        for axis in found.axes
    )
    ax.set_xlabel(across)
    ax.set_ylabel(up)
    if legend:
        edge: dict[str, Any] = {"edgecolor": "0.55", "linewidth": 0.4}
        handles = [
            Patch(
                facecolor=color, label=f"{in_words(item)}: {_percent(found.fraction(item).value)}"
            )
            for color, item in zip(own, found, strict=True)
        ]
        handles += [
            Patch(facecolor=color, label=name, **edge)
            for label, (color, name) in NO_ATTRACTOR.items()
            if (found.labels == label).any()
        ]
        for level, (shade, *_, opaque), name in levels:
            over_gray = str(opaque * shade + 0.5 * (1 - opaque))
            label = f"{name}: {_percent((found.uncertain == level).mean())}"
            handles.append(Patch(facecolor=over_gray, label=label, **edge))
        legend_below(ax, 4.0, handles=handles, ncols=min(len(handles), 3))
    return ax


def _around(values: Array) -> tuple[float, float]:
    """Return where the outermost cells end: half a step beyond their starts."""
    half = 0.5 * (values[-1] - values[0]) / (len(values) - 1)
    return float(values[0] - half), float(values[-1] + half)


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.3g} %"


def draw_regimes(
    found: RegimeMap,
    ax: Axes | None = None,
    *,
    run: str = "rest",
    over: LocusDiagram | None = None,
    legend: bool = True,
) -> Axes:
    """Draw what the trajectories of one run do as colors, and what those of others do besides.

    A hatch has the color of the other regime; it is dark where only the responses differ. Lines of
    a bifurcation set may be drawn over it. What is undecided is dotted, what is not done white.
    """
    ax = axes_or_new(ax)
    first, second = found.over.values()
    edges = cell_edges(first), cell_edges(second)
    named, order = grouped(found.names(run)), list(COLORS)
    numbers = np.vectorize(order.index)(named).T
    _color(ax, edges, numbers, ListedColormap(list(COLORS.values())), -0.5, len(order) - 0.5)
    masks = _coexisting(found, named)
    _hatch(ax, edges, (named == "undecided").T, edgecolor="0.6", hatch=DOTTED, zorder=0.2)
    for name, mask in sorted(masks.items()):
        style = ("0.25", SAME_KIND) if name == "" else (COLORS[name], COEXISTING)
        _hatch(ax, edges, mask.T, edgecolor=style[0], hatch=style[1], zorder=0.2)
    if over is not None:
        draw_loci(over, ax, regions=False, legend=False)
    _frame(ax, edges, [found.model.parameter(name) for name in found.axes])
    if legend:
        handles: list[Artist] = [
            Patch(facecolor=COLORS[name], edgecolor="0.5", linewidth=0.4, label=name,
                  hatch=DOTTED if name == "undecided" else None)
            for name in order
            if (named == name).any() or name in masks
        ]  # fmt: skip
        for hatch, text, known in (
            (COEXISTING, "coexisting, in the other's color", masks.keys() - {""}),
            (SAME_KIND, "coexisting, of the same kind", "" in masks),
        ):
            if known:
                handles.append(Patch(facecolor="white", edgecolor="0.25", hatch=hatch,
                                     linewidth=0.4, label=text))  # fmt: skip
        if over is not None:
            lines = legend_options([over], regions=False, width=0.0)["handles"]
            handles += [handle for handle in lines if str(handle.get_label()).strip()]
        ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return ax


def _coexisting(found: RegimeMap, named: Any) -> dict[str, Mask]:
    """Return where other runs reach each other regime; by "" where one of the same kind."""
    masks: dict[str, Mask] = {}
    free = found.coexist
    for run in found.runs:
        others = grouped(found.names(run))
        for name in set(others[free].tolist()) - {"undecided", "not done", "stopped", NONE}:
            own = free & (others == name) & (named != name)
            masks[name] = masks.get(name, False) | own
            free = free & ~own
    return {name: mask for name, mask in {**masks, "": free}.items() if mask.any()}


def draw_study(found: StudyResult, quantity: str | None = None, *, ax: Axes | None = None) -> Any:
    """Draw what was found over what differs from case to case.

    Over one parameter of a grid as a line, over two as a map; a third one goes from map to map in
    a row, a fourth one from row to row. Listed and drawn cases are dots over each parameter. Cases
    without a value are left out. Returns the axes: many of them as an array.
    """
    item = _quantity(found, quantity)
    values, words = _numbers(found, item)
    if isinstance(found.cases, Grid):
        if len(found.cases.names) > 1:
            return _draw_panels(found, found.cases, item, values, words, ax)
        columns, style = found.cases.values(np.arange(len(found))), ".-"
        order = np.argsort(columns[:, 0])
        columns, values = columns[order], values[order]
    else:
        columns, style = found.cases.values(np.arange(len(found))), "."
    panels = panels_of(ax, 1, len(found.cases.names), PANEL, sharey=True)[0]
    for place, (panel, name) in enumerate(zip(panels, found.cases.names, strict=True)):
        panel.plot(columns[:, place], values, style)
        label_axis(panel, "x", found.model.parameter(name))
    panels[0].set_ylabel(_headed(item))
    if words is not None:
        panels[0].set_yticks(range(len(words)), words)
    return panels[0] if len(panels) == 1 else panels


def _quantity(found: StudyResult, name: str | None) -> CaseField:
    if name is None:
        return next(item for item in found.quantities if item.kind != "text")
    items = {item.name: item for item in found.quantities}
    if name not in items:
        raise unknown("the study has no quantity", name, items)
    return items[name]


def _numbers(found: StudyResult, item: CaseField) -> tuple[Array, list[str] | None]:
    """Return what is drawn, and which words its numbers stand for; cases that failed have none."""
    values: Any = found.values[item.name]
    words = None
    if item.unit == "rad":
        values = np.degrees(values)
    if item.kind == "text":
        words = sorted({str(value) for value in values if value})
        values = np.array([words.index(value) if value else np.nan for value in values])
    values = np.where(found.reasons == "", values.astype(float), np.nan)
    if not np.isfinite(values).any():
        reason = next((str(reason) for reason in found.reasons if reason), "")
        raise InputError(
            f"no case has a value of {item.name}, so there is nothing to draw"
            f"{': ' * bool(reason)}{reason}; choose another quantity"
        )
    return values, words


def _draw_panels(
    found: StudyResult,
    grid: Grid,
    item: CaseField,
    values: Array,
    words: list[str] | None,
    ax: Axes | None,
) -> Any:
    if len(grid.names) > MAX_PARAMETERS:
        raise InputError(
            f"the study has {len(grid.names)} parameters and a figure shows {MAX_PARAMETERS}; "
            "choose some values by to_xarray().sel(...)"
        )
    orders = [np.argsort(places) for places in grid.axes.values()]
    values = values.reshape(grid.shape)[np.ix_(*orders)]
    places = [column[order] for column, order in zip(grid.axes.values(), orders, strict=True)]
    values = values.reshape(*values.shape, *[1] * (MAX_PARAMETERS - values.ndim))
    parameters = [found.model.parameter(name) for name in grid.names]
    panels = panels_of(ax, values.shape[3], values.shape[2], PANEL, sharex=True, sharey=True)
    edges = cell_edges(places[0]), cell_edges(places[1])
    colors: Any = NUMBERS
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if words is not None:
        low, high, tab = -0.5, len(words) - 0.5, colormaps[WORDS]
        colors = ListedColormap([tab(place % tab.N) for place in range(len(words))])
    for (row, column), panel in np.ndenumerate(panels):
        mesh = _color(panel, edges, values[:, :, column, row].T, colors, low, high)
        at = zip(parameters[2:], places[2:], (column, row), strict=False)
        panel.set_title(
            ", ".join(f"{one.name} = {quantity_text(one, part[place])}" for one, part, place in at)
        )
        if row == len(panels) - 1:
            label_axis(panel, "x", parameters[0])
        if column == 0:
            label_axis(panel, "y", parameters[1])
    if words is None:
        panels[0, 0].get_figure(root=True).colorbar(mesh, ax=panels, label=_headed(item))
    else:
        handles = [Patch(color=colors(place), label=word) for place, word in enumerate(words)]
        place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0)}
        panels[0, -1].legend(handles=handles, title=item.name, **place)
    return panels[0, 0] if panels.size == 1 else panels


def _headed(item: CaseField) -> str:
    """Return the name of a quantity with its unit; angles are shown in degrees."""
    return f"{item.name} (°)" if item.unit == "rad" else headed(item)


def _color(ax: Axes, edges: Edges, values: Any, colors: Any, low: float, high: float) -> Any:
    """Draw cells in colors, as a picture: viewers show hairlines between cells of a drawing."""
    shown = np.ma.masked_invalid(values)
    return ax.pcolormesh(*edges, shown, cmap=colors, vmin=low, vmax=high, rasterized=True, zorder=0)


def _hatch(ax: Axes, edges: Edges, mask: Mask, facecolor: str = "none", **style: Any) -> None:
    """Hatch some cells together, so that the hatch runs on from one to the next."""
    if not mask.any():
        return
    rows, columns = np.nonzero(mask)
    x, y = edges
    left, right, bottom, top = x[columns], x[columns + 1], y[rows], y[rows + 1]
    corners = [(left, bottom), (right, bottom), (right, top), (left, top), (left, bottom)]
    vertices = np.array(corners).transpose(2, 0, 1).reshape(-1, 2)
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
    outline = Path(vertices, np.tile(codes, len(rows)))
    ax.add_patch(PathPatch(outline, facecolor=facecolor, linewidth=0.0, **style))


def _frame(ax: Axes, edges: Edges, parameters: Sequence[Parameter]) -> None:
    ax.set_xlim(edges[0][0], edges[0][-1])
    ax.set_ylim(edges[1][0], edges[1][-1])
    label_axis(ax, "x", parameters[0])
    label_axis(ax, "y", parameters[1])
