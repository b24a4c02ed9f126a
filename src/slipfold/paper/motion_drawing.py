"""Figures of what motions do, drawn from what was computed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from slipfold.lines import OTHER, STABLE, torus_stretches
from slipfold.long_term.sweep import DOWN, UP
from slipfold.paper.cases import Curve, equation_text
from slipfold.paper.figure_files import figure_files
from slipfold.paper.legend import draw_legend
from slipfold.paper.motions import (
    CompletedFigure,
    HysteresisFigure,
    MotionFigure,
    RegimeFigure,
    SweepCase,
)
from slipfold.plots.maps import BASINS, draw_basins, draw_regimes
from slipfold.plots.response import draw_family, name_family
from slipfold.plots.style import COLUMN, LINES, figure_style
from slipfold.plots.trajectories import COLOURS, OTHERS, SIZE, dots_of
from slipfold.results.attractors import Basins, in_words
from slipfold.results.trajectories import Sweep
from slipfold.tori.torus_branch import TorusBranch

OUTPUTS = ("y", "x")
"""Left and right panel of a row, as in the paper."""

ROW_HEIGHT, LEGEND_HEIGHT = 2.3, 0.6

BASIN_HEIGHT = 2.6

LAST = 1000
"""Place, among those of periods, of what does not repeat."""

DOTS = {UP: "motions swept up", DOWN: "swept down", "": "from many starts"}

BESIDE = {UP: 5.0, DOWN: 3.0}
"""Sizes in points of dots of motions that repeat, which lie on a line of the diagram."""

TORUS = "#ffc20a"
"""Colour of tori, to be seen on dots of motions; they have a dark edge."""

ROOM = 0.06
"""Room above and below what is drawn, over its height."""


def draw_motions(figure: MotionFigure, found: Mapping[Any, Any], measure: str = "max") -> Canvas:
    """Draw one of them."""
    if isinstance(figure, CompletedFigure):
        return _completed(figure, found, measure)
    if isinstance(figure, HysteresisFigure):
        return _hysteresis(figure, found, measure)
    return _regimes(figure, found)


def render_motions(
    figure: MotionFigure, found: Mapping[Any, Any], measure: str = "max"
) -> dict[str, bytes]:
    """Draw one of them as PDF and PNG."""
    with figure_style():
        return figure_files(draw_motions(figure, found, measure), figure.key)


def _completed(figure: CompletedFigure, found: Mapping[Any, Any], measure: str) -> Canvas:
    rows = len(figure.curves)
    canvas = Canvas(figsize=(2 * COLUMN, rows * ROW_HEIGHT + LEGEND_HEIGHT), layout="constrained")
    letters = (f"({chr(ord('a') + number)})" for number in count())
    naming = []
    for axes, curve, swept in zip(
        canvas.subplots(rows, 2, squeeze=False), figure.curves, figure.sweeps, strict=True
    ):
        for ax, output in zip(axes, OUTPUTS, strict=True):
            naming.append(_draw_both(ax, curve, swept, output, found, measure))
            ax.set_title(f"{next(letters)}  {_fixed(curve)}")
    diagrams = [found[curve] for curve in figure.curves]
    tori = [tori for diagram in diagrams for tori in diagram.tori]
    more = _more(tori, [found[swept] for swept in figure.sweeps])
    draw_legend(canvas, diagrams, measure, more, [swept.span for swept in figure.sweeps])
    _name(canvas, naming)
    return canvas


def _hysteresis(figure: HysteresisFigure, found: Mapping[Any, Any], measure: str) -> Canvas:
    heights = ROW_HEIGHT, BASIN_HEIGHT
    canvas = Canvas(figsize=(2 * COLUMN, sum(heights) + LEGEND_HEIGHT), layout="constrained")
    grid = canvas.add_gridspec(2, 1, height_ratios=heights)
    above, below = (grid[row].subgridspec(1, n) for row, n in ((0, 2), (1, len(figure.basins))))
    naming = []
    for place, output in enumerate(OUTPUTS):
        ax = canvas.add_subplot(above[place])
        naming.append(_draw_both(ax, figure.curve, figure.swept, output, found, measure))
        ax.set_title(f"({'ab'[place]})  {_fixed(figure.curve)}")
    for place, case in enumerate(figure.basins):
        ax = canvas.add_subplot(below[place])
        seen = _by_period(found[case])
        draw_basins(seen, ax, legend=False)
        if place:
            ax.set_ylabel("")
        share = f"{100 * seen.share(seen[0]).value:.2g} % {in_words(seen[0])}"
        at = equation_text(case.model, figure.curve.vary)
        ax.set_title(f"({'cdefgh'[place]})  {at}\n{share}")
    most = max((_by_period(found[case]) for case in figure.basins), key=len)
    patches = [
        Patch(facecolor=colour, label=f"basin of {in_words(item)}")
        for item, colour in zip(most, BASINS, strict=False)
    ]
    if any((found[case].uncertain > 0).any() for case in figure.basins):
        patches.append(Patch(facecolor="0.92", edgecolor="0.55", label="crossed by a boundary"))
    more = [*_more(found[figure.curve].tori, [found[figure.swept]]), *patches]
    draw_legend(canvas, [found[figure.curve]], measure, more, [figure.swept.span])
    _name(canvas, naming)
    return canvas


def _regimes(figure: RegimeFigure, found: Mapping[Any, Any]) -> Canvas:
    canvas = Canvas(figsize=(2 * COLUMN, 1.25 * COLUMN), layout="constrained")
    ax = canvas.add_subplot()
    draw_regimes(found[figure.regimes], ax, over=found[figure.regimes.plane])
    return canvas


def _draw_both(
    ax: Axes,
    curve: Curve,
    swept: SweepCase,
    output: str,
    found: Mapping[Any, Any],
    measure: str,
) -> Callable[[], None]:
    """Draw branches and tori over the dots of motions; return what names them.

    The axes show what motions reach: unstable orbits may lead away from that.
    """
    diagram = found[curve]
    _draw_dots(ax, found[swept], output, measure)
    low, high = ax.dataLim.intervaly
    draw_family([diagram], output, measure, ax, ["black"])
    for tori in diagram.tori:
        for line in torus_stretches(tori, output, measure):
            ax.plot(line.parameter, line.value, **_torus_line(line.kind))
    ax.set_xlim(swept.span)
    ax.set_ylim(low - ROOM * (high - low), high + ROOM * (high - low))
    ax.xaxis.set_major_locator(MaxNLocator(5))
    return lambda: name_family(ax, [diagram], None, output, measure, ["black"])


def _draw_dots(ax: Axes, swept: Sweep, output: str, measure: str) -> None:
    """Draw what motions reach: large, where they repeat, to be seen beside the line there."""
    for name in sorted(swept.runs, key=lambda name: (name in COLOURS, swept.run(name))):
        x, y = dots_of(swept, swept.run(name), output, measure)
        single = np.isin(x, swept.values[swept.repeats(name) > 0])
        for some, size in ((single, BESIDE.get(name, SIZE)), (~single, SIZE)):
            ax.plot(
                x[some], y[some], "o", markersize=size, markeredgewidth=0,
                color=COLOURS.get(name, OTHERS), zorder=0.5, rasterized=True,
            )  # fmt: skip


def _name(canvas: Canvas, naming: list[Callable[[], None]]) -> None:
    """Name points last: where names cover nothing is known when the layout is, which then stays."""
    canvas.draw_without_rendering()
    canvas.set_layout_engine(None)
    for name in naming:
        name()


def _fixed(curve: Curve) -> str:
    other = "f" if curve.vary == "Nd" else "Nd"
    return equation_text(curve.model, other)


def _by_period(found: Basins) -> Basins:
    """Return basins with their attractors in the order of periods, so that colours tell them."""
    items = sorted(found, key=lambda item: item.period or LAST)
    labels = found.labels.copy()
    for number, item in enumerate(items, 1):
        labels[found.labels == item.id] = number
    renumbered = tuple(replace(item, id=number) for number, item in enumerate(items, 1))
    return replace(found, labels=labels, attractors=renumbered)


def _more(found: Sequence[TorusBranch], sweeps: Sequence[Sweep]) -> list[Line2D]:
    """Return what the legend says of tori and dots."""
    runs = {run if run in COLOURS else "" for swept in sweeps for run in swept.runs}
    tori = {STABLE: "torus", OTHER: "unstable torus"} if found else {}
    return [
        *(Line2D([], [], label=name, **_torus_line(kind)) for kind, name in tori.items()),
        *(
            Line2D([], [], linestyle="none", marker="o", markersize=3, markeredgewidth=0,
                   color=COLOURS.get(run, OTHERS), label=name)
            for run, name in DOTS.items()
            if run in runs
        ),
    ]  # fmt: skip


def _torus_line(kind: str) -> dict[str, Any]:
    edge = withStroke(linewidth=LINES[kind]["linewidth"] + 1.2, foreground="black")
    return {**LINES[kind], "color": TORUS, "path_effects": [edge], "zorder": 2.2}
