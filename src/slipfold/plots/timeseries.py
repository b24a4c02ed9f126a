"""Outputs over time."""

from __future__ import annotations

from matplotlib.axes import Axes

from slipfold.flow.trajectory import Trajectory
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.plots.axes import axes_or_new, label_of

__all__ = ["draw_timeseries"]


def draw_timeseries(
    motion: Trajectory | PeriodicOrbit,
    output: str = "x",
    ax: Axes | None = None,
    colour: str = "black",
    *,
    start: int = 0,
    stop: int | None = None,
    per_period: int = 64,
) -> Axes:
    """Draw one output over time."""
    label = label_of(motion.model, output)
    if isinstance(motion, Trajectory):
        time, values = motion.output(output, start, stop, per_period)
    else:
        time, values = motion.output(output, per_period * motion.period)
    ax = axes_or_new(ax)
    ax.plot(time, values, color=colour, linewidth=0.9)
    ax.margins(x=0.0)
    ax.set_xlabel("time (s)")
    ax.set_ylabel(label)
    return ax
