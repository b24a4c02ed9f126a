"""Friction coefficients over slip speed."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.friction import FrictionLaw
from slipfold.plots.axes import axes_or_new

SHOWN = 6.0
"""Slip speeds shown, in typical speeds of the law."""

VANISHING = 1e-6
"""A slope this small, in coefficients over the speeds shown, is none."""

STEEP = 4.0
"""A slope this many times above the usual ones is cut off."""

SLOPE = "#9c4a1a"
"""Colour of the slope and of its axis."""

FALLING = "#f3e3d6"
"""Shade of the speeds at which friction falls."""


def draw_friction(
    law: FrictionLaw, ax: Axes | None = None, colour: str = "black", *, fastest: float | None = None
) -> Axes:
    """Draw the friction coefficient in steady slip, and its slope on an axis of its own.

    Where friction falls with the speed, and so feeds vibration, the ground is shaded. What a
    contact at rest can bear is a bar at zero speed.
    """
    end = SHOWN * law.typical_speed if fastest is None else fastest
    if not (np.isfinite(end) and end > 0):
        raise InputError(f"fastest = {fastest} m/s is no speed; give a positive number")
    speeds = _speeds(end)
    coefficient, slope = np.asarray(law.coefficient(speeds)), np.asarray(law.slope(speeds))
    ax = axes_or_new(ax)
    ax.fill_between(
        speeds,
        0,
        1,
        where=slope < -VANISHING * coefficient.max() / end,
        transform=ax.get_xaxis_transform(),
        color=FALLING,
        linewidth=0,
        zorder=0,
    )
    ax.plot(speeds, coefficient, color=colour, linewidth=1.4)
    if law.sticks:
        # Half of the bar would lie outside the axes.
        ax.plot([0, 0], [0, law.stiction], color=colour, linewidth=3, clip_on=False)
    ax.set_xlim(0, end)
    ax.set_ylim(0, 1.15 * max(float(coefficient.max()), law.stiction) or 1.0)
    ax.set_xlabel("slip speed (m/s)")
    ax.set_ylabel(r"friction coefficient $\mu$")
    ax.set_title(law.label)
    _draw_slope(ax, speeds, slope)
    return ax


def _draw_slope(ax: Axes, speeds: Array, slope: Array) -> None:
    beside = ax.twinx()
    beside.plot(speeds, slope, color=SLOPE, linewidth=1.0, linestyle=(0, (4.5, 2.0)))
    low, high = min(float(slope.min()), 0.0), max(float(slope.max()), 0.0)
    # The rise of a regularised law would dwarf all else: what few speeds reach is cut off.
    usual = np.quantile(np.interp(np.linspace(0, speeds[-1], 401), speeds, slope), 0.95)
    if high > STEEP * max(usual, -low):
        high = max(2 * float(usual), -low)
    margin = 0.1 * (high - low) or 0.1
    beside.set_ylim(low - margin, high + margin)
    beside.axhline(0.0, color=SLOPE, linewidth=0.5)
    beside.set_ylabel(r"slope d$\mu$/d$v$ (s/m), dashed", color=SLOPE)
    beside.tick_params(axis="y", which="both", colors=SLOPE)
    ax.tick_params(axis="y", which="both", right=False)


def _speeds(end: float) -> Array:
    """Return speeds from 0 to the end, dense near 0, where regularised laws rise."""
    return np.unique(
        np.concatenate([np.linspace(0.0, end, 401), np.geomspace(1e-6 * end, end, 400)])
    )
