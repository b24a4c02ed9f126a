"""How much a response vibrates at least, over the threshold that it is to keep."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from slipfold.plots.axes import axes_or_new, label_of
from slipfold.results.design_space.design import Design


def draw_design(found: Design, ax: Axes | None = None) -> Axes:
    """Draw the designs in the plane of threshold and vibration, and what was there before."""
    ax = axes_or_new(ax)
    threshold, level = found.thresholds[:, 0], found.levels
    order = np.argsort(threshold)
    ax.plot(threshold[order], level[order], color="black", marker="o", label="designs")
    ax.plot(found.value, found.level, linestyle="none", marker="s", color="tab:orange",
            label="before")  # fmt: skip
    parameter = found.model.parameter(found.vary)
    ax.set_xlabel(f"{found.type} at {parameter.label}")
    load = f"{parameter.symbol or parameter.name} = {found.load:g} {parameter.unit}".rstrip()
    ax.set_ylabel(f"rms of {label_of(found.model, found.state)} at {load}")
    ax.legend(frameon=False)
    return ax
