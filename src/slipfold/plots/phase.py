"""Phase portraits: one output against another, with the strobe states."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from slipfold.flow.trajectory import Trajectory
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.plots.angles import label_output, on_circles
from slipfold.plots.axes import axes_or_new


def draw_phase(
    motion: Trajectory | PeriodicOrbit,
    output: str | None = None,
    against: str | None = None,
    ax: Axes | None = None,
    colour: str = "black",
    *,
    periods: int = 64,
    per_period: int = 128,
) -> Axes:
    """Draw one output against another, with a dot at the start of every forcing period.

    By default these are the first state and its rate.
    """
    names = [item.name for item in motion.model.states]
    output = names[0] if output is None else output
    against = beside(names, output) if against is None else against
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
    ax = axes_or_new(ax)
    shown = list(zip((output, against), columns, strict=True))
    ax.plot(*on_circles(motion.model, shown), color=colour, linewidth=0.8)
    ends = slice(0, -1) if isinstance(motion, PeriodicOrbit) else slice(None)
    starts = [(name, column[ends][strobe]) for name, column in shown]
    dots = on_circles(motion.model, starts)
    ax.plot(*dots, "o", markersize=3, color=colour)
    label_output(ax, "x", motion.model, output)
    label_output(ax, "y", motion.model, against)
    return ax


def beside(names: Sequence[str], output: str) -> str:
    """Return what an output is drawn against: its rate if that has the usual name, or a state.

    >>> beside(["x", "y", "vx", "vy"], "x"), beside(["prey", "predator"], "prey")
    ('vx', 'predator')
    """
    rate = f"v{output}"
    return rate if rate in names else next((name for name in names if name != output), output)
