"""Bifurcation sets: loci in a plane of two parameters, and what is stable between them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from slipfold.arrays import Array
from slipfold.bifurcations.loci.locus import Locus
from slipfold.bifurcations.loci.window import Window
from slipfold.flow.modes import MET
from slipfold.lines import CRITICALITIES, locus_segments
from slipfold.orbits.bifurcation_types import (
    BIFURCATION_TYPES,
    CODIMENSION_TWO,
    CONTACT_TYPES,
    EXTREMUM_TYPES,
    POINT_TYPES,
)
from slipfold.plots.labels import Label, place_labels
from slipfold.plots.regions import (
    STICKS,
    UNKNOWN,
    draw_regions,
    motion_shades,
    region_color,
    region_labels,
    sharpen,
    shown_regions,
)
from slipfold.plots.response import limit_name
from slipfold.plots.style import MARKERS, axes_or_new, label_axis, legend_below, settle, within
from slipfold.results.locus_diagram import LocusDiagram

LOCUS_COLORS: Mapping[str, str] = MappingProxyType(
    {name: BIFURCATION_TYPES[name].color for name in ("HB", "PD", "BP", "NS", "LP")}
)
"""Color of each type of locus; they differ in lightness too, and from all pale areas."""

WIDTHS = {1: 1.9, 2: 1.0}
"""Line width by period."""

DASHES: Mapping[str, Any] = MappingProxyType(
    {"supercritical": "-", "subcritical": (0, (4.0, 1.6)), "": (0, (1.0, 1.2))}
)
"""Line style by criticality; dotted where it is not known."""

FOLD: Any = (0, (5.0, 1.4, 1.0, 1.4))
"""Line style of folds of cycles, which have no criticality; those of equilibria are solid."""

CONTACT_DASHES: Mapping[str, Any] = MappingProxyType(
    {name: POINT_TYPES[name].dashes for name in (*MET, *EXTREMUM_TYPES)}
)
"""Line styles of what is no bifurcation; all are black."""


def locus_color(type_: str) -> str:
    """Return the color of a type of locus."""
    return LOCUS_COLORS.get(type_, "#000000")


def line_style(type_: str, period: int, criticality: str, kind: str = "periodic") -> dict[str, Any]:
    """Return the line properties of a segment of a locus."""
    own = {"LP": "-" if kind == "equilibrium" else FOLD, **CONTACT_DASHES}
    return {
        "color": locus_color(type_),
        "linestyle": own.get(type_, DASHES[criticality]),
        "linewidth": WIDTHS.get(period, 0.7),
    }


def mark_style(type_: str) -> dict[str, Any]:
    """Return the marker properties of a point of a bifurcation set."""
    style: dict[str, Any] = {"linestyle": "none", "color": "black", "zorder": 3}
    if type_ in CODIMENSION_TWO:
        return {**style, "marker": "o", "markersize": 3.8, "markeredgewidth": 0.0}
    if type_ in MARKERS and type_ not in EXTREMUM_TYPES:
        return {**style, "marker": MARKERS[type_], "markersize": 4.5, "markeredgewidth": 0.9}
    return {
        **style,
        "marker": "o",
        "markersize": 3.0,
        "markerfacecolor": "white",
        "markeredgewidth": 0.6,
    }


@dataclass(frozen=True)
class LocusMark:
    """A marked point."""

    type: str  # ``"GPD"`` and the like, ``"MIN"``, ``"MAX"``, ``"LIMIT"`` or ``"FAILED"``
    name: str  # text next to it; empty for none
    values: tuple[float, ...]  # where it is


def locus_marks(
    loci: Sequence[Locus], window: tuple[tuple[float, float], tuple[float, float]]
) -> tuple[LocusMark, ...]:
    """Return the marks of a bifurcation set, each once, whatever number of loci meets there."""
    result: list[LocusMark] = []
    size = np.ptp(np.array(window), axis=1)
    for mark in (mark for locus in loci for mark in _of_locus(locus)):
        if not any(
            mark.type == other.type
            # Points of one type closer than a line is wide are one point of two loci.
            and np.all(np.abs(np.subtract(mark.values, other.values)) < 1e-4 * size)
            for other in result
        ):
            result.append(mark)
    return tuple(result)


def _of_locus(locus: Locus) -> Iterator[LocusMark]:
    for point in locus.special:
        name = point.type if point.type in CODIMENSION_TWO else ""
        yield LocusMark(point.type, name, point.values)
    for end in locus.ends:
        if end.kind == "limit":
            yield LocusMark("LIMIT", limit_name(locus.model, end.reason), end.values)
        elif end.kind == "failed":
            yield LocusMark("FAILED", "", end.values)


SIZE = 7.5
"""Font size in points."""

MARK_NAMES = {
    "MIN": "extremum of a locus",
    "LIMIT": "limit of the model",
    "FAILED": "given up",
    **{name: item.title for name, item in CONTACT_TYPES.items()},
}


def legend_options(
    diagrams: Sequence[LocusDiagram], regions: bool = True, width: float = np.inf
) -> dict[str, Any]:
    """Return what a legend shows, with lines, markers and shades in a column each if they fit."""
    groups = [_lines(diagrams), _marks(diagrams), _shades(diagrams) if regions else []]
    groups = [group for group in groups if group]
    # A column is 1.9 inches wide.
    columns = max(int(min(width / 1.9, len(groups))), 1)
    if columns == len(groups):
        rows = max(map(len, groups), default=0)
        nothing = Line2D([], [], linestyle="none", label=" ")
        groups = [group + [nothing] * (rows - len(group)) for group in groups]
    handles = [handle for group in groups for handle in group]
    return {"handles": handles, "ncols": columns, "handlelength": 2.8, "fontsize": SIZE}


def _lines(diagrams: Sequence[LocusDiagram]) -> list[Artist]:
    kinds = {
        (locus.type, locus.period, segment.kind, locus.kind, locus.heading)
        for diagram in diagrams
        for locus in diagram.loci
        for segment in locus_segments(locus)
    }
    order = [*LOCUS_COLORS, *CONTACT_DASHES]
    handles: list[Artist] = []
    for kind in sorted(kinds, key=lambda k: (order.index(k[0]), k[1], CRITICALITIES.index(k[2]))):
        text = kind[4] + ", " * bool(kind[2]) + kind[2]
        handles.append(Line2D([], [], label=text, **line_style(*kind[:4])))
    return handles


def _marks(diagrams: Sequence[LocusDiagram]) -> list[Artist]:
    marks = [m for diagram in diagrams for m in locus_marks(diagram.loci, diagram.window)]
    types = {"MIN" if mark.type == "MAX" else mark.type for mark in marks}
    found = sorted(types & {*CODIMENSION_TWO})
    handles: list[Artist] = []
    if found:
        names = ", ".join(found) if len(found) < 4 else "codimension two"
        handles.append(Line2D([], [], label=names, **mark_style(found[0])))
    handles += [
        Line2D([], [], label=name, **mark_style(type_))
        for type_, name in MARK_NAMES.items()
        if type_ in types
    ]
    return handles


def _shades(diagrams: Sequence[LocusDiagram]) -> list[Artist]:
    shown = [
        region
        for diagram in diagrams
        if diagram.regions is not None
        for region in shown_regions(diagram.regions)
        if not region.motions
    ]
    kinds = {(region.stable, region.name): region for region in shown if region.known}
    shades: list[Artist] = [
        Patch(
            facecolor=region_color(stable),
            edgecolor=STICKS["edgecolor"] if region.sticking else "0.6",
            hatch=STICKS["hatch"] if region.sticking else None,
            linewidth=0.4,
            label=f"stable: {name}" if stable else "stable: neither 1 nor 2",
        )
        for (stable, name), region in kinds.items()
    ]
    if not all(region.known for region in shown):
        style: dict[str, Any] = {**UNKNOWN, "linewidth": 0.4}
        shades.append(Patch(**style, label="unknown"))
    simulated = [
        shade for item in diagrams if item.regions for shade in motion_shades(item.regions)
    ]
    return [*shades, *{str(shade.get_label()): shade for shade in simulated}.values()]


ORDER = ("MIN", "MAX", "LIFT", "STICK", "GRAZE", "LP", "BP", "HB", "NS", "PD")
"""From the lowest to the topmost line."""


def draw_loci(
    diagram: LocusDiagram,
    ax: Axes | None = None,
    *,
    window: Window | None = None,
    regions: bool = True,
    annotate: bool = True,
    legend: bool = True,
) -> Axes:
    """Draw a bifurcation set in its plane.

    Supercritical segments of PD, NS, BP and HB are solid, subcritical ones dashed; LP is
    dash-dotted, of equilibria solid, and a transcritical BP dotted. A locus of equilibria or of
    period 1 is thick, one of period 2 thin. Dots are points of codimension two, rings the extrema
    of a locus, crosses its ends at a limit of the model. Angles are shown in degrees; the data of
    the axes are radians.
    """
    shaded = regions and diagram.regions is not None
    ax = axes_or_new(ax)
    view = diagram.window if window is None else window
    ax.set_xlim(view[0])
    ax.set_ylim(view[1])
    if shaded and diagram.regions is not None:
        lines = [part.points for locus in diagram.loci for part in locus_segments(locus)]
        labels = sharpen(diagram.regions, lines, diagram.window, view)
        draw_regions(ax, diagram.regions, labels)
    for locus in sorted(diagram.loci, key=lambda item: ORDER.index(item.type)):
        for segment in locus_segments(locus):
            style = line_style(locus.type, locus.period, segment.kind, locus.kind)
            ax.plot(*segment.points.T, **style)
    for mark in locus_marks(diagram.loci, diagram.window):
        ax.plot(*mark.values, **mark_style(mark.type))
    ax.set_xlim(view[0])
    ax.set_ylim(view[1])
    label_axis(ax, "x", diagram.model.parameter(diagram.vary[0]))
    label_axis(ax, "y", diagram.model.parameter(diagram.vary[1]))
    if legend and (diagram.loci or shaded):
        figure = ax.get_figure(root=True)
        assert figure is not None
        # Five lines below the axes: clear of the numbers and the name of the parameter.
        legend_below(ax, 5.0, **legend_options([diagram], regions, figure.get_figwidth()))
    if annotate:
        name_loci(ax, diagram, regions=regions)
    return ax


def name_loci(
    ax: Axes, diagram: LocusDiagram, *, regions: bool = True, without: Window | None = None
) -> None:
    """Name the points of codimension two of a picture, its loci and its regions.

    What is drawn later may be covered by a name, or may move it.
    """
    settle(ax)
    labels = []
    for mark in locus_marks(diagram.loci, diagram.window):
        place = np.array([mark.values])
        hidden = without is not None and all(
            low <= value <= high for value, (low, high) in zip(mark.values, without, strict=True)
        )
        if mark.name and not hidden and len(within(ax, place)):
            labels.append(Label(mark.name, place))
    for locus in diagram.loci:
        anchors = within(ax, _anchors(locus))
        if len(anchors):
            labels.append(Label(_name(locus), anchors, locus_color(locus.type), 7.5, leader=False))
    if regions and diagram.regions is not None:
        labels += region_labels(ax, diagram.regions)
    place_labels(ax, labels)


def _name(locus: Locus) -> str:
    if locus.type == "LP" and not locus.model.forced:
        return "LP of equilibria" if locus.kind == "equilibrium" else "LP of cycles"
    if locus.quantity:
        return f"{POINT_TYPES[locus.type].title} {locus.quantity}"
    return locus.type if locus.period == 1 else f"{locus.type} {locus.period}"


def _anchors(locus: Locus) -> Array:
    """Return points along a locus, shape (n, 2)."""
    points = [segment.points for segment in locus_segments(locus)]
    if not points:
        return np.zeros((0, 2))
    together = np.concatenate(points)
    return together[np.linspace(0, len(together) - 1, 60).astype(int)]
