"""The figures of the paper, drawn from what was computed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from slipfold.branches.special_point import BIFURCATIONS
from slipfold.long_term.spectrum import Spectrum
from slipfold.paper.cases import Curve, Figure, Row, Steady, equation_text, value_text
from slipfold.paper.figure_files import figure_files
from slipfold.paper.legend import draw_legend
from slipfold.plots.response import HasBranches, draw_family, marks_of, name_family
from slipfold.plots.style import COLUMN, figure_style, palette
from slipfold.plots.trajectories import draw_spectrum, name_lines

OUTPUTS = ("y", "x")
"""Left and right panel of a row, as in the paper."""

ROW_HEIGHT = 2.45
WIDE_HEIGHT = 3.1
DETAIL_HEIGHT = 1.95
SPECTRUM_HEIGHT = 1.7
LEGEND_HEIGHT = 0.55


@dataclass(frozen=True)
class _Panel:
    """Axes with a family in them, whose names are still to be placed."""

    ax: Axes
    row: Row
    diagrams: Sequence[HasBranches]
    output: str
    without: tuple[float, float] | None = None


def draw_figure(
    figure: Figure,
    diagrams: Mapping[Curve, HasBranches],
    spectra: Mapping[Steady, Spectrum],
    measure: str = "max",
) -> Canvas:
    """Draw one figure of the paper."""
    heights = _heights(figure)
    canvas = Canvas(figsize=(2 * COLUMN, sum(heights) + LEGEND_HEIGHT), layout="constrained")
    grid = canvas.add_gridspec(len(heights), 2, height_ratios=heights)
    lines = iter(range(len(heights)))
    letters = (f"({chr(ord('a') + number)})" for number in count())
    panels: list[_Panel] = []
    for row in figure.rows:
        found = [diagrams[curve] for curve in row.curves]
        if row.wide:
            axes = [canvas.add_subplot(grid[next(lines), :]) for _ in OUTPUTS]
        else:
            line = next(lines)
            axes = [canvas.add_subplot(grid[line, column]) for column in (0, 1)]
        drawn = _draw_row(axes, row, found, letters, measure)
        panels += drawn
        if row.detail is not None:
            line = next(lines)
            axes = [canvas.add_subplot(grid[line, column]) for column in (0, 1)]
            panels += _draw_details(axes, drawn, row.detail, measure)
    spectral: list[tuple[Axes, Spectrum, str]] = []
    for case in figure.spectra:
        line = next(lines)
        for column, output in enumerate(OUTPUTS):
            ax = canvas.add_subplot(grid[line, column])
            draw_spectrum(spectra[case], output, ax, palette(1)[0], annotate=False)
            settings = ", ".join(equation_text(case.model, name) for name in ("f", "Nd"))
            ax.set_title(f"{next(letters)}  {settings}")
            spectral.append((ax, spectra[case], output))
    draw_legend(canvas, [diagrams[curve] for curve in figure.curves], measure)
    # Names come last: where they cover nothing is known when the layout is, which then stays.
    canvas.draw_without_rendering()
    canvas.set_layout_engine(None)  # "none" would draw it once more for each file
    for panel in panels:
        _name(panel, measure)
    for ax, spectrum, output in spectral:
        name_lines(ax, spectrum, output, palette(1)[0])
    return canvas


def render_figure(
    figure: Figure,
    diagrams: Mapping[Curve, HasBranches],
    spectra: Mapping[Steady, Spectrum],
    measure: str = "max",
) -> dict[str, bytes]:
    """Draw one figure of the paper as PDF and PNG."""
    with figure_style():
        return figure_files(draw_figure(figure, diagrams, spectra, measure), figure.key)


def _heights(figure: Figure) -> list[float]:
    heights = []
    for row in figure.rows:
        heights += [WIDE_HEIGHT] * 2 if row.wide else [ROW_HEIGHT]
        if row.detail is not None:
            heights.append(DETAIL_HEIGHT)
    return heights + [SPECTRUM_HEIGHT] * len(figure.spectra)


def _draw_row(
    axes: Sequence[Axes],
    row: Row,
    diagrams: Sequence[HasBranches],
    letters: Iterator[str],
    measure: str,
) -> list[_Panel]:
    panels = []
    for ax, output in zip(axes, OUTPUTS, strict=True):
        draw_family(diagrams, output, measure, ax)
        ax.margins(x=0.01, y=0.06)
        ax.autoscale_view()
        ax.set_title(f"{next(letters)}  {_common(row)}")
        panels.append(_Panel(ax, row, diagrams, output, row.detail))
    return panels


def _draw_details(
    axes: Sequence[Axes], panels: Sequence[_Panel], span: tuple[float, float], measure: str
) -> list[_Panel]:
    """Draw the panels once more, near their thresholds, and frame there what is magnified."""
    details = []
    for ax, panel in zip(axes, panels, strict=True):
        draw_family(panel.diagrams, panel.output, measure, ax)
        values = [
            mark.value
            for diagram in panel.diagrams
            for branch in diagram.branches
            for mark in marks_of(branch, panel.output, measure)
            if mark.type in BIFURCATIONS and span[0] <= mark.parameter <= span[1]
        ]
        whole = np.ptp(panel.ax.get_ylim())
        low, high = (min(values), max(values)) if values else panel.ax.get_ylim()
        room = max(0.4 * (high - low), 0.02 * whole)
        ax.set_xlim(span)
        ax.set_ylim(low - room, high + room)
        ax.xaxis.set_major_locator(MaxNLocator(5))
        ax.set_title(f"detail of {panel.ax.get_title(loc='left').split()[0]}")
        size = span[1] - span[0], high - low + 2 * room
        frame = Rectangle((span[0], low - room), *size, fill=False, color="0.6", linewidth=0.6)
        panel.ax.add_patch(frame)
        details.append(_Panel(ax, panel.row, panel.diagrams, panel.output))
    return details


def _name(panel: _Panel, measure: str) -> None:
    model = panel.row.curves[0].model
    unit = value_text(model, panel.row.member)[1]
    names = [f"{name}{unit}" for name in panel.row.names]
    name_family(panel.ax, panel.diagrams, names, panel.output, measure, without=panel.without)


def _common(row: Row) -> str:
    """Return what holds for all curves of a row, and what tells them apart."""
    model = row.curves[0].model
    shown = [*row.common]
    if "f" not in (row.member, row.curves[0].vary, *shown):
        shown.append("f")
    equations = ", ".join(equation_text(model, name) for name in shown)
    symbol = model.parameter(row.member).symbol
    return f"{equations}; {symbol} as marked" if equations else f"{symbol} as marked"
