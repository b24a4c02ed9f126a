"""The figures of bifurcation sets, drawn from what was computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas
from matplotlib.patches import Polygon

from slipfold.loci.locus import Locus
from slipfold.loci.region_map import RegionMap
from slipfold.loci.window import Window
from slipfold.models.model import Model
from slipfold.paper.cases import equation_text
from slipfold.paper.figure_files import figure_files
from slipfold.paper.planes import Plane, PlaneFigure
from slipfold.plots.loci import HasLoci, draw_loci, legend_options, name_loci
from slipfold.plots.style import COLUMN, figure_style

HEIGHT = 2.6
WIDE_HEIGHTS = (3.3, 2.4)
LEGEND_HEIGHT = 0.8

CONTACT = ("Ns", "Nd")
"""The plane in which a line parts contact all the time from none at times."""

LOWEST = ("PD",)
"""Loci whose lowest point is written beside it."""


def draw_plane(figure: PlaneFigure, diagram: HasLoci) -> Canvas:
    """Draw a bifurcation set, whole and in detail."""
    diagram = _without_lost_contact(diagram)
    heights = WIDE_HEIGHTS if figure.wide else (HEIGHT,)
    canvas = Canvas(figsize=(2 * COLUMN, sum(heights) + LEGEND_HEIGHT), layout="constrained")
    # It knows the size of a text at once; without it, every question draws the figure anew.
    FigureCanvasAgg(canvas)
    grid = canvas.add_gridspec(len(heights), 2 // len(heights), height_ratios=heights)
    whole, detail = (canvas.add_subplot(grid[place]) for place in (0, 1))
    for ax, view in ((whole, figure.plane.window), (detail, figure.detail)):
        draw_loci(diagram, ax, window=view, annotate=False, legend=False)
        _draw_contact_limit(ax, figure.plane, view)
    _draw_frame(whole, figure.detail)
    fixed = ("alpha", "Vd", "Ns", "mu") if "f" in figure.plane.vary else ("f",)
    equations = ", ".join(equation_text(figure.plane.model, name) for name in fixed)
    whole.set_title(f"(a)  {equations}")
    detail.set_title("(b)  detail of (a)")
    canvas.legend(**legend_options([diagram]), loc="outside lower center")
    # Names come last: where they cover nothing is known when the layout is, which then stays.
    canvas.draw_without_rendering()
    canvas.set_layout_engine(None)  # "none" would draw it once more for each file
    name_loci(whole, diagram, lowest=LOWEST, without=figure.detail)
    name_loci(detail, diagram, lowest=LOWEST)
    return canvas


def render_plane(figure: PlaneFigure, diagram: HasLoci) -> dict[str, bytes]:
    """Draw a bifurcation set as PDF and PNG."""
    with figure_style():
        return figure_files(draw_plane(figure, diagram), figure.key)


@dataclass(frozen=True)
class _Shown:
    """A bifurcation set as it is drawn."""

    model: Model
    vary: tuple[str, str]
    window: Window
    loci: Sequence[Locus]
    regions: RegionMap | None


def _without_lost_contact(diagram: HasLoci) -> HasLoci:
    """Take the regions away where the tip lifts off: there the model says nothing."""
    regions = diagram.regions
    if diagram.vary != CONTACT or regions is None:
        return diagram
    labels = np.where(regions.second[:, None] < regions.first, regions.labels, 0)
    regions = replace(regions, labels=labels)
    return _Shown(diagram.model, diagram.vary, diagram.window, diagram.loci, regions)


def _draw_frame(ax: Axes, view: Window) -> None:
    """Frame what is magnified, with a line, which names keep off."""
    (left, right), (bottom, top) = view
    ax.plot(
        [left, right, right, left, left],
        [bottom, bottom, top, top, bottom],
        color="0.35",
        linewidth=0.6,
    )


def _draw_contact_limit(ax: Axes, plane: Plane, view: Window) -> None:
    """Hatch where the amplitude of the normal force exceeds its static part: the tip lifts off."""
    if plane.vary != CONTACT:
        return
    (left, right), (bottom, top) = view
    if top <= left:
        return
    ends = np.array([max(left, bottom), min(right, top)])
    corners = [*zip(ends, ends, strict=True), (ends[1], top), (left, top), (left, ends[0])]
    ax.add_patch(
        Polygon(corners, facecolor="white", edgecolor="0.8", hatch="////", linewidth=0.0, zorder=1)
    )
    ax.plot(ends, ends, color="black", linewidth=0.8, zorder=1.5)
    ax.text(
        left + 0.25 * (right - left),
        bottom + 0.7 * (top - bottom),
        "tip lifts off: $N_d > N_s$",
        fontsize=7.0,
        ha="center",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5},
    )
