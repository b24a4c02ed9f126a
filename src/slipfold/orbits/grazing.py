"""Shooting through stick and slip past an event that is only just met, or only just not met."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Self

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.contact_state import Undecided
from slipfold.flow.equations import Constants
from slipfold.flow.hybrid_flow import HybridFlow, HybridSystem, SmoothPhase
from slipfold.flow.hybrid_trajectory import Broken, smooth_phases
from slipfold.flow.modes import GRAZED, Ending, Event, Mode, Undetermined, shown
from slipfold.models.model import Model
from slipfold.orbits.switched_shooting import Passed, SwitchedShooting

OFF_CENTER = 0.25
"""Fraction of the reach by which the event may move away from the middle of the window."""


class MarginalShooting(SwitchedShooting):
    """Orbits that pass an event in a window alike on either side of it.

    So they depend smoothly on everything there, and so does the function that is zero where the
    event is only just met. The node lies at the beginning of the window, where the orbit does the
    same in the next period.

    `met` is the event, with its phase and the `reach` of phases in which nothing else happens.
    """

    level = 0.0
    """Value of the function, over its scale, where it cannot vanish."""

    def __init__(
        self, model: Model, free: Mapping[str, float], period: int, met: Any, lead: float = 0.5
    ) -> None:
        self.met = met
        super().__init__(model, free, period, 1, met.phase - lead * met.reach)
        self._beyond = met.phase + 0.5 * met.reach

    @abstractmethod
    def condition(self, nodes: Array, constants: Constants) -> tuple[float, Array, Array]:
        """Return the function that is zero where the event is met, with its derivatives.

        It is divided by its scale; the derivatives are by scaled states and scaled free parameters.
        Shapes: nodes (1, n); returns (), (n,), (k,).
        """

    def condition_of(
        self, by: SwitchedShooting, nodes: Array, constants: Constants
    ) -> tuple[float, Array, Array]:
        """Return the same of an orbit given at the node of another. Shapes: nodes (1, n)."""
        if by is self:
            return self.condition(nodes, constants)
        _, states, matrices, vectors = by.carried_to(nodes, constants, self.start)
        value, by_state, by_free = self.condition(states, constants)
        moved = vectors[0] * (self.units / self.scales[:, None])
        return value, by_state @ (matrices[0] * self.ratios), by_free + by_state @ moved

    @abstractmethod
    def again(self, nodes: Array, constants: Constants) -> Self | None:
        """Return the same for the event as it is found again, None if it is not."""

    @abstractmethod
    def phase_of_event(self, nodes: Array, constants: Constants) -> float | None:
        """Return the phase of the event in the window, None if there is none."""

    def better(self, nodes: Array, constants: Constants) -> Self | None:
        """Return one in whose window the event lies in the middle, None if it does here."""
        phase = self.phase_of_event(nodes, constants)
        if phase is None or abs(phase - self.met.phase) < OFF_CENTER * self.met.reach:
            return None
        met = replace(self.met, phase=phase)
        return self.again(nodes, constants) or type(self)(self.model, self.free, self.period, met)

    def with_period(self, period: int) -> Self:
        """Return the same for orbits of another period."""
        return type(self)(self.model, self.free, period, self.met)

    def shifted(
        self, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[Self, Array, Array]:
        """Return the same with an earlier beginning of the window: all steps then are others."""
        other = type(self)(self.model, self.free, self.period, self.met, lead=0.8)
        return other, *self.moved_to(other, nodes, constants, along, rates)

    def beyond(self, system: HybridSystem, mode: Mode, state: Array, end: float) -> Passed:
        """Return what follows the window; nothing where the trajectory cannot continue."""
        try:
            found = list(smooth_phases(system, mode, state, end, begin=self._beyond))
        except (Broken, Undecided, Undetermined):
            return []
        return found if found[-1][0].end <= end else []


SHORT = 0.02
"""Phases that what has just been born lasts at most."""

PLACES = 64
"""Places on a leg at which events are examined first."""

LONGEST = 0.05
"""Phases on either side of a touch within which an orbit is carried past it at most."""

CLEAR = 0.5
"""Fraction of the way to the next change, or to where the function turns back, left free."""


LEVEL = 1e-4
"""Fraction of its size that slip in the plane keeps at a grazing."""

EXACT = 1e-9
"""Change of the phase of the least value at which it is found: the value changes by its square."""


@dataclass(frozen=True, eq=False)
class Grazing:
    """An event that is only just met, or only just not met."""

    kind: str  # "GRAZE" or "LIFT"
    mode: Mode
    event: Event
    phase: float
    reach: float  # phases on either side that nothing else happens in
    size: float  # of the event's function
    # Its least value over its size: slip in the plane has no direction at none at all
    level: float = 0.0


@dataclass(frozen=True, eq=False)
class _EventFunction:
    """The function of an event, positive before it; of slip in the plane its speed."""

    flow: HybridFlow
    mode: Mode
    event: Event
    constants: Constants

    def values(self, states: Array, phases: Array) -> Array:
        """Return its values, shape (p,). Shapes: states (p, n); phases (p,)."""
        flow, event = self.flow, self.event
        if event.ending is Ending.SLOWS:
            slips = flow.slips.values(states, phases, self.constants)
            return np.asarray(np.linalg.norm(slips[:, flow.quantities.places[event.which]], axis=1))
        slopes, which = flow.mode(self.mode).slopes_of(event)
        values = slopes.values(states, phases, self.constants)[:, which]
        return -values if event.rising else values

    def slopes(self, state: Array, phase: float, directions: Array) -> tuple[Array, float, Array]:
        """Return its derivatives by state and phase, and along changes of the coefficients.

        Shapes: state (n,); directions (n_c, k); returns (n,), (), (k,).
        """
        flow, event = self.flow, self.event
        if event.ending is Ending.SLOWS:
            which = flow.quantities.places[event.which]
            slip = flow.slips.values(state[None], np.array([phase]), self.constants)[0, which]
            along, found = slip / np.linalg.norm(slip), flow.slips
            parts = [
                along @ item[which] for item in found.at(state, phase, self.constants, directions)
            ]
        else:
            slopes, place = flow.mode(self.mode).slopes_of(event)
            sign = -1.0 if event.rising else 1.0
            parts = [
                sign * item[place] for item in slopes.at(state, phase, self.constants, directions)
            ]
        return parts[0], float(parts[1]), parts[2]

    def minima(self, start: Array, begin: float, end: float, kind: str) -> Iterator[Near]:
        """Yield the minima on the way from a state, each with how near it is to zero."""
        phases = np.linspace(begin, end, PLACES + 1)
        states = self.flow.of(self.mode).along(start[None], phases[None], self.constants)[0]
        values = self.values(states, phases)
        size = float(np.abs(values).max())
        if not (np.isfinite(values).all() and size > 0):
            return
        steps = np.diff(values)
        for i in np.flatnonzero((steps[:-1] <= 0) & (steps[1:] > 0)) + 1:
            left = i - int(np.argmax(np.append(steps[:i][::-1] > 0, True)))
            right = i + int(np.argmax(np.append(steps[i:] < 0, True)))
            reach = CLEAR * min(phases[i] - phases[left], phases[right] - phases[i], 2 * LONGEST)
            level = LEVEL if self.event.ending is Ending.SLOWS else 0.0
            at = float(phases[i]), float(reach), size, level
            yield abs(float(values[i])) / size, Grazing(kind, self.mode, self.event, *at)


Near = tuple[float, Grazing]


def find_grazing(
    flow: HybridFlow, start: Array, passed: Passed, constants: Constants, kind: str
) -> Grazing | None:
    """Return where a trajectory comes nearest to one of its events without meeting it.

    Or meets it for an instant. None where it does neither. Shapes: start (n,).
    """
    found, state = list[Near](), start
    for leg, _ in passed:
        mode = shown(leg.mode)
        if not leg.released and leg.end > leg.begin:
            for event in flow.mode(mode).events:
                if event.ending in GRAZED[kind]:
                    function = _EventFunction(flow, mode, event, constants)
                    found += function.minima(state, leg.begin, leg.end, kind)
        state = leg.state
    # What was met for a short time, after which contacts continue as before.
    for place, ((before, _), (leg, after)) in enumerate(pairwise(passed), start=1):
        mode, met = shown(before.mode), before.event
        returns = met is not None and shown(after) == mode != shown(leg.mode)
        if not returns or leg.end - leg.begin > SHORT or not 1 < place < len(passed) - 1:
            continue
        assert met is not None
        if met.ending in GRAZED[kind] and not met.scaled:  # of slow slip only its end is known
            follows, begin = passed[place + 1][0], passed[place - 2][0].state
            # As if nothing had been met, it turns back a little beyond.
            until = leg.end + CLEAR * (follows.end - follows.begin)
            function = _EventFunction(flow, mode, met, constants)
            found += function.minima(begin, before.begin, until, kind)
    best = min(found, key=lambda item: item[0], default=None)
    return None if best is None else best[1]


class GrazingShooting(MarginalShooting):
    """Orbits through stick and slip that pass a grazing as if the event could not happen.

    How far the event's function stays from zero is a smooth condition for the grazing.
    """

    met: Grazing

    @property
    def level(self) -> float:  # type: ignore[override]
        """Value of the function, over its scale, where it cannot vanish."""
        return self.met.level

    @classmethod
    def at(cls, by: SwitchedShooting, nodes: Array, constants: Constants, kind: str) -> Self | None:
        """Return what passes the grazing of an orbit, None if it has none.

        Shapes: nodes (1, n).
        """
        begin, start = float(by.start[0]), nodes[0]
        passed = by.passed(start, begin, begin + 2 * by.period, constants)
        if isinstance(by, GrazingShooting) and passed:
            # Its own window is no room to judge by: a narrower one would follow, and so on.
            start, passed = passed[0][0].state, passed[1:]
        met = find_grazing(by.switched, start, passed, constants, kind)
        return None if met is None else cls(by.model, by.free, by.period, met)

    def again(self, nodes: Array, constants: Constants) -> Self | None:
        """Return the same for the grazing as it is found again, None if it is not."""
        return type(self).at(self, nodes, constants, self.met.kind)

    def passed(self, start: Array, begin: float, end: float, constants: Constants) -> Passed:
        """Carry a state from the node to another phase; nothing where it cannot continue.

        Shapes: start (n,).
        """
        if not (np.isfinite(start).all() and np.isfinite(constants.values).all()):
            return []
        flow, mode = self.switched, self.met.mode
        until = min(end, self._beyond)
        states, span = start[None], (np.array([begin]), np.array([until]))
        ends = flow.of(mode).advance(states, *span, constants)
        state = flow.held(mode, ends[0], until, constants)
        window = SmoothPhase(mode, begin, until, state, flow.no_energies(), None), mode
        if end <= self._beyond:
            return [window]
        found = self.beyond(flow.system(start, constants), mode, state, end)
        return [window, *found] if found else []

    def condition(self, nodes: Array, constants: Constants) -> tuple[float, Array, Array]:
        """Return the minimum of the event's function, over its scale, with its derivatives."""
        flow, met = self.switched.of(self.met.mode), self.met
        phase = self.phase_of_event(nodes, constants)
        if phase is None:
            return np.nan, np.full(len(self.scales), np.nan), np.full(len(self.units), np.nan)
        along, end = constants.rates[:, self.indices], np.array([phase])
        states, matrices, vectors = flow.linearize(nodes, self.start, end, constants, along)
        function = _EventFunction(self.switched, met.mode, met.event, constants)
        value = float(function.values(states, end)[0])
        by_state, _, pulls = function.slopes(states[0], phase, along)
        by_nodes = by_state @ matrices[0] * self.scales
        by_free = (by_state @ vectors[0] + pulls) * self.units
        return value / met.size - met.level, by_nodes / met.size, by_free / met.size

    def phase_of_event(self, nodes: Array, constants: Constants) -> float | None:
        """Return the phase in the window at which the event's function is smallest."""
        flow, begin = self.switched.of(self.met.mode), float(self.start[0])
        phases = np.linspace(begin, self._beyond, PLACES // 4 + 1)
        states = flow.along(nodes, phases[None], constants)[0]
        rates = self._event_rates(states, phases, constants)
        crossed = np.flatnonzero((rates[:-1] < 0) & (rates[1:] >= 0))
        if not len(crossed):
            return None
        i = int(crossed[np.abs(phases[crossed] - self.met.phase).argmin()])
        (last, phase), (before, rate) = phases[i : i + 2].tolist(), rates[i : i + 2].tolist()
        low, high = last, phase
        for _ in range(8):  # by secants: the rate is as good as straight
            following = phase - rate * (phase - last) / (rate - before)
            last, before, phase = phase, rate, min(max(following, low), high)
            if abs(phase - last) < EXACT:
                break
            ends = flow.advance(nodes, self.start, np.array([phase]), constants)
            rate = float(self._event_rates(ends, np.array([phase]), constants)[0])
        return phase

    def _event_rates(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Return how fast the event's function grows a phase. Shapes: states (p, n)."""
        met, none = self.met, np.empty((len(constants.values), 0))
        function = _EventFunction(self.switched, met.mode, met.event, constants)
        rates, found = self.switched.of(met.mode).rates(states, phases, constants), list[float]()
        for state, phase, rate in zip(states, phases.tolist(), rates, strict=True):
            by_state, by_phase, _ = function.slopes(state, phase, none)
            found.append(float(by_state @ rate) + by_phase)
        return np.array(found)
