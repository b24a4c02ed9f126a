"""Phase portraits: one output against another, with the strobe states."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes

from slipfold.flow.trajectory import Trajectory
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.plots.axes import axes_or_new, label_of

__all__ = ["draw_phase"]


def draw_phase(
    motion: Trajectory | PeriodicOrbit,
    output: str = "x",
    against: str = "vx",
    ax: Axes | None = None,
    colour: str = "black",
    *,
    periods: int = 64,
    per_period: int = 128,
) -> Axes:
    """Draw one output against another, with a dot at the start of every forcing period."""
    labels = label_of(motion.model, output), label_of(motion.model, against)
    if isinstance(motion, Trajectory):
        start = max(motion.periods - periods, 0)
        columns = [motion.output(name, start, None, per_period)[1] for name in (output, against)]
        strobe = slice(None, None, per_period)
    else:
        # A multiple of the nodes, so that a sample falls on the start of every forcing period.
        unit = math.lcm(motion.period, len(motion.nodes))
        count = -(-per_period * motion.period // unit) * unit
        columns = [motion.output(name, count)[1] for name in (output, against)]
        strobe = slice(None, None, len(columns[0]) // motion.period)
        columns = [np.append(column, column[0]) for column in columns]
    horizontal, vertical = columns
    ax = axes_or_new(ax)
    ax.plot(horizontal, vertical, color=colour, linewidth=0.8)
    dots = slice(0, -1) if isinstance(motion, PeriodicOrbit) else slice(None)
    ax.plot(horizontal[dots][strobe], vertical[dots][strobe], "o", markersize=3, color=colour)
    ax.set_xlabel(labels[0])
    ax.set_ylabel(labels[1])
    return ax
