"""A region's label held against simulations: whether motions settle on what it says exists."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.settings import Settings
from slipfold.errors import InputError
from slipfold.flow.simulate import simulate
from slipfold.loci.fan import follow_line
from slipfold.loci.region_map import Region, RegionCheck
from slipfold.loci.stable_spans import orbit_on, stable_spans
from slipfold.loci.window import Window
from slipfold.models.model import Model

__all__ = ["check_region"]

Array = NDArray[np.float64]

FORCING_PERIODS = 3000
"""Forcing periods a motion is given: the slowest decay of the base case, 0.96 a period, needs a
thousand near a boundary."""

SETTLED = 1e-7
"""Distance from a periodic response that counts as settled, in scaled states."""

NUDGE = 1e-4
"""Distance from a stable orbit at which a motion starts, in scaled states."""


def check_region(
    model: Model, plane: tuple[str, str], window: Window, region: Region, settings: Settings
) -> tuple[RegionCheck, ...]:
    """Simulate from rest and from beside each stable orbit, well inside a region.

    Parameters
    ----------
    model
        The model.
    plane
        Names of the parameters.
    window
        Least and largest value of each.
    region
        The region.
    settings
        Options of continuation.
    """
    try:
        at = model.replace(**dict(zip(plane, region.place, strict=True)))
    except InputError as error:  # the window holds places where there is no model
        return (RegionCheck(region.place, "rest", 0, not region.stable, str(error)),)
    checks = [_from_rest(at, region)]
    starts = dict(_stable_states(at, plane, window, region, settings))
    for period in region.stable:
        if period in starts:
            checks.append(_from_orbit(at, region, period, starts[period]))
    return tuple(checks)


def _from_rest(model: Model, region: Region) -> RegionCheck:
    motion = simulate(model, FORCING_PERIODS, tolerance=SETTLED)
    settled = motion.settlement.period or 0
    # Longer periods and tori are no contradiction: the label speaks of periods 1 and 2.
    agrees = settled not in (1, 2) or settled in region.stable
    return RegionCheck(region.place, "rest", settled, agrees, motion.settlement.message)


def _from_orbit(model: Model, region: Region, period: int, state: Array) -> RegionCheck:
    beside = state + NUDGE * model.state_scales() / np.sqrt(len(state))
    motion = simulate(model, FORCING_PERIODS, beside, tolerance=SETTLED)
    settled = motion.settlement.period or 0
    return RegionCheck(
        region.place, f"period {period}", settled, settled == period, motion.settlement.message
    )


def _stable_states(
    model: Model, plane: tuple[str, str], window: Window, region: Region, settings: Settings
) -> Iterator[tuple[int, Array]]:
    """States of the stable orbits at a place, from responses across it in either direction."""
    for axis in (1, 0):
        vary, fixed = plane[axis], plane[1 - axis]
        value = region.place[axis]
        line = follow_line(model, vary, window[axis], fixed, region.place[1 - axis], settings)
        for branch in line.branches:
            for span in stable_spans(branch):
                if span.low < value < span.high:
                    nodes = orbit_on(branch, span, value)
                    if nodes is not None:
                        yield branch.period, nodes[0]
