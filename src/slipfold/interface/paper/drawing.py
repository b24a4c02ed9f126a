"""The figures of the paper and those beyond it, drawn from what was computed."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from string import ascii_lowercase
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon, Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from slipfold.bifurcations.loci.window import Window
from slipfold.bifurcations.tori.torus_branch import TorusBranch
from slipfold.interface.paper.cases import Case, Figure, Row, equation_text, value_text
from slipfold.lines import OTHER, STABLE, torus_segments
from slipfold.long_term.spectrum import Spectrum
from slipfold.long_term.sweep import DOWN, UP
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES
from slipfold.plots.loci import draw_loci, legend_options, name_loci
from slipfold.plots.maps import BASINS, draw_basins, draw_regimes
from slipfold.plots.response import BREAKS, draw_family, marks_in, name_family, torus_handles
from slipfold.plots.style import COLUMN, LINES, MARKERS, figure_style, palette, within
from slipfold.plots.trajectories import COLORS, OTHERS, draw_points, draw_spectrum, name_lines
from slipfold.results.attractors import in_words, renumbered
from slipfold.results.diagram import Diagram
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.trajectories import Sweep


def render(figure: Figure, result: Mapping[Case, Any]) -> dict[str, bytes]:
    """Draw a figure from what was computed for it, as PDF and PNG."""
    contents = {}
    with figure_style():
        canvas = draw(figure, result)
        for suffix in ("pdf", "png"):
            memory = io.BytesIO()
            # Without the date the same numbers make the same file.
            metadata = {"CreationDate": None} if suffix == "pdf" else None
            canvas.savefig(memory, format=suffix, metadata=metadata)
            contents[f"{figure.key}.{suffix}"] = memory.getvalue()
    return contents


def draw(figure: Figure, result: Mapping[Case, Any]) -> Canvas:
    """Draw a figure."""
    return DRAWINGS[figure.kind](figure, result)


def _canvas(height: float) -> Canvas:
    canvas = Canvas(figsize=(2 * COLUMN, height), layout="constrained")
    # It knows the size of a text; without it every question would draw the figure again.
    FigureCanvasAgg(canvas)
    return canvas


def _letters() -> Iterator[str]:
    return (f"({letter})" for letter in ascii_lowercase)


def _name_last(canvas: Canvas, naming: Sequence[Callable[[], None]]) -> None:
    """Draw names last, where they cover nothing in the final layout."""
    if (layout := canvas.get_layout_engine()) is not None:
        layout.execute(canvas)
    canvas.set_layout_engine(None)  # "none" would draw it once more for each file
    for name in naming:
        name()


LINE_NAMES = {
    "stable": "stable",
    "period doubling": "unstable: period doubling",
    "fold or torus": "unstable: fold or torus",
}

MARKER_NAMES = {
    "PD": "PD, period doubling",
    "NS": "NS, Neimark–Sacker",
    "LP": "LP, fold",
    "BP": "BP, branch point",
    "LIMIT": "limit of the model",
    "FAILED": "not followed further",
}

GRAY = "0.2"

MEASURE = "max"
"""What is shown of an output over an orbit, as in the paper."""


Shown = Sequence[tuple[Axes, Sequence[Diagram], str]]
"""Axes with the diagrams and the output that they show."""


def draw_legend(canvas: Canvas, shown: Shown, more: Sequence[Artist] | None = None) -> None:
    """Explain lines and the markers that are seen below the panels; colors are named beside them.

    Given `more` it has that instead of the tori.
    """
    marks = [
        mark
        for ax, diagrams, output in shown
        for diagram in diagrams
        for mark in marks_in(diagram, output, MEASURE)
        if len(within(ax, np.array([[mark.parameter, mark.value]])))
    ]
    handles: list[Artist] = [
        Line2D([], [], color=GRAY, label=name, **LINES[kind]) for kind, name in LINE_NAMES.items()
    ]
    tori = [each for _, diagrams, _ in shown for diagram in diagrams for each in diagram.tori]
    broken = any(each.stopped.kind in BREAKS for each in tori)
    if more is None:
        handles += torus_handles(tori, GRAY)
    handles += [
        _marker(type_, name)
        for type_, name in MARKER_NAMES.items()
        if any(mark.type == type_ for mark in marks) or (type_ == "FAILED" and broken)
    ]
    if any(mark.fill == "open" for mark in marks):
        handles.append(_marker("PD", "open: subcritical", "white"))
    handles += more or []
    canvas.legend(
        handles=handles, loc="outside lower center", ncols=4, columnspacing=1.4, handlelength=2.6
    )


def _marker(type_: str, name: str, face: str = GRAY) -> Line2D:
    return Line2D(
        [], [], linestyle="none", marker=MARKERS[type_], color=GRAY, markerfacecolor=face,
        markeredgewidth=0.9, label=name,
    )  # fmt: skip


HEIGHTS = {
    "row": 2.45, "wide row": 3.1, "detail": 1.95, "spectrum": 1.7, "legend": 0.55,
    "plane": 2.6, "wide plane": 3.3, "wide detail": 2.4, "plane legend": 0.8,
    "trajectories": 2.3, "basin legend": 0.6,
}  # fmt: skip
"""Heights of panels and legends in inches."""

OUTPUTS = ("y", "x")
"""Left and right panel of a row, as in the paper."""


@dataclass(frozen=True)
class _Panel:
    """Axes with a family in them, whose names are still to be placed."""

    ax: Axes
    row: Row
    diagrams: Sequence[Diagram]
    output: str
    without: tuple[float, float] | None = None


def _family(figure: Figure, result: Mapping[Case, Any]) -> Canvas:
    """Draw one figure of the paper."""
    heights = list[float]()
    for row in figure.rows:
        heights += [HEIGHTS["wide row"]] * 2 if row.wide else [HEIGHTS["row"]]
        heights += [HEIGHTS["detail"]] * (row.detail is not None)
    heights += [HEIGHTS["spectrum"]] * len(figure.cases)
    canvas = _canvas(sum(heights) + HEIGHTS["legend"])
    grid = canvas.add_gridspec(len(heights), 2, height_ratios=heights)
    lines, letters = iter(range(len(heights))), _letters()

    def axes(*, wide: bool = False) -> list[Axes]:
        if wide:
            return [canvas.add_subplot(grid[next(lines), :]) for _ in OUTPUTS]
        line = next(lines)
        return [canvas.add_subplot(grid[line, column]) for column in (0, 1)]

    panels: list[_Panel] = []
    for row in figure.rows:
        diagrams = [result[curve] for curve in row.curves]
        drawn = _draw_row(axes(wide=row.wide), row, diagrams, letters)
        panels += drawn
        if row.detail is not None:
            panels += _draw_details(axes(), drawn, row.detail)
    spectral: list[tuple[Axes, Spectrum, str]] = []
    for case in figure.cases:
        for ax, output in zip(axes(), OUTPUTS, strict=True):
            draw_spectrum(result[case], output, ax, palette(1)[0], annotate=False)
            settings = ", ".join(equation_text(case.model, name) for name in ("f", "Nd"))
            ax.set_title(f"{next(letters)}  {settings}")
            spectral.append((ax, result[case], output))
    draw_legend(canvas, [(panel.ax, panel.diagrams, panel.output) for panel in panels])
    naming = [partial(_name, panel) for panel in panels]
    naming += [partial(name_lines, *each, palette(1)[0]) for each in spectral]
    _name_last(canvas, naming)
    return canvas


def _draw_row(
    axes: Sequence[Axes],
    row: Row,
    diagrams: Sequence[Diagram],
    letters: Iterator[str],
) -> list[_Panel]:
    panels = []
    for ax, output in zip(axes, OUTPUTS, strict=True):
        draw_family(diagrams, output, MEASURE, ax)
        ax.margins(x=0.01, y=0.06)
        ax.autoscale_view()
        ax.set_title(f"{next(letters)}  {_common(row)}")
        panels.append(_Panel(ax, row, diagrams, output, row.detail))
    return panels


def _draw_details(
    axes: Sequence[Axes], panels: Sequence[_Panel], span: tuple[float, float]
) -> list[_Panel]:
    """Draw details of the panels near their thresholds, and frame these parts in the panels."""
    details = []
    for ax, panel in zip(axes, panels, strict=True):
        draw_family(panel.diagrams, panel.output, MEASURE, ax)
        values = [
            mark.value
            for diagram in panel.diagrams
            for mark in marks_in(diagram, panel.output, MEASURE)
            if mark.type in BIFURCATION_TYPES and span[0] <= mark.parameter <= span[1]
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


def _name(panel: _Panel) -> None:
    model = panel.row.curves[0].model
    unit = value_text(model, panel.row.member)[1]
    names = [f"{name}{unit}" for name in panel.row.names]
    name_family(panel.ax, panel.diagrams, names, panel.output, MEASURE, without=panel.without)


def _common(row: Row) -> str:
    """Return the common parameters of a row, and the one in which its curves differ."""
    model = row.curves[0].model
    shown = [*row.common]
    if "f" not in (row.member, *row.curves[0].vary, *shown):
        shown.append("f")
    equations = ", ".join(equation_text(model, name) for name in shown)
    symbol = model.parameter(row.member).symbol
    return f"{equations}; {symbol} as marked" if equations else f"{symbol} as marked"


CONTACT = ("Ns", "Nd")
"""The plane in which a line parts contact all the time from none at times."""


def _plane(figure: Figure, result: Mapping[Case, Any]) -> Canvas:
    """Draw a bifurcation set and a detail of it."""
    (case,) = figure.cases
    diagram = _without_lost_contact(result[case])
    assert figure.detail is not None
    heights = (
        (HEIGHTS["wide plane"], HEIGHTS["wide detail"]) if figure.wide else (HEIGHTS["plane"],)
    )
    canvas = _canvas(sum(heights) + HEIGHTS["plane legend"])
    grid = canvas.add_gridspec(len(heights), 2 // len(heights), height_ratios=heights)
    whole, detail = (canvas.add_subplot(grid[place]) for place in (0, 1))
    for ax, view in ((whole, diagram.window), (detail, figure.detail)):
        draw_loci(diagram, ax, window=view, annotate=False, legend=False)
        if case.vary == CONTACT:
            _draw_contact_limit(ax, view)
    # Framed by a line, which names avoid.
    (left, right), (bottom, top) = figure.detail
    corners = [left, right, right, left, left], [bottom, bottom, top, top, bottom]
    whole.plot(*corners, color="0.35", linewidth=0.6)
    fixed = ("alpha", "Vd", "Ns", "mu") if "f" in case.vary else ("f",)
    equations = ", ".join(equation_text(case.model, name) for name in fixed)
    whole.set_title(f"(a)  {equations}")
    detail.set_title("(b)  detail of (a)")
    canvas.legend(**legend_options([diagram]), loc="outside lower center")
    name = partial(name_loci, diagram=diagram)
    _name_last(canvas, [partial(name, whole, without=figure.detail), partial(name, detail)])
    return canvas


def _without_lost_contact(diagram: LocusDiagram) -> LocusDiagram:
    """Remove the regions where the tip lifts off: there the model is not valid."""
    regions = diagram.regions
    if diagram.vary != CONTACT or regions is None:
        return diagram
    labels = np.where(regions.second[:, None] < regions.first, regions.labels, 0)
    return replace(diagram, regions=replace(regions, labels=labels))


def _draw_contact_limit(ax: Axes, view: Window) -> None:
    """Hatch where the amplitude of the normal force exceeds its static part: the tip lifts off."""
    (left, right), (bottom, top) = view
    if top <= left:
        return
    ends = np.array([max(left, bottom), min(right, top)])
    corners = [*zip(ends, ends, strict=True), (ends[1], top), (left, top), (left, ends[0])]
    ax.add_patch(
        Polygon(corners, facecolor="white", edgecolor="0.8", hatch="////", linewidth=0.0, zorder=1)
    )
    ax.plot(ends, ends, color="black", linewidth=0.8, zorder=1.5)
    place = left + 0.25 * (right - left), bottom + 0.7 * (top - bottom)
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    ax.text(*place, "tip lifts off: $N_d > N_s$", fontsize=7.0, ha="center", bbox=box)


LAST = 1000
"""Order, among periods, of what does not repeat."""

DOTS = {UP: "trajectories swept up", DOWN: "swept down", "": "from many starts"}

BESIDE = {UP: 5.0, DOWN: 3.0}
"""Sizes in points of the dots of periodic solutions, which lie on a line of the diagram."""

TORUS = "#ffc20a"
"""Color of tori, visible on dots; they have a dark edge."""

ROOM = 0.06
"""Room above and below what is drawn, over its height."""


def _regimes(figure: Figure, result: Mapping[Case, Any]) -> Canvas:
    """Draw a map of regimes over its bifurcation set."""
    plane, regimes = figure.cases
    canvas = _canvas(1.25 * COLUMN)
    draw_regimes(result[regimes], canvas.add_subplot(), over=result[plane])
    return canvas


def _completed(figure: Figure, result: Mapping[Case, Any]) -> Canvas:
    """Draw a figure of the paper with tori and sampled solutions, a curve a row."""
    curves, sweeps = figure.of_kind("response"), figure.of_kind("sweep")
    canvas = _canvas(len(curves) * HEIGHTS["trajectories"] + HEIGHTS["basin legend"])
    letters, naming, shown = _letters(), [], []
    panels = canvas.subplots(len(curves), 2, squeeze=False)
    for axes, curve, swept in zip(panels, curves, sweeps, strict=True):
        for ax, output in zip(axes, OUTPUTS, strict=True):
            naming.append(_draw_both(ax, result[curve], result[swept], output))
            shown.append((ax, [result[curve]], output))
            ax.set_title(f"{next(letters)}  {_fixed(curve)}")
    tori = [tori for curve in curves for tori in result[curve].tori]
    more = _more(tori, [result[swept] for swept in sweeps])
    draw_legend(canvas, shown, more)
    _name_last(canvas, naming)
    return canvas


def _hysteresis(figure: Figure, result: Mapping[Case, Any]) -> Canvas:
    """Draw a range with two responses, and their basins of attraction."""
    curve, swept, *cases = figure.cases
    basins = [renumbered(result[case], lambda item: item.period or LAST) for case in cases]
    heights = HEIGHTS["trajectories"], HEIGHTS["plane"]
    canvas = _canvas(sum(heights) + HEIGHTS["basin legend"])
    grid = canvas.add_gridspec(2, 1, height_ratios=heights)
    above, below = (grid[row].subgridspec(1, n) for row, n in ((0, 2), (1, len(basins))))
    naming, shown = [], []
    for place, output in enumerate(OUTPUTS):
        ax = canvas.add_subplot(above[place])
        shown.append((ax, [result[curve]], output))
        naming.append(_draw_both(ax, result[curve], result[swept], output))
        ax.set_title(f"({'ab'[place]})  {_fixed(curve)}")
    for place, (case, found) in enumerate(zip(cases, basins, strict=True)):
        ax = canvas.add_subplot(below[place])
        draw_basins(found, ax, legend=False)
        if place:
            ax.set_ylabel("")
        fraction = f"{100 * found.fraction(found[0]).value:.2g} % {in_words(found[0])}"
        at = equation_text(case.model, curve.vary[0])
        ax.set_title(f"({'cdefgh'[place]})  {at}\n{fraction}")
    most = max(basins, key=len)
    patches = [
        Patch(facecolor=color, label=f"basin of {in_words(item)}")
        for item, color in zip(most, BASINS, strict=False)
    ]
    if any((found.uncertain > 0).any() for found in basins):
        patches.append(Patch(facecolor="0.92", edgecolor="0.55", label="crossed by a boundary"))
    more = [*_more(result[curve].tori, [result[swept]]), *patches]
    draw_legend(canvas, shown, more)
    _name_last(canvas, naming)
    return canvas


def _draw_both(ax: Axes, diagram: Diagram, swept: Sweep, output: str) -> Callable[[], None]:
    """Draw branches and tori over the dots of solutions; return what names them.

    The axes show the range of the solutions: unstable orbits may be outside it.
    """
    draw_points(swept, output, MEASURE, ax, legend=False, beside=BESIDE)
    low, high = ax.dataLim.intervaly
    draw_family([diagram], output, MEASURE, ax, ["black"])
    for tori in diagram.tori:
        for line in torus_segments(tori, output, MEASURE):
            ax.plot(line.parameter, line.value, **_torus_line(line.kind))
    ax.set_xlim(swept.values[0], swept.values[-1])
    ax.set_ylim(low - ROOM * (high - low), high + ROOM * (high - low))
    ax.xaxis.set_major_locator(MaxNLocator(5))
    return lambda: name_family(ax, [diagram], None, output, MEASURE, ["black"])


def _fixed(curve: Case) -> str:
    other = "f" if curve.vary == ("Nd",) else "Nd"
    return equation_text(curve.model, other)


def _more(result: Sequence[TorusBranch], sweeps: Sequence[Sweep]) -> list[Line2D]:
    """Return what the legend says of tori and dots."""
    # Motions from many starts that repeat lie below those of the sweeps, if there are such.
    runs = {
        run if run in COLORS else ""
        for swept in sweeps
        for run in swept.runs
        if run in COLORS or not (swept.repeats(run).all() and COLORS.keys() & {*swept.runs})
    }
    tori = {STABLE: "torus", OTHER: "unstable torus"} if result else {}
    return [
        *(Line2D([], [], label=name, **_torus_line(kind)) for kind, name in tori.items()),
        *(
            Line2D([], [], linestyle="none", marker="o", markersize=3, markeredgewidth=0,
                   color=COLORS.get(run, OTHERS), label=name)
            for run, name in DOTS.items()
            if run in runs
        ),
    ]  # fmt: skip


def _torus_line(kind: str) -> dict[str, Any]:
    edge = withStroke(linewidth=LINES[kind]["linewidth"] + 1.2, foreground="black")
    return {**LINES[kind], "color": TORUS, "path_effects": [edge], "zorder": 2.2}


DRAWINGS: dict[str, Callable[[Figure, Mapping[Case, Any]], Canvas]] = {
    "family": _family,
    "plane": _plane,
    "completed": _completed,
    "hysteresis": _hysteresis,
    "regimes": _regimes,
}
"""Functions by kind of figure."""
