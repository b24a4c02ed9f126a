"""Responses that no branch reaches, and the spans in which one is stable."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.orbit_between import orbits_at
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.branches.start import Begin
from slipfold.bifurcations.loci.fan import FanLine, extended
from slipfold.bifurcations.loci.window import Plane
from slipfold.errors import InputError
from slipfold.flow.flow import flow_of
from slipfold.models.angles import distances
from slipfold.models.model import Model
from slipfold.orbits.find import periodic_orbit
from slipfold.orbits.orbit_batch import orbits_from
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit


class ISOLATED:
    """How responses that no branch reaches are searched for."""

    same: float = 1e-4  # two stable orbits this close in scaled states are one
    places: int = 4  # places on a line, evenly spaced, at which trajectories start
    trajectories: int = 8  # trajectories at each of them: one batch of the integrator
    reach: float = 1.5  # they start within so many times what the responses cover
    call: int = 8  # forcing periods integrated at a time, within one step budget
    nearly: float = 0.03  # movement in a period, in scaled states, at which Newton finds an orbit
    near: float = 10.0  # distance from a known orbit, in such movements, at which it is that one


def stable_orbits(branches: Sequence[Branch], value: float) -> dict[int, list[Array]]:
    """Return the stable orbits of branches at a value of their parameter, by period.

    Returns shapes (m, n_states).
    """
    found: dict[int, list[Array]] = {}
    for branch in branches:
        for orbit in orbits_at(branch, value):
            known = found.setdefault(branch.period, [])
            if orbit.stable and not is_among(branch.model, orbit.nodes, branch.period, known):
                known.append(orbit.nodes)
    return {period: orbits for period, orbits in found.items() if orbits}


def is_among(model: Model, nodes: Array, period: int, known: Sequence[Array]) -> bool:
    """Whether an orbit is one of others, started in whichever forcing period: a state decides.

    Shapes: nodes (m, n_states), where m differs between orbits.
    """
    each, rest = divmod(len(nodes), period)
    starts = nodes[:1] if rest else nodes[::each]
    return any(distances(model, starts, other[0]).min() < ISOLATED.same for other in known)


PERIODS = (1, 2)
"""Periods of the orbits that are looked for."""

ROUNDS = (64, 128, 256)
"""Forcing periods after which it is looked, one after the other, what has nearly settled."""


class Starts:
    """States evenly spread over twice the range of the orbits, the same in every run."""

    def __init__(self, model: Model, branches: Sequence[Branch]) -> None:
        scales, start = model.state_scales(), model.start
        reached = [np.abs(branch.nodes - start).max(axis=(0, 1)) for branch in branches]
        self._middle, self._half = start, ISOLATED.reach * np.max([scales, *reached], axis=0)

    def number(self, place: int) -> Array:
        """Return those of a place, by its number, shape (trajectories, n_states)."""
        n = len(self._middle)
        # Multiples of powers of the root of x^(n+1) = x + 1 fill a box evenly: for one state the
        # golden section.
        root = 2.0
        for _ in range(64):
            root = (1 + root) ** (1 / (n + 1))
        steps = root ** -np.arange(1.0, n + 1)
        numbers = np.arange(1.0, ISOLATED.trajectories + 1) + place * ISOLATED.trajectories
        fractions = (0.5 + numbers[:, None] * steps) % 1
        return np.asarray(self._middle + (2 * fractions - 1) * self._half)


def follow_isolated(
    plane: Plane, lines: list[FanLine], *, everywhere: bool = False
) -> Iterator[Branch]:
    """Add to lines the responses that motions find on them, and return their branches.

    Where stick keeps a response from both ends of a line, others may still cross it: they are
    looked for everywhere.
    """
    starts = Starts(plane.model, [branch for line in lines for branch in line.branches])
    periods = tuple(period for period in PERIODS if period <= plane.settings.largest_period)
    for number, line in enumerate(lines):
        if not (line.branches or everywhere):
            continue
        along = plane.span(line.vary)
        span = extended(plane.model, line.vary, along)
        for i in range(ISOLATED.places):
            value = along[0] + (i + 0.5) / ISOLATED.places * (along[1] - along[0])
            place = plane.place(line.vary, value, line.value)
            try:
                at = plane.at(place)
            except InputError:  # parameters contradict each other there
                continue
            text = "motions that may settle on what no response leads to"
            plane.report("responses", number, len(lines), place, text)
            known = stable_orbits(lines[number].branches, value)
            for orbit in other_orbits(
                at, known, starts.number(number * ISOLATED.places + i), periods
            ):
                begin, branches = Begin(value, orbit=orbit), tuple[Branch, ...]()
                with suppress(InputError):  # it cannot be taken up
                    given = orbit.model, line.vary, span
                    branches = trace_response(*given, settings=plane.settings, begin=begin)
                have = lines[number].branches
                lines[number] = replace(line, branches=(*have, *branches))
                if lines[number].interrupted:
                    return
                yield from branches


def other_orbits(
    model: Model,
    known: Mapping[int, Sequence[Array]],
    states: Array,
    periods: tuple[int, ...] = PERIODS,
) -> Iterator[PeriodicOrbit]:
    """Return the stable orbits of some periods that trajectories settle on and that are not known.

    Shapes: known (m, n); states (k, n).
    """
    found = {period: list(known.get(period, ())) for period in PERIODS}
    for count in ROUNDS:
        states = _advanced(model, states, count)
        gaps = np.min([_moved(model, states, period) for period in PERIODS], axis=0)
        nearly = gaps < ISOLATED.nearly
        settled = np.array([
            state
            for state, gap in zip(states[nearly], gaps[nearly], strict=True)
            if not _is_near(model, state, found, ISOLATED.near * gap + ISOLATED.same)
        ])  # fmt: skip
        going = states[~nearly & np.isfinite(gaps)]
        for period in periods:
            if not len(settled):
                break
            orbits = orbits_from(model, period, settled)
            for nodes in orbits:
                if nodes is None or is_among(model, nodes, period, found[period]):
                    continue
                orbit = _orbit_from(model, period, nodes[0])
                if orbit is not None:
                    found[period].append(orbit.nodes)
                    yield orbit
            settled = settled[[nodes is None for nodes in orbits]]
        if len(settled) and periods != PERIODS:  # some have arrived at what is not looked for
            gaps = np.min([_moved(model, settled, period) for period in periods], axis=0)
            settled = settled[gaps < ISOLATED.nearly]
        states = np.concatenate([going, settled.reshape(-1, states.shape[1])])
        if not len(states):
            break


def _moved(model: Model, states: Array, periods: int) -> Array:
    """Return by how much states move in some forcing periods, in scaled states, shape (k,)."""
    return distances(model, _advanced(model, states, periods), states)


def _is_near(model: Model, state: Array, found: dict[int, list[Array]], reach: float) -> bool:
    """Whether a state lies beside one of the orbits, in any forcing period of it."""
    known = ((period, nodes) for period, orbits in found.items() for nodes in orbits)
    starts = (nodes[:: max(1, len(nodes) // period)] for period, nodes in known)
    return any(distances(model, each, state).min() < reach for each in starts)


def _orbit_from(model: Model, period: int, state: Array) -> PeriodicOrbit | None:
    """Return the stable orbit through a state, to the last digit, None if it is none."""
    try:
        orbit = periodic_orbit(model, period, state)
    except InputError:  # of a shorter period
        return None
    return orbit if orbit.stable and not isinstance(orbit, StickSlipOrbit) else None


def _advanced(model: Model, states: Array, periods: int) -> Array:
    """Return states some forcing periods later, NaN where a trajectory fails."""
    flow = flow_of(model)
    constants = flow.constants_of(model)
    for first in range(0, periods, ISOLATED.call):
        going = np.flatnonzero(np.isfinite(states).all(axis=1))
        if not len(going):
            break
        started = states[going]
        length = float(min(ISOLATED.call, periods - first))
        ends = flow.advance(
            started, np.zeros(len(started)), np.full(len(started), length), constants
        )
        for lane in np.flatnonzero(~np.isfinite(ends).all(axis=1)):  # another may have ended it
            one = slice(lane, lane + 1)
            ends[one] = flow.advance(started[one], np.zeros(1), np.full(1, length), constants)
        states = np.full_like(states, np.nan)
        states[going] = ends
    return states
