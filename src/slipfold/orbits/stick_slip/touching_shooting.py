"""Shooting past an event that is touched: as if it did not happen, on either side of the touch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.switched.mode_equations import Undetermined
from slipfold.flow.switched.switched_flow import Leg
from slipfold.flow.switched.switched_motion import Broken, legs
from slipfold.flow.switched.transition import Undecided
from slipfold.models.model import Model
from slipfold.orbits.discretisations.switched_shooting import Passed, SwitchedShooting
from slipfold.orbits.stick_slip.met_shooting import MetShooting
from slipfold.orbits.stick_slip.touch import Touch, event_slopes, event_values, find_touch

GRID = 16
"""Places in the window at which the least value is looked for first."""

CORRECTIONS = 8

EXACT = 1e-9
"""Change of the phase of the least value at which it is found: the value changes by its square."""

OFF = 0.25
"""Share of the reach by which the touch may move away from the middle of the window."""


class TouchingShooting(MetShooting):
    """Orbits through stick and slip that pass a touch as if the event there could not happen.

    So they depend smoothly on everything on either side of the touch, and how far the event's
    function stays from zero is a smooth condition that tells the touch. The node lies just before.
    """

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int,
        touch: Touch,
        kind: str,
        lead: float = 0.5,
    ) -> None:
        self.touch, self.kind, self.lead = touch, kind, lead
        # What an orbit does at the window's beginning it does there the next time round.
        super().__init__(model, free, period, 1, touch.phase - lead * touch.reach)
        self._beyond = self.phase + (lead + 0.5) * touch.reach
        self.level = touch.level

    @classmethod
    def at(
        cls, by: SwitchedShooting, nodes: Array, constants: Constants, kind: str
    ) -> TouchingShooting | None:
        """Return what passes the touch of an orbit, None if it has none. Shapes: nodes (1, n)."""
        begin, start = float(by.start[0]), nodes[0]
        passed = by.passed(start, begin, begin + 2 * by.period, constants)
        if isinstance(by, TouchingShooting) and passed:
            # Its own window is no room to judge by: a narrower one would follow, and so on.
            start, passed = passed[0][0].state, passed[1:]
        touch = find_touch(by.switched, start, passed, constants, kind)
        return None if touch is None else cls(by.model, by.free, by.period, touch, kind)

    def passed(self, start: Array, begin: float, end: float, constants: Constants) -> Passed:
        """Carry a state from the node to another phase; nothing where it cannot go on.

        Shapes: start (n,).
        """
        if not (np.isfinite(start).all() and np.isfinite(constants.values).all()):
            return []
        flow, mode = self.switched, self.touch.mode
        until = min(end, self._beyond)
        states, span = start[None], (np.array([begin]), np.array([until]))
        ends = flow.of(mode).advance(states, *span, constants)
        state = flow.held(mode, ends[0], until, constants)
        window = Leg(mode, begin, until, state, flow.no_energies(), None), mode
        if end <= self._beyond:
            return [window]
        weights = flow.weights(start, constants)
        try:
            found = list(legs(flow, mode, state, end, constants, weights, begin=until))
        except (Broken, Undecided, Undetermined):
            return []
        return [window, *found] if found[-1][0].end <= end else []

    def touched(self, nodes: Array, constants: Constants) -> tuple[float, Array, Array]:
        """Return the least value of the event's function, over its size, with its derivatives.

        By scaled states and scaled free parameters. Shapes: nodes (1, n); returns (), (n,), (k,).
        """
        flow, touch = self.switched.of(self.touch.mode), self.touch
        phase = self._least(nodes, constants)
        if phase is None:
            return np.nan, np.full(len(self.scales), np.nan), np.full(len(self.units), np.nan)
        along, end = constants.rates[:, self.indices], np.array([phase])
        states, matrices, vectors = flow.linearise(nodes, self.start, end, constants, along)
        of = self.switched, touch.mode, touch.event
        value = float(event_values(*of, states, end, constants)[0])
        by_state, _, pulls = event_slopes(*of, states[0], phase, constants, along)
        by_nodes = by_state @ matrices[0] * self.scales
        by_free = (by_state @ vectors[0] + pulls) * self.units
        return value / touch.size - touch.level, by_nodes / touch.size, by_free / touch.size

    def _least(self, nodes: Array, constants: Constants) -> float | None:
        """Return the phase in the window at which the event's function is smallest."""
        flow, begin = self.switched.of(self.touch.mode), float(self.start[0])
        phases = np.linspace(begin, self._beyond, GRID + 1)
        states = flow.along(nodes, phases[None], constants)[0]
        rates = self._event_rates(states, phases, constants)
        crossed = np.flatnonzero((rates[:-1] < 0) & (rates[1:] >= 0))
        if not len(crossed):
            return None
        i = int(crossed[np.abs(phases[crossed] - self.touch.phase).argmin()])
        (last, phase), (before, rate) = phases[i : i + 2].tolist(), rates[i : i + 2].tolist()
        low, high = last, phase
        for _ in range(CORRECTIONS):  # by secants: the rate is as good as straight
            following = phase - rate * (phase - last) / (rate - before)
            last, before, phase = phase, rate, min(max(following, low), high)
            if abs(phase - last) < EXACT:
                break
            ends = flow.advance(nodes, self.start, np.array([phase]), constants)
            rate = float(self._event_rates(ends, np.array([phase]), constants)[0])
        return phase

    def _event_rates(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Return how fast the event's function grows a phase. Shapes: states (p, n)."""
        touch, none = self.touch, np.empty((len(constants.values), 0))
        rates = self.switched.of(touch.mode).rates(states, phases, constants)
        of, found = (self.switched, touch.mode, touch.event), np.empty(len(states))
        for place, (state, phase) in enumerate(zip(states, phases.tolist(), strict=True)):
            by_state, by_phase, _ = event_slopes(*of, state, phase, constants, none)
            found[place] = by_state @ rates[place] + by_phase
        return found

    def better(self, nodes: Array, constants: Constants) -> TouchingShooting | None:
        """Return one in whose window the touch lies in the middle, None if it does here."""
        phase = self._least(nodes, constants)
        if phase is None or abs(phase - self.touch.phase) < OFF * self.touch.reach:
            return None
        found = TouchingShooting.at(self, nodes, constants, self.kind)
        if found is not None:
            return found
        touch = replace(self.touch, phase=phase)
        return TouchingShooting(self.model, self.free, self.period, touch, self.kind)

    def with_period(self, period: int) -> TouchingShooting:
        """Return the same for orbits of another period."""
        return TouchingShooting(self.model, self.free, period, self.touch, self.kind)

    def shifted(
        self, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[TouchingShooting, Array, Array]:
        """Return the same begun earlier in the window: all steps then are others."""
        other = TouchingShooting(
            self.model, self.free, self.period, self.touch, self.kind, lead=0.8
        )
        return other, *self.moved_to(other, nodes, constants, along, rates)
