"""Figures of studies: lines over one parameter, maps over two, and many maps side by side."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.patches import Patch
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.plots.angles import label_axis, quantity_text
from slipfold.plots.axes import axes_or_new, cell_edges
from slipfold.results.studies.study_result import StudyResult
from slipfold.studies.cases import Grid
from slipfold.studies.work.work import Quantity
from slipfold.text.one_line import headed

COLOURS = "plasma"

WORDS = "tab10"
"""Colours of words."""

MOST = 4
"""Parameters that a matrix of maps shows."""

PANEL = (3.2, 2.6)
"""Inches that one of many panels gets."""


def draw_study(found: StudyResult, quantity: str | None = None, *, ax: Axes | None = None) -> Any:
    """Draw what was found over what differs from case to case.

    Over one parameter of a grid as a line, over two as a map; a third one goes from map to map in
    a row, a fourth one from row to row. Listed and drawn cases are dots over each parameter. Cases
    without a value are left out. Returns the axes: many of them as an array.
    """
    item = _chosen(found, quantity)
    if isinstance(found.cases, Grid):
        return _draw_grid(found, found.cases, item, ax)
    return _draw_dots(found, item, ax)


def _chosen(found: StudyResult, name: str | None) -> Quantity:
    if name is None:
        numbers = [item for item in found.quantities if item.kind != "text"]
        return numbers[0]
    for item in found.quantities:
        if item.name == name:
            return item
    known = ", ".join(item.name for item in found.quantities)
    raise InputError(f"the study has no quantity {name!r}; it has {known}")


def _draw_grid(found: StudyResult, grid: Grid, item: Quantity, ax: Axes | None) -> Any:
    if len(grid.names) > MOST:
        raise InputError(
            f"the study has {len(grid.names)} parameters and a figure shows {MOST}; choose some "
            "values by to_xarray().sel(...)"
        )
    values, words = _numbers(found, item)
    values = values.reshape(grid.shape)
    orders = [np.argsort(places) for places in grid.axes.values()]
    values = values[np.ix_(*orders)]
    places = [column[order] for column, order in zip(grid.axes.values(), orders, strict=True)]
    if len(grid.names) == 1:
        ax = axes_or_new(ax)
        ax.plot(places[0], values, ".-")
        label_axis(ax, "x", found.model.parameter(grid.names[0]))
        _label_values(ax, item, words)
        return ax
    values = values.reshape(*values.shape, *[1] * (MOST - values.ndim))
    columns, rows = values.shape[2:]
    panels = _panels(rows, columns, ax)
    scale = Normalize(*_range(values, words))
    colours: Any = COLOURS if words is None else _word_colours(words)
    for row in range(rows):
        for column in range(columns):
            panel = panels[row, column]
            shown = np.ma.masked_invalid(values[:, :, column, row].T)
            edges = [cell_edges(part) for part in places[:2]]
            mesh = panel.pcolormesh(*edges, shown, cmap=colours, norm=scale, rasterized=True)
            at = [
                quantity_text(found.model.parameter(name), part[place])
                for name, part, place in zip(
                    grid.names[2:], places[2:], (column, row), strict=False
                )
            ]
            named = zip(grid.names[2:], at, strict=True)
            panel.set_title(", ".join(f"{name} = {text}" for name, text in named))
            if row == rows - 1:
                label_axis(panel, "x", found.model.parameter(grid.names[0]))
            if column == 0:
                label_axis(panel, "y", found.model.parameter(grid.names[1]))
    figure = panels[0, 0].get_figure(root=True)
    if words is None:
        figure.colorbar(mesh, ax=panels, label=_headed(item))
    else:
        handles = [Patch(color=colours(place), label=word) for place, word in enumerate(words)]
        panels[0, -1].legend(handles=handles, title=item.name)
    return panels[0, 0] if panels.size == 1 else panels


def _draw_dots(found: StudyResult, item: Quantity, ax: Axes | None) -> Any:
    values, words = _numbers(found, item)
    rows = found.cases.values(np.arange(len(found)))
    names = found.cases.names
    panels = _panels(1, len(names), ax)[0]
    for place, (panel, name) in enumerate(zip(panels, names, strict=True)):
        panel.plot(rows[:, place], values, ".")
        label_axis(panel, "x", found.model.parameter(name))
    _label_values(panels[0], item, words)
    return panels[0] if len(names) == 1 else panels


def _panels(rows: int, columns: int, ax: Axes | None) -> NDArray[np.object_]:
    """Return axes side by side and one below the other, shape (rows, columns)."""
    if rows * columns == 1:
        one = np.empty((1, 1), object)
        one[0, 0] = axes_or_new(ax)
        return one
    given, ax = ax, axes_or_new(ax)
    figure, place = ax.get_figure(root=True), ax.get_subplotspec()
    if place is None or figure is None:
        raise InputError("the axes given have no place in a figure that could be divided")
    if given is None:
        figure.set_size_inches(PANEL[0] * columns, PANEL[1] * rows)
    ax.remove()
    made: NDArray[np.object_] = place.subgridspec(rows, columns).subplots(
        sharex=rows > 1, sharey=True, squeeze=False
    )
    return made


def _numbers(found: StudyResult, item: Quantity) -> tuple[NDArray[np.float64], list[str] | None]:
    """Return what is drawn, and which words its numbers stand for; cases that failed have none."""
    values: Any = found.values[item.name]
    words = None
    if item.unit == "rad":
        values = np.degrees(values)
    if item.kind == "text":
        words = sorted({str(value) for value in values if value})
        values = np.array([words.index(value) if value else np.nan for value in values])
    return np.where(found.reasons == "", values.astype(float), np.nan), words


def _range(values: NDArray[np.float64], words: list[str] | None) -> tuple[float, float]:
    if words is not None:
        return -0.5, max(len(words), 1) - 0.5
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)


def _word_colours(words: list[str]) -> ListedColormap:
    from matplotlib import colormaps

    tab = colormaps[WORDS]
    return ListedColormap([tab(place % tab.N) for place in range(max(len(words), 1))])


def _label_values(ax: Axes, item: Quantity, words: list[str] | None) -> None:
    ax.set_ylabel(_headed(item))
    if words is not None:
        ax.set_yticks(range(len(words)), words)


def _headed(item: Quantity) -> str:
    """Return the name of a quantity with its unit; angles are shown in degrees."""
    return f"{item.name} (°)" if item.unit == "rad" else headed(item)
