"""The legend of a bifurcation set: what its lines, markers and shades mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from slipfold.branches.seams import NAMES as SEAMS
from slipfold.lines.of_loci import CRITICALITIES, locus_stretches
from slipfold.loci.locus import CODIMENSION_TWO, Locus, locus_title
from slipfold.loci.region_map import RegionMap
from slipfold.plots.locus_marks import locus_marks
from slipfold.plots.locus_style import LOCUS_COLOURS, TOUCHING, line_style, mark_style
from slipfold.plots.motions.region_motions import motion_shades
from slipfold.plots.region_colours import STICKS, UNKNOWN, region_colour
from slipfold.plots.regions import shown_regions

SIZE = 7.5
"""Font size in points."""

COLUMN_WIDTH = 1.9
"""Width of a column of the legend in inches."""

MARK_NAMES = {
    "MIN": "extremum of a locus",
    "LIMIT": "limit of the model",
    "FAILED": "given up",
    **SEAMS,
}


class _HasLoci(Protocol):
    @property
    def window(self) -> tuple[tuple[float, float], tuple[float, float]]: ...

    @property
    def loci(self) -> Sequence[Locus]: ...

    @property
    def regions(self) -> RegionMap | None: ...


def legend_options(
    diagrams: Sequence[_HasLoci],
    colours: Mapping[str, str] = LOCUS_COLOURS,
    regions: bool = True,
    width: float = np.inf,
) -> dict[str, Any]:
    """Return what a legend shows, with lines, markers and shades in a column each if they fit."""
    groups = [_lines(diagrams, colours), _marks(diagrams), _shades(diagrams) if regions else []]
    groups = [group for group in groups if group]
    columns = max(int(min(width / COLUMN_WIDTH, len(groups))), 1)
    if columns == len(groups):
        rows = max(map(len, groups), default=0)
        groups = [group + [_nothing()] * (rows - len(group)) for group in groups]
    handles = [handle for group in groups for handle in group]
    return {"handles": handles, "ncols": columns, "handlelength": 2.8, "fontsize": SIZE}


def _nothing() -> Artist:
    return Line2D([], [], linestyle="none", label=" ")


def _lines(diagrams: Sequence[_HasLoci], colours: Mapping[str, str]) -> list[Artist]:
    kinds = {
        (locus.type, locus.period, stretch.criticality, locus.kind)
        for diagram in diagrams
        for locus in diagram.loci
        for stretch in locus_stretches(locus)
    }
    order = [*colours, *TOUCHING]
    handles: list[Artist] = []
    for kind in sorted(kinds, key=lambda k: (order.index(k[0]), k[1], CRITICALITIES.index(k[2]))):
        text = locus_title(kind[0], kind[1], kind[3]) + ", " * bool(kind[2]) + kind[2]
        handles.append(Line2D([], [], label=text, **line_style(*kind[:3], colours, kind[3])))
    return handles


def _marks(diagrams: Sequence[_HasLoci]) -> list[Artist]:
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


def _shades(diagrams: Sequence[_HasLoci]) -> list[Artist]:
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
            facecolor=region_colour(stable),
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
    told = [shade for item in diagrams if item.regions for shade in motion_shades(item.regions)]
    return [*shades, *{str(shade.get_label()): shade for shade in told}.values()]
