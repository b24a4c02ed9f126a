"""Shares of starts over a parameter: a line for each attractor, within a band of its bounds."""

from __future__ import annotations

from collections import Counter

import numpy as np
from matplotlib.axes import Axes

from slipfold.long_term.search import ENDED, UNDECIDED, kind_of
from slipfold.plots.angles import label_axis
from slipfold.plots.axes import axes_or_new
from slipfold.plots.style import palette
from slipfold.results.motions.basin_fractions import BasinFractions

NAMED = 6
"""Attractors that the legend names, those with the largest shares: chaos and windows have many."""

NOTHING = {UNDECIDED: ("0.65", "undecided"), ENDED: ("0.35", "ended")}
"""Colours and names of what came to no attractor."""


def draw_basin_fractions(
    found: BasinFractions, ax: Axes | None = None, *, legend: bool = True
) -> Axes:
    """Draw the share of each attractor where it was found, and of motions that came to none."""
    ax = axes_or_new(ax)
    numbers = found.numbers
    kinds = {number: kind_of(next(iter(found.along(number).values()))) for number in numbers}
    often = Counter(kinds.values())
    largest = sorted(numbers, key=lambda number: -np.nanmax(found.share(number).value))[:NAMED]
    for number, colour in zip(numbers, palette(len(numbers)), strict=True):
        kind = kinds[number]
        name = kind if often[kind] == 1 else f"{kind} ({number})"
        shown = np.isin(found.values, list(found.along(number)))
        _draw(ax, found, number, shown, colour, name if number in largest else None)
    for number, (colour, name) in NOTHING.items():
        if (found.labels == number).any():
            _draw(ax, found, number, np.ones(len(found.values), bool), colour, name)
    ax.set_xlim(found.values[0], found.values[-1])
    ax.set_ylim(0, 1.02)
    label_axis(ax, "x", found.model.parameter(found.vary))
    ax.set_ylabel("share of starts")
    if legend and ax.get_legend_handles_labels()[0]:
        ax.legend(loc="best")
    return ax


def _draw(
    ax: Axes,
    found: BasinFractions,
    number: int,
    shown: np.ndarray[tuple[int], np.dtype[np.bool_]],
    colour: str,
    name: str | None,
) -> None:
    value, low, high = (np.where(shown, each, np.nan) for each in found.share(number))
    ax.plot(
        found.values, value, ".-", color=colour, linewidth=1.0, markersize=4.0,
        label=name or "_nolegend_",
    )  # fmt: skip
    ax.fill_between(found.values, low, high, color=colour, alpha=0.2, linewidth=0)
