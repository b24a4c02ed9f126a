"""Where on an orbit through stick and slip a turn only just does not stick, or only just does."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from slipfold.flow.equations import Constants
from slipfold.flow.switched.events import Ending, Event
from slipfold.flow.switched.mode import Mode, Status, shown
from slipfold.flow.switched.switched_flow import Leg, SwitchedFlow
from slipfold.orbits.stick_slip.touch import CLEAR, LONGEST, SHORT


@dataclass(frozen=True, eq=False)
class Crossing:
    """A turn of a contact along a line: slip crosses zero, and friction only just lets it."""

    before: Mode
    after: Mode
    held: Mode  # the same if it stuck
    stops: Event  # where slip before it comes to zero
    yields: Event  # where friction that holds it cannot any more
    phase: float
    reach: float  # phases on either side that nothing else happens in
    size: float  # of what friction can hold

    @property
    def contact(self) -> int:
        """Number of the contact."""
        return self.stops.which


def find_crossing(
    flow: SwitchedFlow, legs: list[tuple[Leg, Mode]], constants: Constants
) -> Crossing | None:
    """Return the turn whose friction is nearest to what would hold it, None without any."""
    found = _turns(flow, legs, constants)
    best = min(found, key=lambda item: item[0], default=None)
    return None if best is None else best[1]


def _turns(
    flow: SwitchedFlow, legs: list[tuple[Leg, Mode]], constants: Constants
) -> Iterator[tuple[float, Crossing]]:
    """Yield turns, without stick or after a short one, with how near the hold is to its end."""
    for place in range(1, len(legs) - 2):
        leg, after = legs[place]
        stops = leg.event
        if stops is None or stops.ending is not Ending.STOPS or stops.scaled:
            continue
        contact, follows = stops.which, legs[place + 1][0]
        end = follows.end
        if after[contact] is Status.STICK:
            if follows.end - follows.begin > SHORT:
                continue
            after, end = legs[place + 1][1], legs[place + 2][0].end
        if int(after[contact]) != -int(leg.mode[contact]):
            continue
        held = (*after[:contact], Status.STICK, *after[contact + 1 :])
        limits = {
            event.towards: event
            for event in flow.events_of(held)
            if event.ending is Ending.YIELDS and event.which == contact
        }
        yields = limits[after[contact]]
        left = [_left(flow, held, event, leg, constants) for event in limits.values()]
        size = sum(left) / 2
        near = abs(_left(flow, held, yields, leg, constants)) / size
        reach = CLEAR * min(leg.end - leg.begin, end - leg.end, 2 * LONGEST)
        modes = shown(leg.mode), shown(after), shown(held)
        yield near, Crossing(*modes, stops, yields, leg.end, reach, size)


def _left(flow: SwitchedFlow, held: Mode, event: Event, leg: Leg, constants: Constants) -> float:
    slopes, which = flow.event_slopes(held, event)
    return float(slopes.values(leg.state[None], np.array([leg.end]), constants)[0, which])
