"""Maps of regimes: a colour for what a motion does, a hatch for what others do there."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch, PathPatch

from slipfold.long_term.neighbours import NONE
from slipfold.plots.angles import label_axis
from slipfold.plots.axes import axes_or_new, cell_edges
from slipfold.plots.loci import HasLoci, draw_loci
from slipfold.plots.locus_legend import legend_options
from slipfold.plots.motions.regime_colours import COLOURS, grouped
from slipfold.plots.threshold_map import cells
from slipfold.results.motions.regime_map import RegimeMap

DARK = "0.25"
"""Hatch of what coexists, where its colour is no other than that of the ground."""

UNDECIDED, SAME_PERIOD = "....", "\\\\\\\\"


def draw_regimes(
    found: RegimeMap,
    ax: Axes | None = None,
    *,
    run: str = "rest",
    over: HasLoci | None = None,
    legend: bool = True,
) -> Axes:
    """Draw what the motions of one run do as colours, and what those of others do besides.

    A hatch has the colour of the other regime; it is dark where only the responses differ. Lines of
    a bifurcation set may be drawn over it. What is undecided is dotted, what is not done white.
    """
    ax = axes_or_new(ax)
    edges = tuple(cell_edges(values) for values in found.over.values())
    named = _grouped(found, run)
    order = list(COLOURS)
    numbers = np.vectorize(order.index)(named)
    ax.pcolormesh(
        *edges,
        numbers.T,
        cmap=ListedColormap(list(COLOURS.values())),
        vmin=-0.5,
        vmax=len(order) - 0.5,
        rasterized=True,
        zorder=0,
    )
    hatched = _hatch(ax, found, edges, named)
    if over is not None:
        draw_loci(over, ax, regions=False, legend=False)
    ax.set_xlim(edges[0][0], edges[0][-1])
    ax.set_ylim(edges[1][0], edges[1][-1])
    for which, name in zip(("x", "y"), found.axes, strict=True):
        label_axis(ax, "x" if which == "x" else "y", found.model.parameter(name))
    if legend:
        shown = [name for name in order if (named == name).any() or name in hatched]
        handles: list[Artist] = [Patch(**_ground(name), label=name) for name in shown]
        beside = {"coexisting, in the other's colour": "////"} if hatched - {""} else {}
        beside |= {"coexisting, of the same kind": SAME_PERIOD} if "" in hatched else {}
        handles += [
            Patch(facecolor="white", edgecolor=DARK, hatch=hatch, linewidth=0.4, label=name)
            for name, hatch in beside.items()
        ]
        handles += [] if over is None else _lines(over)
        ax.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return ax


def _lines(over: HasLoci) -> list[Artist]:
    """Return what a legend shows of the lines of a bifurcation set, one below the other."""
    handles = legend_options([over], regions=False, width=0.0)["handles"]
    return [handle for handle in handles if str(handle.get_label()).strip()]


def _ground(name: str) -> dict[str, Any]:
    style: dict[str, Any] = {"facecolor": COLOURS[name], "edgecolor": "0.5", "linewidth": 0.4}
    return style | ({"hatch": UNDECIDED} if name == "undecided" else {})


def _grouped(found: RegimeMap, run: str) -> Any:
    return grouped(found.names(run))


def _hatch(ax: Axes, found: RegimeMap, edges: tuple[Any, ...], named: Any) -> set[str]:
    """Hatch undecided cells, and those where other runs came to something else."""
    _patch(ax, edges, named == "undecided", "0.6", UNDECIDED)
    masks: dict[str, Any] = {}
    free = found.coexist
    for other in found.runs:
        beside = _grouped(found, other)
        for name in set(beside[free].tolist()) - {"undecided", "not done", "stopped", NONE}:
            own = free & (beside == name) & (named != name)
            masks[name] = masks.get(name, False) | own
            free = free & ~own
    told = {name for name, mask in masks.items() if mask.any()}
    for name in sorted(told):
        _patch(ax, edges, masks[name], COLOURS[name], "////")
    _patch(ax, edges, free, DARK, SAME_PERIOD)
    return told | ({""} if free.any() else set())


def _patch(ax: Axes, edges: tuple[Any, ...], mask: Any, colour: str, hatch: str) -> None:
    if mask.any():
        area = cells((edges[0], edges[1]), mask.T)
        ax.add_patch(
            PathPatch(area, facecolor="none", edgecolor=colour, hatch=hatch, linewidth=0.0,
                      zorder=0.2)
        )  # fmt: skip
