"""How probable it is that a response is quiet, where parameters scatter."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from slipfold.plots.axes import axes_or_new
from slipfold.results.design_space.threshold_uncertainty import WAYS, ThresholdUncertainty

STYLES = {"samples": ("black", "-"), "gradients": ("tab:orange", "--")}


def draw_uncertainty(
    found: ThresholdUncertainty, ax: Axes | None = None, *, level: float = 0.95
) -> Axes:
    """Draw the share of samples that are quiet over the load, by both ways, and their band."""
    ax = axes_or_new(ax)
    for way in WAYS:
        values = np.sort(found._known(way))
        share = 1 - np.arange(len(values) + 1) / max(len(values), 1)
        ends = np.concatenate([values[:1], values])
        colour, line = STYLES[way]
        lost = f", {found.lost} left out" if way == "samples" and found.lost else ""
        ax.step(ends, share, where="post", label=f"by {way}{lost}", color=colour, linestyle=line)
    low, high = found.band(level)
    ax.axvspan(low, high, color="black", alpha=0.08, linewidth=0, label=f"{level:.0%}")
    ax.axvline(found.value, color="black", linewidth=0.8, linestyle=":")
    ax.set_xlabel(found.model.parameter(found.vary).label)
    ax.set_ylabel("probability of being quiet")
    ax.set_ylim(0, 1.02)
    ax.legend(loc="upper right", frameon=False)
    return ax
