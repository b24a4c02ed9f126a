"""A region's label held against simulations: whether motions settle on what it says exists."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.simulate import simulate
from slipfold.flow.trajectory import Trajectory
from slipfold.loci.isolated import other_orbits
from slipfold.loci.region_map import Region, RegionCheck
from slipfold.models.model import Model

FORCING_PERIODS = 3000
"""Forcing periods a motion is given: the slowest decay of the base case, 0.96 a period, needs a
thousand near a boundary."""

SETTLED = 1e-7
"""Distance from a periodic response that counts as settled, in scaled states."""

NUDGE = 1e-4
"""Distance from a stable orbit at which a motion starts, in scaled states."""


def check_region(
    model: Model,
    plane: tuple[str, str],
    region: Region,
    orbits: Mapping[int, Sequence[Array]],
    states: Array,
    *,
    may_stick: bool = False,
) -> tuple[RegionCheck, ...]:
    """Simulate from rest, from beside each stable orbit and from states far off, well inside.

    Shapes: orbits (m, n_states); states (k, n_states).
    """
    at = model.replace(**dict(zip(plane, region.place, strict=True)))
    # Where contacts stick, motions from rest go on through that, and are looked at as such.
    checks = [] if may_stick else [_from_rest(at, region)]
    for period in sorted(set(region.slipping)):
        found = orbits.get(period, ())
        checks += [_from_orbit(at, region, period, nodes[0]) for nodes in found]
        for _ in range(region.slipping.count(period) - len(found)):
            note = "the orbit could not be carried to this place"
            checks.append(RegionCheck(region.place, f"period {period}", 0, False, note))
    for orbit in other_orbits(at, orbits, states):
        note = f"settled on a response of period {orbit.period} that none across the region has"
        checks.append(RegionCheck(region.place, "elsewhere", orbit.period, False, note))
    return tuple(checks)


def _from_rest(model: Model, region: Region) -> RegionCheck:
    check = _judged(simulate(model, FORCING_PERIODS, tolerance=SETTLED), region)
    if check.agrees:
        return check
    # A motion may rest for ever on a response that is not stable, as symmetry lets it.
    pushed = _beside(model, model.start)
    return _judged(simulate(model, FORCING_PERIODS, pushed, tolerance=SETTLED), region)


def _judged(motion: Trajectory, region: Region) -> RegionCheck:
    settled = motion.settlement.period or 0
    # Longer periods and tori are no contradiction: the label speaks of periods 1 and 2.
    agrees = settled not in (1, 2) or settled in region.stable
    return RegionCheck(region.place, "rest", settled, agrees, motion.settlement.message)


def _beside(model: Model, state: Array) -> Array:
    return np.asarray(state + NUDGE * model.state_scales() / np.sqrt(len(state)))


def _from_orbit(model: Model, region: Region, period: int, state: Array) -> RegionCheck:
    motion = simulate(model, FORCING_PERIODS, _beside(model, state), tolerance=SETTLED)
    settled = motion.settlement.period or 0
    return RegionCheck(
        region.place, f"period {period}", settled, settled == period, motion.settlement.message
    )
