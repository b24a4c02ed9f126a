"""Where on an orbit through stick and slip an event is only just met: its function touches zero.

Slip that touches zero between two stretches in the same direction, friction that only just holds,
a contact that is only just lost: a change that is about to be born on the way round, or to vanish.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.switched.events import Ending, Event
from slipfold.flow.switched.mode import Mode, shown
from slipfold.flow.switched.switched_flow import Leg, SwitchedFlow

TOUCHED = {
    "GRAZE": (Ending.STOPS, Ending.SLOWS, Ending.YIELDS),
    "LIFT": (Ending.PARTS, Ending.MEETS),
}
"""Events that are touched at a place where contacts begin or cease to do something."""

MET = (*TOUCHED, "STICK")
"""Types of loci on which a change of contacts is only just met."""

SHORT = 0.02
"""Phases that what has just been born lasts at most."""

PLACES = 64
"""Places on a leg at which events are looked at first."""

LONGEST = 0.05
"""Phases on either side of a touch within which an orbit is carried past it at most."""

CLEAR = 0.5
"""Share of the way to the next change, or to where the function turns back, that is left free."""


LEVEL = 1e-4
"""Share of its size that slip in the plane keeps at a touch."""


@dataclass(frozen=True, eq=False)
class Touch:
    """An event that is touched but does not happen."""

    mode: Mode
    event: Event
    phase: float
    reach: float  # phases on either side that nothing else happens in
    size: float  # of the event's function
    # Its least value over its size: slip in the plane has no direction at none at all
    level: float = 0.0


def find_touch(
    flow: SwitchedFlow, start: Array, legs: list[tuple[Leg, Mode]], constants: Constants, kind: str
) -> Touch | None:
    """Return where a motion comes nearest to one of its events without meeting it.

    Or meets it for an instant. None where it does neither. Shapes: start (n,).
    """
    found = [*_grazed(flow, start, legs, constants, kind), *_born(flow, legs, constants, kind)]
    best = min(found, key=lambda item: item[0], default=None)
    return None if best is None else best[1]


def event_values(
    flow: SwitchedFlow, mode: Mode, event: Event, states: Array, phases: Array, constants: Constants
) -> Array:
    """Return the function of an event, positive before it; of slip in the plane its speed.

    Shapes: states (p, n); phases (p,).
    """
    if event.ending is Ending.SLOWS:
        slips = flow.slips.values(states, phases, constants)
        return np.asarray(np.linalg.norm(slips[:, flow.quantities.places[event.which]], axis=1))
    slopes, which = flow.event_slopes(mode, event)
    values = slopes.values(states, phases, constants)[:, which]
    return -values if event.rising else values


def event_slopes(
    flow: SwitchedFlow,
    mode: Mode,
    event: Event,
    state: Array,
    phase: float,
    constants: Constants,
    directions: Array,
) -> tuple[Array, float, Array]:
    """Return its derivatives by state and phase, and along changes of the coefficients.

    Shapes: state (n,); directions (n_c, k); returns (n,), (), (k,).
    """
    if event.ending is Ending.SLOWS:
        place = flow.quantities.places[event.which]
        slip = flow.slips.values(state[None], np.array([phase]), constants)[0, place]
        along = slip / np.linalg.norm(slip)
        found = flow.slips.at(state, phase, constants, directions)
        by_state, by_phase, pulls = (along @ item[place] for item in found)
        return by_state, float(by_phase), pulls
    slopes, which = flow.event_slopes(mode, event)
    sign = -1.0 if event.rising else 1.0
    found = slopes.at(state, phase, constants, directions)
    by_state, by_phase, pulls = (sign * item[which] for item in found)
    return by_state, float(by_phase), pulls


def _grazed(
    flow: SwitchedFlow, start: Array, legs: list[tuple[Leg, Mode]], constants: Constants, kind: str
) -> Iterator[tuple[float, Touch]]:
    """Yield minima of events' functions between changes, each with how near they are to zero."""
    state = start
    for leg, _ in legs:
        mode = shown(leg.mode)
        if not leg.released and leg.end > leg.begin:
            for event in _touchable(flow, mode, kind):
                yield from _minima(flow, mode, event, state, (leg.begin, leg.end), constants)
        state = leg.state


def _born(
    flow: SwitchedFlow, legs: list[tuple[Leg, Mode]], constants: Constants, kind: str
) -> Iterator[tuple[float, Touch]]:
    """Yield what has been met for a short time, after which contacts go on as before."""
    for place, ((before, _), (leg, after)) in enumerate(pairwise(legs), start=1):
        mode = shown(before.mode)
        returns = before.event is not None and shown(after) == mode != shown(leg.mode)
        if not returns or leg.end - leg.begin > SHORT or not 1 < place < len(legs) - 1:
            continue
        event, follows = before.event, legs[place + 1][0]
        assert event is not None
        if event.ending not in TOUCHED[kind] or event.scaled:  # of slow slip only its end is known
            continue
        start = legs[place - 2][0].state
        # As if nothing had been met, it turns back a little beyond.
        until = leg.end + CLEAR * (follows.end - follows.begin)
        yield from _minima(flow, mode, event, start, (before.begin, until), constants)


def _touchable(flow: SwitchedFlow, mode: Mode, kind: str) -> list[Event]:
    return [event for event in flow.events_of(mode) if event.ending in TOUCHED[kind]]


def _minima(
    flow: SwitchedFlow,
    mode: Mode,
    event: Event,
    start: Array,
    span: tuple[float, float],
    constants: Constants,
) -> Iterator[tuple[float, Touch]]:
    begin, end = span
    phases = np.linspace(begin, end, PLACES + 1)
    states = flow.of(mode).along(start[None], phases[None], constants)[0]
    values = event_values(flow, mode, event, states, phases, constants)
    size = float(np.abs(values).max())
    if not (np.isfinite(values).all() and size > 0):
        return
    steps = np.diff(values)
    for i in np.flatnonzero((steps[:-1] <= 0) & (steps[1:] > 0)) + 1:
        left = i - int(np.argmax(np.append(steps[:i][::-1] > 0, True)))
        right = i + int(np.argmax(np.append(steps[i:] < 0, True)))
        reach = CLEAR * min(phases[i] - phases[left], phases[right] - phases[i], 2 * LONGEST)
        level = LEVEL if event.ending is Ending.SLOWS else 0.0
        touch = Touch(mode, event, float(phases[i]), float(reach), size, level)
        yield abs(float(values[i])) / size, touch
