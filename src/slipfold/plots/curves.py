"""Quantities over one parameter: basin fractions, probabilities and designs."""

from __future__ import annotations

from collections import Counter

import numpy as np
from matplotlib.axes import Axes

from slipfold.long_term.search import ENDED, UNDECIDED, kind_of
from slipfold.plots.style import axes_or_new, label_axis, label_of, palette
from slipfold.results.attractors import BasinFractions
from slipfold.results.thresholds import Design
from slipfold.results.uncertainty import WAYS, ThresholdUncertainty

NOTHING = {UNDECIDED: ("0.65", "undecided"), ENDED: ("0.35", "ended")}
"""Colors and names of what converged to no attractor."""

STYLES = {"samples": ("black", "-"), "gradients": ("tab:orange", "--")}


def draw_basin_fractions(
    found: BasinFractions, ax: Axes | None = None, *, legend: bool = True
) -> Axes:
    """Draw the basin fraction of each attractor, and that of starts that reach none."""
    ax = axes_or_new(ax)
    kinds = {number: kind_of(next(iter(found.along(number).values()))) for number in found.numbers}
    often = Counter(kinds.values())
    # Chaos and windows have many attractors; those with the largest fractions have names.
    largest = sorted(kinds, key=lambda number: -np.nanmax(found.fraction(number).value))[:6]
    drawn = []
    for number, color in zip(kinds, palette(len(kinds)), strict=True):
        kind = kinds[number]
        name = kind if often[kind] == 1 else f"{kind} ({number})"
        # It is seen how a fraction comes from zero, but not a line at zero of each attractor.
        there = np.convolve(np.isin(found.values, list(found.along(number))), [1, 1, 1])[1:-1] > 0
        drawn.append((number, there, color, name if number in largest else "_nolegend_"))
    for number, (color, name) in NOTHING.items():
        if (found.labels == number).any():
            drawn.append((number, np.ones(len(found.values), bool), color, name))
    for number, there, color, name in drawn:
        value, low, high = (np.where(there, each, np.nan) for each in found.fraction(number))
        ax.plot(found.values, value, ".-", color=color, linewidth=1, markersize=4, label=name)
        ax.fill_between(found.values, low, high, color=color, alpha=0.2, linewidth=0)
    ax.set_xlim(found.values[0], found.values[-1])
    ax.set_ylim(0, 1.02)
    label_axis(ax, "x", found.model.parameter(found.vary))
    ax.set_ylabel("fraction of starts")
    if legend and ax.get_legend_handles_labels()[0]:
        ax.legend(loc="best")
    return ax


def draw_uncertainty(
    found: ThresholdUncertainty, ax: Axes | None = None, *, level: float = 0.95
) -> Axes:
    """Draw the fraction of samples with a larger threshold over the load, and its band."""
    ax = axes_or_new(ax)
    for way in WAYS:
        values = np.sort(found._known(way))
        fraction = 1 - np.arange(len(values) + 1) / max(len(values), 1)
        ends = np.concatenate([values[:1], values])
        color, line = STYLES[way]
        lost = f", {found.lost} left out" if way == "samples" and found.lost else ""
        ax.step(ends, fraction, where="post", label=f"by {way}{lost}", color=color, linestyle=line)
    low, high = found.band(level)
    ax.axvspan(low, high, color="black", alpha=0.08, linewidth=0, label=f"{level:.0%}")
    ax.axvline(found.value, color="black", linewidth=0.8, linestyle=":")
    ax.set_xlabel(found.model.parameter(found.vary).label)
    ax.set_ylabel("probability that the threshold is above the load")
    ax.set_ylim(0, 1.02)
    ax.legend(loc="upper right", frameon=False)
    return ax


def draw_design(found: Design, ax: Axes | None = None) -> Axes:
    """Draw the designs in the plane of threshold and vibration, and the model before."""
    ax = axes_or_new(ax)
    order = np.argsort(found.thresholds[:, 0])
    ax.plot(found.thresholds[order, 0], found.levels[order], color="black", marker="o",
            label="designs")  # fmt: skip
    ax.plot(found.value, found.level, linestyle="none", marker="s", color="tab:orange",
            label="before")  # fmt: skip
    ax.margins(0.08)  # markers in a corner would be cut
    parameter = found.model.parameter(found.vary)
    ax.set_xlabel(f"{found.type} at {parameter.label}")
    load = f"{parameter.symbol or parameter.name} = {found.load:g} {parameter.unit}".rstrip()
    ax.set_ylabel(f"rms of {label_of(found.model, found.state)} at {load}")
    ax.legend(frameon=False)
    return ax
