"""Outputs over time."""

from __future__ import annotations

from matplotlib.axes import Axes

from slipfold.flow.trajectory import Trajectory
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.plots.angles import label_output, on_circles
from slipfold.plots.axes import axes_or_new


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
    if isinstance(motion, Trajectory):
        time, values = motion.output(output, start, stop, per_period)
    else:
        time, values = motion.output(output, per_period * motion.period)
    ax = axes_or_new(ax)
    values, time = on_circles(motion.model, [(output, values)], [time])
    ax.plot(time, values, color=colour, linewidth=0.9)
    ax.margins(x=0.0)
    ax.set_xlabel("time (s)")
    label_output(ax, "y", motion.model, output)
    return ax
