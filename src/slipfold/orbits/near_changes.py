"""How far an orbit is from changes of contacts that it does not make, and from losing its own."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.linearized_trajectory import EventMargin, Least, least_near
from slipfold.flow.modes import Ending, Status
from slipfold.orbits.marginal import near_stops
from slipfold.orbits.switched_shooting import SAMPLES, Passed, SwitchedShooting

EXACT = 0.02
"""Fraction of its size below which a minimum is computed exactly."""

MOVED = 0.05
"""Phases by which a change may move from one orbit to the next."""

Margin = tuple[Hashable, float, float]
"""What a margin is of, its phase, and its value over its size."""


class Margins(NamedTuple):
    """Positive functions of an orbit, each zero where contacts begin or cease to do something."""

    kinds: Array  # numbers that stand for what they are of, shape (q,)
    phases: Array
    values: Array

    def like(self, others: Margins, period: float) -> Array:
        """Return those of the same changes as others, by their phases; NaN where there is none."""
        if not len(self.kinds):
            return np.full(len(others.kinds), np.nan)
        apart = self.phases - others.phases[:, None]
        apart = np.abs((apart + period / 2) % period - period / 2)
        apart[self.kinds != others.kinds[:, None]] = np.inf
        values = self.values[apart.argmin(axis=1)]
        return np.where(apart.min(axis=1) < MOVED, values, np.nan)


def margins_of(by: SwitchedShooting, nodes: Array, constants: Constants) -> Margins:
    """Return the margins of an orbit whose contacts lie along lines. Shapes: nodes (1, n)."""
    start, passed = _from_change(by, nodes, constants)
    around = [
        (replace(part, begin=part.begin + turn * by.period, end=part.end + turn * by.period), after)
        for turn in range(4)
        for part, after in passed
    ]
    stops = near_stops(by.switched, around[: len(passed) + 3], constants, None)
    found = [
        *_grazed(by, start, passed, constants),
        *_durations(by, nodes, constants),
        *(((met.kind, met.event.which, met.event.towards), met.phase, left) for left, met in stops),
    ]
    kinds, phases, values = zip(*found, strict=True) if found else ((), (), ())
    return Margins(np.array([*map(hash, kinds)]), np.array(phases), np.array(values))


def _from_change(by: SwitchedShooting, nodes: Array, constants: Constants) -> tuple[Array, Passed]:
    """Return a state and the smooth phases of an orbit from it on: nothing changes at the node."""
    passed = by.round(nodes, constants)
    if len(passed) < 2:
        return nodes[0], [(replace(part, end=part.end + MOVED), after) for part, after in passed]
    (first, after), *others, (last, _) = passed
    return first.state, [
        *others,
        (replace(first, begin=last.begin, end=first.end + by.period), after),
    ]


def _durations(by: SwitchedShooting, nodes: Array, constants: Constants) -> Iterator[Margin]:
    """Yield how long modes last: what begins at a grazing grows as the root of the distance."""
    for group in by.switched.groups(constants):
        spans = by.spans(nodes, constants, group)
        for place, (begin, end, mode) in enumerate(spans if len(spans) > 1 else ()):
            before, after = spans[place - 1][2], spans[(place + 1) % len(spans)][2]
            lasts = (end - begin) ** (2 if before == after else 1)
            yield (*group, before, mode, after), (begin + end) / 2, lasts


def _grazed(
    by: SwitchedShooting, state: Array, passed: Passed, constants: Constants
) -> Iterator[Margin]:
    """Yield the minima of events that do not happen. Shapes: state (n,)."""
    flow = by.switched
    for part, _ in passed:
        start, state, mode = state, part.state, part.reported_mode
        events = [event for event in flow.mode(mode).events if not event.scaled]
        if not events or part.released or Status.SLOW in part.mode or part.end <= part.begin:
            continue
        count = int(SAMPLES * (part.end - part.begin)) + 3
        phases = np.linspace(part.begin, part.end, count)
        states = flow.of(mode).along(start[None], phases[None], constants)[0]
        table = flow.mode(mode).slopes_of(events[0])[0].values(states, phases, constants)
        for event, values in zip(events, table.T, strict=True):
            if event.ending is Ending.LIMIT:
                continue
            values = -values if event.rising else values
            size, steps = float(np.abs(values).max()), np.diff(values)
            what = event.which, event.ending, event.towards, mode[event.which]
            for at in (np.flatnonzero((steps[:-1] <= 0) & (steps[1:] > 0)) + 1).tolist():
                bend = steps[at] - steps[at - 1]
                value = float(values[at] - (steps[at] + steps[at - 1]) ** 2 / (8 * bend))
                if value < EXACT * size:
                    margin = EventMargin(flow, mode, event, constants)
                    sampled = Least(value, margin, 0, start, float(phases[at]))
                    value = least_near(sampled, phases, at).value
                yield what, float(phases[at]), value / size
