"""Shooting past a turn that begins to stick: as if it never did, on either side of that."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.switched.mode import Mode, Status
from slipfold.flow.switched.mode_equations import Undetermined
from slipfold.flow.switched.switched_flow import Leg
from slipfold.flow.switched.switched_motion import Broken, legs
from slipfold.flow.switched.transition import Undecided
from slipfold.models.model import Model
from slipfold.newton import Rule, find_root
from slipfold.orbits.discretisations.switched_shooting import Passed, SwitchedShooting
from slipfold.orbits.stick_slip.crossing import Crossing, find_crossing
from slipfold.orbits.stick_slip.met_shooting import MetShooting

TURN = Rule(close=1e-9, iterations=10)
"""The phase at which slip is zero has converged after a step this short: it is left with its
square."""

OFF = 0.25
"""Share of the reach by which the turn may move away from the middle of the window."""

UNTOLD = 1e-7
"""Phases of stick that are not told from none: another turn may begin to stick at once, as of an
orbit that is its own mirror image."""


class CrossingShooting(MetShooting):
    """Orbits that pass a turn as if friction could not hold the contact there.

    Where it could for a moment, slip would begin in the wrong direction, of second order in time:
    orbits depend smoothly on everything on either side. The condition is that friction at the turn
    is just what holds the contact. The node lies just before.
    """

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int,
        crossing: Crossing,
        lead: float = 0.5,
    ) -> None:
        self.crossing, self.lead = crossing, lead
        super().__init__(model, free, period, 1, crossing.phase - lead * crossing.reach)
        self._beyond = self.phase + (lead + 0.5) * crossing.reach

    @classmethod
    def at(
        cls, by: SwitchedShooting, nodes: Array, constants: Constants
    ) -> CrossingShooting | None:
        """Return what passes a turn of an orbit, None if it has none. Shapes: nodes (1, n)."""
        begin = float(by.start[0])
        passed = by.passed(nodes[0], begin, begin + 2 * by.period, constants)
        crossing = find_crossing(by.switched, passed, constants)
        return None if crossing is None else cls(by.model, by.free, by.period, crossing)

    def piece(self, nodes: Array, constants: Constants) -> tuple[Mode, ...]:
        """Return what contacts do one after the other, without stick that is as good as none."""
        found = [
            mode
            for begin, end, mode in self.spans(nodes, constants)
            if end - begin > UNTOLD or Status.STICK not in mode
        ]
        return min((tuple(found[i:] + found[:i]) for i in range(len(found))), default=())

    def passed(self, start: Array, begin: float, end: float, constants: Constants) -> Passed:
        """Carry a state from the node to another phase; nothing where it cannot go on.

        Shapes: start (n,).
        """
        if not (np.isfinite(start).all() and np.isfinite(constants.values).all()):
            return []
        flow, turn = self.switched, self.crossing
        none = flow.no_energies()
        phase = self._turn(start, begin, constants)
        if phase is None:
            return []
        if end <= phase:
            state = self._carried_in(turn.before, start, begin, end, constants)
            return [(Leg(turn.before, begin, end, state, none, None), turn.before)]
        state = self._carried_in(turn.before, start, begin, phase, constants)
        state = flow.held(turn.held, state, phase, constants)
        first = Leg(turn.before, begin, phase, state, none, turn.stops), turn.after
        until = min(end, self._beyond)
        beyond = self._carried_in(turn.after, state, phase, until, constants)
        second = Leg(turn.after, phase, until, beyond, none, None), turn.after
        if end <= self._beyond:
            return [first, second]
        slip = self._slip(beyond, until, constants)
        if not slip * float(turn.after[turn.contact]) > 0:
            return []
        weights = flow.weights(start, constants)
        try:
            found = list(legs(flow, turn.after, beyond, end, constants, weights, begin=until))
        except (Broken, Undecided, Undetermined):
            return []
        return [first, second, *found] if found[-1][0].end <= end else []

    def touched(self, nodes: Array, constants: Constants) -> tuple[float, Array, Array]:
        """Return what friction at the turn is short of holding it, over its size; its derivatives.

        By scaled states and scaled free parameters. Shapes: nodes (1, n); returns (), (n,), (k,).
        """
        switched, turn = self.switched, self.crossing
        flow, along = switched.of(turn.before), constants.rates[:, self.indices]
        phase = self._turn(nodes[0], float(self.start[0]), constants)
        if phase is None:
            return np.nan, np.full(len(self.scales), np.nan), np.full(len(self.units), np.nan)
        end = np.array([phase])
        states, matrices, vectors = flow.linearise(nodes, self.start, end, constants, along)
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
        slopes, which = switched.event_slopes(turn.held, turn.yields)
        value = float(slopes.values(states, end, constants)[0, which])
        by_state, by_phase, pulls = (
            item[which] for item in slopes.at(states[0], phase, constants, along)
        )
        slope = by_state @ varied + by_phase * later
        by_nodes, by_free = slope[:n] * self.scales, (slope[n:] + pulls) * self.units
        return value / turn.size, by_nodes / turn.size, by_free / turn.size

    def better(self, nodes: Array, constants: Constants) -> CrossingShooting | None:
        """Return one in whose window the turn lies in the middle, None if it does here."""
        phase = self._turn(nodes[0], float(self.start[0]), constants)
        if phase is None or abs(phase - self.crossing.phase) < OFF * self.crossing.reach:
            return None
        found = CrossingShooting.at(self, nodes, constants)
        if found is not None:
            return found
        turn = replace(self.crossing, phase=phase)
        return CrossingShooting(self.model, self.free, self.period, turn)

    def with_period(self, period: int) -> CrossingShooting:
        """Return the same for orbits of another period."""
        return CrossingShooting(self.model, self.free, period, self.crossing)

    def shifted(
        self, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[CrossingShooting, Array, Array]:
        """Return the same begun earlier in the window: all steps then are others."""
        turn = self.crossing
        other = CrossingShooting(self.model, self.free, self.period, turn, lead=0.8)
        return other, *self.moved_to(other, nodes, constants, along, rates)

    def _turn(self, start: Array, begin: float, constants: Constants) -> float | None:
        """Return the phase in the window at which slip is zero, None if it is nowhere."""
        turn = self.crossing
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
        place = self.switched.quantities.places[self.crossing.contact].start
        return float(self.switched.quantities.at(state, phase, constants).slip[place])

    def _carried_in(
        self, mode: Mode, state: Array, begin: float, end: float, constants: Constants
    ) -> Array:
        """Carry a state on in one mode, whatever happens. Shapes: state (n,); returns (n,)."""
        flow, span = self.switched.of(mode), (np.array([begin]), np.array([end]))
        return np.asarray(flow.advance(state[None], *span, constants)[0])
