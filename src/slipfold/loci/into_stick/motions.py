"""What motions settle on where contacts may stick: stable responses beyond those in slip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.flow.last_round import last_round
from slipfold.flow.switched.simulate import simulate_smooth_or_switched
from slipfold.loci.region_map import Region, RegionCheck
from slipfold.models.model import Model

__all__ = ["Settled", "add_sticking", "settle", "sticking_checks", "sticking_orbits"]

Array = NDArray[np.float64]
Place = tuple[float, float]

ROUNDS = (64, 256, 1024)
"""Forcing periods after which it is looked whether a motion has settled."""

SETTLED = 1e-7
"""Distance from a periodic response that counts as settled, in scaled states."""

PERIODS = (1, 2)
"""Periods of the responses that labels speak of."""

PLACES = 3
"""Places of a piece at which motions are looked at: at two, one that differs has no majority."""


class Settled(NamedTuple):
    """What a motion has come to."""

    period: int  # in forcing periods; 0 if it does not repeat itself, or has ended
    state: Array
    note: str
    # Share of the last round in which a contact sticks; NaN if slip does not come to zero
    fraction: float = np.nan

    @property
    def stops(self) -> bool:
        """Whether slip comes to zero."""
        return not np.isnan(self.fraction)


def settle(model: Model, state: Array) -> Settled:
    """Return what a motion from a state comes to. Shapes: state (n,)."""
    before = 0
    for count in ROUNDS:
        motion = simulate_smooth_or_switched(model, count, state, tolerance=SETTLED)
        state = motion.strobe[-1]
        if motion.stopped is not None:
            break
        # What approaches period 1 from either side in turn repeats itself in two periods sooner.
        if motion.settlement.settled and motion.settlement.period in (1, before):
            break
        before = motion.settlement.period or 0
    period, note = motion.settlement.period or 0, motion.settlement.message
    last = None if motion.stopped is not None else last_round(motion)
    if last is None or motion.sticking is None:
        return Settled(period, state, note)
    begin = motion.periods - max(period, 1)
    changes = any(item.end > begin for item in motion.sticking.intervals[:-1])
    stops = changes or last.fraction > 0
    return Settled(period, state, note, last.fraction if stops else np.nan)


def sticking_orbits(
    model: Model, plane: tuple[str, str], places: Sequence[Place]
) -> tuple[list[dict[int, Settled]], bool]:
    """Return the stable responses that stop at each place, by period, and whether places agree.

    What a motion settles on at one place is tried at the others: inside a region it exists at all.
    """
    at = [model.replace(**dict(zip(plane, place, strict=True))) for place in places]
    seen = [_sticking(settle(each, each.start)) for each in at]
    for i, each in enumerate(at):
        for others in seen[:i] + seen[i + 1 :]:
            for period, other in others.items():
                if period not in seen[i]:
                    seen[i] |= _sticking(_settle_from(each, other.state))
    return seen, all(found.keys() == seen[0].keys() for found in seen)


def _settle_from(model: Model, state: Array) -> Settled:
    """Settle from a state of another place, which may be none that can be started from."""
    try:
        return settle(model, state)
    except InputError as error:
        return Settled(0, state, str(error))


def _sticking(found: Settled) -> dict[int, Settled]:
    return {found.period: found} if found.stops and found.period in PERIODS else {}


def add_sticking(
    model: Model, plane: tuple[str, str], region: Region, places: Sequence[Place]
) -> tuple[Region, dict[int, Array]]:
    """Return a region with the stable responses in it that stick, and a state of each."""
    every = np.linspace(0, len(places) - 1, min(PLACES, len(places))).round().astype(int)
    seen, agree = sticking_orbits(model, plane, [places[i] for i in every])
    states = {period: one.state for found in seen for period, one in found.items()}
    fractions = [one.fraction for found in seen for one in found.values()]
    periods = tuple(sorted(states))
    label = replace(
        region,
        stable=tuple(sorted([*region.stable, *periods])),
        sticking=periods,
        stuck=(min(fractions), max(fractions)) if fractions else (0.0, 0.0),
        consistent=region.consistent and agree,
    )
    return label, states


def sticking_checks(
    model: Model, plane: tuple[str, str], region: Region, states: dict[int, Array]
) -> tuple[RegionCheck, ...]:
    """Let motions settle well inside a region, from rest and from its responses that stick."""
    at = model.replace(**dict(zip(plane, region.place, strict=True)))
    rest = settle(at, at.start)
    known = region.sticking if rest.stops else region.slipping
    agrees = rest.period not in PERIODS or rest.period in known
    checks = [RegionCheck(region.place, "rest", rest.period, agrees, rest.note)]
    for period, state in states.items():
        found = _settle_from(at, state)
        same = found.stops and found.period == period
        note = found.note if found.stops else f"{found.note}, and always slips"
        checks.append(RegionCheck(region.place, f"period {period}", found.period, same, note))
    return tuple(checks)
