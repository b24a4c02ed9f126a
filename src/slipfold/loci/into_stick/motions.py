"""What motions settle on where contacts may stick: stable responses beyond those in slip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.simulate import simulate_smooth_or_switched
from slipfold.flow.trajectory import last_round
from slipfold.loci.region_map import Region, RegionCheck
from slipfold.loci.stable_spans import ONE_ORBIT
from slipfold.models.model import Model
from slipfold.models.turns import without_turns

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
    states: Array  # at the last strobes, the latest last, shape (period or 1, n)
    note: str
    # Share of the last round in which a contact sticks; NaN if slip does not come to zero
    fraction: float = np.nan

    @property
    def state(self) -> Array:
        """The last state."""
        return np.asarray(self.states[-1])

    @property
    def stops(self) -> bool:
        """Whether slip comes to zero."""
        return not np.isnan(self.fraction)

    @property
    def counts(self) -> bool:
        """Whether it is a response that stops, of a period that labels speak of."""
        return self.stops and self.period in PERIODS


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
    states = motion.strobe[-max(period, 1) :]
    last = None if motion.stopped is not None else last_round(motion)
    if last is None or motion.sticking is None:
        return Settled(period, states, note)
    begin = motion.periods - max(period, 1)
    changes = any(item.end > begin for item in motion.sticking.intervals[:-1])
    stops = changes or last.fraction > 0
    return Settled(period, states, note, last.fraction if stops else np.nan)


def sticking_orbits(
    model: Model,
    plane: tuple[str, str],
    places: Sequence[Place],
    seeds: Sequence[Sequence[Array]],
) -> tuple[list[list[Settled]], bool]:
    """Return the stable responses that stop at each place, and whether places agree.

    Motions start from rest and from states of the responses found there; what they settle on at
    one place is tried at the others: inside a region it exists at all.
    """
    at = [model.replace(**dict(zip(plane, place, strict=True))) for place in places]
    seen = list[list[Settled]]()
    for each, states in zip(at, seeds, strict=True):
        seen.append([])
        for found in (settle(each, each.start), *(_settle_from(each, state) for state in states)):
            _add(each, found, seen[-1])
    for i, each in enumerate(at):
        for other in [item for others in seen[:i] + seen[i + 1 :] for item in others]:
            if _periods(seen[i]).count(other.period) < max(
                _periods(others).count(other.period) for others in seen
            ):
                _add(each, _settle_from(each, other.state), seen[i])
    return seen, all(_periods(found) == _periods(seen[0]) for found in seen)


def _settle_from(model: Model, state: Array) -> Settled:
    """Settle from a state of another place, which may be none that can be started from."""
    try:
        return settle(model, state)
    except InputError as error:
        return Settled(0, state[None], str(error))


def _add(model: Model, found: Settled, known: list[Settled]) -> None:
    """Add what a motion came to unless it is known, or none that labels speak of."""
    if not found.counts:
        return
    scales, whole = model.state_scales(), model.whole_turns
    for other in known:
        if other.period == found.period and any(
            np.abs(without_turns(state - found.state, whole) / scales).max() < ONE_ORBIT
            for state in other.states
        ):
            return
    known.append(found)


def _periods(found: Sequence[Settled]) -> list[int]:
    return sorted(item.period for item in found)


def add_sticking(
    model: Model,
    plane: tuple[str, str],
    region: Region,
    places: Sequence[Place],
    seeds: Sequence[Sequence[Array]],
) -> tuple[Region, list[Settled]]:
    """Return a region with the stable responses in it that stick, and these."""
    every = np.linspace(0, len(places) - 1, min(PLACES, len(places))).round().astype(int)
    of = [places[i] for i in every], [seeds[i] for i in every]
    seen, agree = sticking_orbits(model, plane, *of)
    most = max(seen, key=len, default=[])
    fractions = [one.fraction for found in seen for one in found]
    periods = tuple(_periods(most))
    label = replace(
        region,
        stable=tuple(sorted([*region.stable, *periods])),
        sticking=periods,
        stuck=(min(fractions), max(fractions)) if fractions else (0.0, 0.0),
        consistent=region.consistent and agree,
    )
    return label, most


def sticking_checks(
    model: Model, plane: tuple[str, str], region: Region, responses: Sequence[Settled]
) -> tuple[RegionCheck, ...]:
    """Let motions settle well inside a region, from rest and from its responses that stick."""
    at = model.replace(**dict(zip(plane, region.place, strict=True)))
    rest = settle(at, at.start)
    known = region.sticking if rest.stops else region.slipping
    agrees = rest.period not in PERIODS or rest.period in known
    checks = [RegionCheck(region.place, "rest", rest.period, agrees, rest.note)]
    for item in responses:
        found = _settle_from(at, item.state)
        same = found.stops and found.period == item.period
        note = found.note if found.stops else f"{found.note}, and always slips"
        checks.append(RegionCheck(region.place, f"period {item.period}", found.period, same, note))
    return tuple(checks)
