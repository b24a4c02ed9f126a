"""Readings of a measured response, drawn over what was varied."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from slipfold.measured.measurement import Measurement

READ = "#c2410c"
"""Colour of readings: of no branch, and darker than paper in grey."""

WAYS = {
    "up": ("measured, upward", READ, 2.8),
    "down": ("measured, downward", "none", 5.0),
    "": ("measured", READ, 2.8),
}
"""Name, colour and size of readings by how the parameter came to its value."""


def draw_readings(ax: Axes, measurement: Measurement, measure: str, output: str) -> None:
    """Draw readings of one quantity, with their errors where there are any."""
    read, errors = measurement.of(measure, output)
    sweep = np.array(measurement.sweep, dtype=object)
    for way, (name, inside, size) in WAYS.items():
        rows = (sweep == way) & np.isfinite(read)
        if rows.any():
            ax.errorbar(
                measurement.values[rows],
                read[rows],
                np.nan_to_num(errors[rows]),
                linestyle="none",
                marker="o",
                markersize=size,
                markeredgewidth=0.7,
                elinewidth=0.7,
                color=READ,
                label=name,
                zorder=2.5,
                markerfacecolor=inside,
            )
