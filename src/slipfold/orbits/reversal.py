"""Stops of slip at which friction only just holds the contact, or only just does not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.hybrid_flow import HybridFlow, SmoothPhase
from slipfold.flow.modes import Ending, Event, Mode, Status, shown
from slipfold.newton import Rule, find_root
from slipfold.orbits.grazing import CLEAR, LONGEST, SHORT, MarginalShooting
from slipfold.orbits.switched_shooting import Passed, SwitchedShooting

TURN = Rule(close=1e-9, iterations=10)
"""The phase at which slip is zero has converged after a step this short: it is left with its
square."""

UNTOLD = 1e-7
"""Phases of stick that are not told from none: another turn may begin to stick at once, as of an
orbit that is its own mirror image."""


@dataclass(frozen=True, eq=False)
class Reversal:
    """A contact along a line that stops while friction only just holds it, or only just does not.

    Slip reverses at once, or the contact sticks for long: after a short stick, or a short slip
    backwards, it does the same.
    """

    before: Mode
    after: Mode  # with the contact in reversed slip, or sticking
    held: Mode  # the same if it stuck
    stops: Event  # where slip before it reaches zero
    yields: Event  # where friction that holds it cannot any more
    phase: float
    reach: float  # phases on either side that nothing else happens in
    size: float  # of what friction can hold

    @property
    def contact(self) -> int:
        """Number of the contact."""
        return self.stops.which


def _reversals(
    flow: HybridFlow,
    smooth_phases: list[tuple[SmoothPhase, Mode]],
    constants: Constants,
    sticks: bool | None,
) -> Iterator[tuple[float, Reversal]]:
    """Yield stops after which contacts slip back, or stick, with how near friction is to its limit.

    What lasts a short time only before that is passed over; nothing is where `sticks` is None.
    """
    for place in range(1, len(smooth_phases) - 2):
        leg, after = smooth_phases[place]
        stops = leg.event
        if stops is None or stops.ending is not Ending.STOPS or stops.scaled:
            continue
        contact, (follows, later) = stops.which, smooth_phases[place + 1]
        back = Status(-int(leg.mode[contact]))
        expected = Status.STICK if sticks or (sticks is None and after[contact] != back) else back
        end = follows.end
        if after[contact] is not expected and end - follows.begin <= SHORT:
            after, end = later, smooth_phases[place + 2][0].end
        if after[contact] is not expected:
            continue
        held = (*after[:contact], Status.STICK, *after[contact + 1 :])
        limits = {
            event.towards: event
            for event in flow.mode(held).events
            if event.ending is Ending.YIELDS and event.which == contact
        }
        yields = limits[back]
        left = [_left(flow, held, event, leg, constants) for event in limits.values()]
        size = sum(left) / 2
        near = abs(_left(flow, held, yields, leg, constants)) / size
        reach = CLEAR * min(leg.end - leg.begin, end - leg.end, 2 * LONGEST)
        modes = shown(leg.mode), shown(after), shown(held)
        yield near, Reversal(*modes, stops, yields, leg.end, reach, size)


def _left(
    flow: HybridFlow, held: Mode, event: Event, leg: SmoothPhase, constants: Constants
) -> float:
    slopes, which = flow.mode(held).slopes_of(event)
    return float(slopes.values(leg.state[None], np.array([leg.end]), constants)[0, which])


class ReversalShooting(MarginalShooting):
    """Orbits that pass a stop as if friction could not hold the contact there, or as if it could.

    Where it could for a moment, slip would begin in the wrong direction, of second order in time;
    where it could not for a moment, slip backwards would be of third order. So orbits depend
    smoothly on everything on either side. The condition is that friction at the stop is just what
    holds the contact. The node lies just before.
    """

    met: Reversal

    @classmethod
    def at(cls, by: SwitchedShooting, nodes: Array, constants: Constants) -> Self | None:
        """Return what passes the reversal of an orbit that friction holds least clearly.

        None if slip reverses nowhere. Shapes: nodes (1, n).
        """
        return next((item for _, item in cls.of(by, nodes, constants, sticks=False)), None)

    @classmethod
    def of(
        cls, by: SwitchedShooting, nodes: Array, constants: Constants, *, sticks: bool | None = None
    ) -> list[tuple[float, Self]]:
        """Return what passes each reversal, or each stop, with how near its hold is to its end.

        Nearest first. Of an orbit whose static friction is more than kinetic either may be all that
        exists: without `sticks` it is passed as it is. Shapes: nodes (1, n).
        """
        begin, period = float(by.start[0]), by.period
        passed = by.passed(nodes[0], begin, begin + 2 * period, constants)
        # What an orbit passes in its own window it may pass otherwise a period later.
        found = [(0.0, by)] if isinstance(by, cls) and sticks is not None else []
        stops = _reversals(by.switched, passed, constants, sticks)
        for near, met in sorted(stops, key=lambda item: item[0]):
            gaps = [abs((met.phase - other.met.phase) / period) for _, other in found]
            if all(abs(gap - round(gap)) * period > SHORT for gap in gaps):
                found.append((near, cls(by.model, by.free, period, met)))
        return found

    def piece(self, nodes: Array, constants: Constants) -> tuple[Mode, ...]:
        """Return what contacts do in turn, without stick that is as good as none."""
        found = [
            mode
            for begin, end, mode in self.spans(nodes, constants)
            if end - begin > UNTOLD or Status.STICK not in mode
        ]
        return min((tuple(found[i:] + found[:i]) for i in range(len(found))), default=())

    def passed(self, start: Array, begin: float, end: float, constants: Constants) -> Passed:
        """Carry a state from the node to another phase; nothing where it cannot continue.

        Shapes: start (n,).
        """
        if not (np.isfinite(start).all() and np.isfinite(constants.values).all()):
            return []
        flow, turn = self.switched, self.met
        none = flow.no_energies()
        phase = self._turn(start, begin, constants)
        if phase is None:
            return []
        if end <= phase:
            state = self._carried_in(turn.before, start, begin, end, constants)
            return [(SmoothPhase(turn.before, begin, end, state, none, None), turn.before)]
        state = self._carried_in(turn.before, start, begin, phase, constants)
        state = flow.held(turn.held, state, phase, constants)
        first = SmoothPhase(turn.before, begin, phase, state, none, turn.stops), turn.after
        until = min(end, self._beyond)
        beyond = self._carried_in(turn.after, state, phase, until, constants)
        second = SmoothPhase(turn.after, phase, until, beyond, none, None), turn.after
        if end <= self._beyond:
            return [first, second]
        after = turn.after[turn.contact]
        if (
            after is not Status.STICK
            and not self._slip(beyond, until, constants) * float(after) > 0
        ):
            return []
        found = self.beyond(flow.system(start, constants), turn.after, beyond, end)
        return [first, second, *found] if found else []

    def condition(self, nodes: Array, constants: Constants) -> tuple[float, Array, Array]:
        """Return what friction lacks to hold the contact, over its scale, with its derivatives."""
        switched, turn = self.switched, self.met
        flow, along = switched.of(turn.before), constants.rates[:, self.indices]
        phase = self._turn(nodes[0], float(self.start[0]), constants)
        if phase is None:
            return np.nan, np.full(len(self.scales), np.nan), np.full(len(self.units), np.nan)
        end = np.array([phase])
        states, matrices, vectors = flow.linearize(nodes, self.start, end, constants, along)
        rates = flow.rates(states, end, constants)[0]
        varied = np.hstack([matrices[0], vectors[0]])
        n = len(self.scales)
        place = switched.quantities.places[turn.contact].start
        by_state, by_phase, pulls = (
            item[place] for item in switched.slips.at(states[0], phase, constants, along)
        )
        met = by_state @ varied
        met[n:] += pulls
        later = -met / (by_state @ rates + by_phase)
        varied = varied + np.outer(rates, later)
        slopes, which = switched.mode(turn.held).slopes_of(turn.yields)
        value = float(slopes.values(states, end, constants)[0, which])
        by_state, by_phase, pulls = (
            item[which] for item in slopes.at(states[0], phase, constants, along)
        )
        slope = by_state @ varied + by_phase * later
        by_nodes, by_free = slope[:n] * self.scales, (slope[n:] + pulls) * self.units
        return value / turn.size, by_nodes / turn.size, by_free / turn.size

    def again(self, nodes: Array, constants: Constants) -> Self | None:
        """Return the same for the reversal as it is found again, None if it is not."""
        begin = float(self.start[0])
        passed = self.passed(nodes[0], begin, begin + 2 * self.period, constants)
        stops = _reversals(self.switched, passed, constants, self.sticks)
        found = min(stops, key=lambda item: item[0], default=None)
        return None if found is None else type(self)(self.model, self.free, self.period, found[1])

    @property
    def sticks(self) -> bool:
        """Whether the contact sticks after its stop."""
        return self.met.after[self.met.contact] is Status.STICK

    def phase_of_event(self, nodes: Array, constants: Constants) -> float | None:
        """Return the phase in the window at which slip is zero, None if it is nowhere."""
        return self._turn(nodes[0], float(self.start[0]), constants)

    def _turn(self, start: Array, begin: float, constants: Constants) -> float | None:
        """Return the phase in the window at which slip is zero, None if it is nowhere."""
        turn = self.met
        flow, none = self.switched.of(turn.before), np.empty((len(constants.values), 0))
        place = self.switched.quantities.places[turn.contact].start

        def step(phases: Array) -> Array:
            phase = float(phases[0])
            if not begin < phase < self._beyond:
                return np.full(1, np.nan)
            state = self._carried_in(turn.before, start, begin, phase, constants)
            rates = flow.rates(state[None], phases, constants)[0]
            by_state, by_phase, _ = self.switched.slips.at(state, phase, constants, none)
            return -self._slip(state, phase, constants) / (
                by_state[[place]] @ rates + by_phase[place]
            )

        found = find_root(step, np.array([turn.phase]), TURN)
        return float(found[0]) if found is not None and begin < found[0] < self._beyond else None

    def _slip(self, state: Array, phase: float, constants: Constants) -> float:
        place = self.switched.quantities.places[self.met.contact].start
        return float(self.switched.quantities.at(state, phase, constants).slip[place])

    def _carried_in(
        self, mode: Mode, state: Array, begin: float, end: float, constants: Constants
    ) -> Array:
        """Carry a state on in one mode, whatever happens. Shapes: state (n,); returns (n,)."""
        flow, span = self.switched.of(mode), (np.array([begin]), np.array([end]))
        return np.asarray(flow.advance(state[None], *span, constants)[0])
