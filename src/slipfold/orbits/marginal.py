"""Shooting through stick and slip past a change of contacts that is only just met, or not met."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Self

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.contact_state import Undecided
from slipfold.flow.equations import Constants
from slipfold.flow.hybrid_flow import HybridFlow, SmoothPhase
from slipfold.flow.hybrid_trajectory import Broken, smooth_phases
from slipfold.flow.linearized_trajectory import EventMargin
from slipfold.flow.modes import (
    GRAZED,
    Ending,
    Mode,
    Status,
    SwitchingEvent,
    UndeterminedMode,
    reported_mode,
)
from slipfold.models.model import Model
from slipfold.orbits.switched_shooting import Passed, Span, SwitchedShooting, joined


class WINDOW:
    """The search for changes of contacts that an orbit only just meets."""

    off_center: float = 0.25  # fraction of the reach that an event may be off the middle
    short: float = 0.02  # maximum phases of a smooth phase that has just begun to exist
    samples: int = 64  # a period, on a smooth phase, where events are examined first
    longest: float = 0.05  # phases on either side of an event within which an orbit passes it
    clear: float = 0.5  # fraction of the way to the next change, or turn of the function, left free
    level: float = 1e-4  # fraction of its size that slip in the plane keeps at a grazing
    exact: float = 1e-9  # step of secants that ends them: the error is of the next one
    alike: float = 1.01  # ratio of margins of what may be the same event a period later
    instant: float = 1e-7  # phases of stick that count as none, as of a symmetric orbit
    # The same of what begins at a grazing of a symmetric orbit: the root of residuals, of 1e-10
    grazing: float = 1e-4


@dataclass(frozen=True, eq=False)
class MarginalEvent:
    """A change of contacts that an orbit only just meets, or only just does not meet.

    At a ``"GRAZE"`` or ``"LIFT"`` the margin has its minimum, and contacts continue as before. A
    contact along a line that stops (``"STICK"``, ``"MEET"``) has a margin in what friction can
    hold. Beyond a STICK it slips back, beyond a MEET it sticks.
    """

    kind: str
    before: Mode
    after: Mode
    held: Mode  # in which the margin is that of an event
    event: SwitchingEvent
    stops: SwitchingEvent | None  # where slip before the phase reaches zero; None at a grazing
    phase: float
    reach: float  # phases on either side that nothing else happens in
    size: float  # of the margin
    # The minimum of the margin over its size: slip in the plane has no direction at none at all
    level: float = 0.0
    # Whether the orbit meets it several times, as one that is its own symmetric image does
    several: bool = False


Near = tuple[float, MarginalEvent]


def _minima(
    margin: EventMargin, start: Array, begin: float, end: float, kind: str
) -> Iterator[Near]:
    """Yield the minima of a margin on the way from a state, each with how near it is to zero."""
    phases = np.linspace(begin, end, WINDOW.samples * math.ceil(end - begin) + 1)
    states = margin.flow.of(margin.mode).along(start[None], phases[None], margin.constants)[0]
    values = margin.values(states, phases)
    size = float(np.abs(values).max())
    if not (np.isfinite(values).all() and size > 0):
        return
    steps, modes = np.diff(values), (margin.mode, margin.mode, margin.mode)
    for i in np.flatnonzero((steps[:-1] <= 0) & (steps[1:] > 0)) + 1:
        left = i - int(np.argmax(np.append(steps[:i][::-1] > 0, True)))
        right = i + int(np.argmax(np.append(steps[i:] < 0, True)))
        reach = WINDOW.clear * min(
            phases[i] - phases[left], phases[right] - phases[i], 2 * WINDOW.longest
        )
        level = WINDOW.level if margin.event.ending is Ending.SLOWS else 0.0
        # The lowest point of a parabola: a sample may lie farther from it than the window reaches
        lopsided = (steps[i - 1] + steps[i]) / (steps[i] - steps[i - 1])
        lowest = phases[i] - 0.5 * lopsided * (phases[1] - phases[0])
        at = float(lowest), float(reach), size, level
        yield abs(float(values[i])) / size, MarginalEvent(kind, *modes, margin.event, None, *at)


def _grazings(
    flow: HybridFlow, start: Array, passed: Passed, constants: Constants, kind: str
) -> Iterator[Near]:
    """Yield where a trajectory comes near to events without meeting them, or for an instant.

    Shapes: start (n,).
    """
    state = start
    for part, _ in passed:
        mode = reported_mode(part.mode)
        if not part.released and part.end > part.begin:
            for event in flow.mode(mode).events:
                if event.ending in GRAZED[kind]:
                    margin = EventMargin(flow, mode, event, constants)
                    yield from _minima(margin, state, part.begin, part.end, kind)
        state = part.state
    # What was met for a short time, after which contacts continue as before.
    for place, ((before, _), (part, after)) in enumerate(pairwise(passed), start=1):
        mode, met = reported_mode(before.mode), before.event
        returns = met is not None and reported_mode(after) == mode != reported_mode(part.mode)
        if not returns or part.end - part.begin > WINDOW.short or not 1 < place < len(passed) - 1:
            continue
        assert met is not None
        if met.ending in GRAZED[kind] and not met.scaled:  # of slow slip only its end is known
            follows, begin = passed[place + 1][0], passed[place - 2][0].state
            # As if nothing had been met, it turns back a little beyond.
            until = part.end + WINDOW.clear * (follows.end - follows.begin)
            margin = EventMargin(flow, mode, met, constants)
            yield from _minima(margin, begin, before.begin, until, kind)


def near_stops(
    flow: HybridFlow, passed: Passed, constants: Constants, kind: str | None
) -> Iterator[Near]:
    """Yield stops after which contacts slip back, or stick, with how near friction is to its limit.

    What lasts a short time only before that is passed over; nothing is where `kind` is None.
    """
    for place in range(1, len(passed) - 2):
        part, after = passed[place]
        stops = part.event
        if stops is None or stops.ending is not Ending.STOPS or stops.scaled:
            continue
        contact, (follows, later) = stops.which, passed[place + 1]
        back = Status(-int(part.mode[contact]))
        sticks = kind == "MEET" if kind else after[contact] != back
        expected, end = Status.STICK if sticks else back, follows.end
        if after[contact] is not expected and end - follows.begin <= WINDOW.short:
            after, end = later, passed[place + 2][0].end
        if after[contact] is not expected:
            continue
        held = (*after[:contact], Status.STICK, *after[contact + 1 :])
        left = {
            event.towards: (event, float(EventMargin(flow, held, event, constants).values(*at)[0]))
            for at in [(part.state[None], np.array([part.end]))]
            for event in flow.mode(held).events
            if event.ending is Ending.YIELDS and event.which == contact
        }
        size = sum(value for _, value in left.values()) / 2
        event, value = left[back]
        reach = WINDOW.clear * min(part.end - part.begin, end - part.end, 2 * WINDOW.longest)
        modes = reported_mode(part.mode), reported_mode(after), reported_mode(held)
        what = "MEET" if sticks else "STICK"
        yield (abs(value) / size, MarginalEvent(what, *modes, event, stops, part.end, reach, size))


class MarginalShooting(SwitchedShooting):
    """Orbits that pass an event in a window alike on either side of it.

    So they depend smoothly on everything there, and so does the margin that is zero where the event
    is only just met. At a grazing the event is taken not to happen. A contact that stops is taken
    to be held, or not to be held: where it is for a moment, slip begins in the wrong direction, of
    second order in time; where it is not for a moment, it slips back, of third order.

    `met` is the event. The node lies at the beginning of the window, where the orbit does the same
    in the next period.
    """

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int,
        met: MarginalEvent,
        lead: float = 0.5,
    ) -> None:
        self.met = met
        super().__init__(model, free, period, 1, met.phase - lead * met.reach)
        self._beyond = met.phase + 0.5 * met.reach

    @classmethod
    def at(cls, by: SwitchedShooting, nodes: Array, constants: Constants, kind: str) -> Self | None:
        """Return what passes the event of an orbit that it meets least clearly, None if none.

        Shapes: nodes (1, n).
        """
        begin, start = float(by.start[0]), nodes[0]
        passed = by.passed(start, begin, begin + 2 * by.period, constants)
        if kind not in GRAZED:
            found = near_stops(by.switched, passed, constants, kind)
        else:
            if isinstance(by, MarginalShooting) and passed:
                # Its own window is no room to judge by: a narrower one would follow, and so on.
                start, passed = passed[0][0].state, passed[1:]
            found = _grazings(by.switched, start, passed, constants, kind)
        known = list(found)
        nearest = WINDOW.alike * min((near for near, _ in known), default=0.0)
        # The same event of either period: beside the end of what is known there is less room.
        events = [met for near, met in known if near <= nearest]
        best = max(events, key=lambda met: met.reach, default=None)
        if best is None:
            return None
        apart = [(met.phase - best.phase) / by.period for met in events]
        several = any(abs(away - round(away)) * by.period > WINDOW.short for away in apart)
        return cls(by.model, by.free, by.period, replace(best, several=several))

    @classmethod
    def stops_of(
        cls, by: SwitchedShooting, nodes: Array, constants: Constants, kind: str | None = None
    ) -> list[tuple[float, MarginalShooting]]:
        """Return what passes each stop, with how near friction is to its limit, nearest first.

        Of an orbit whose static friction is more than kinetic either kind may be all that exists:
        without one it is passed as it is. Shapes: nodes (1, n).
        """
        begin, period = float(by.start[0]), by.period
        passed = by.passed(nodes[0], begin, begin + 2 * period, constants)
        # What an orbit passes in its own window it may pass otherwise a period later.
        found = list[tuple[float, MarginalShooting]]()
        if isinstance(by, MarginalShooting) and kind is not None:
            found.append((0.0, by))
        stops = near_stops(by.switched, passed, constants, kind)
        for near, met in sorted(stops, key=lambda item: item[0]):
            gaps = [abs((met.phase - other.met.phase) / period) for _, other in found]
            if all(abs(gap - round(gap)) * period > WINDOW.short for gap in gaps):
                found.append((near, cls(by.model, by.free, period, met)))
        return found

    def condition(self, nodes: Array, constants: Constants) -> tuple[float, Array, Array]:
        """Return the margin at the event, over its size and beyond its level, with its derivatives.

        The derivatives are by scaled states and scaled free parameters. Shapes: nodes (1, n);
        returns (), (n,), (k,).
        """
        met, n = self.met, len(self.scales)
        flow, along = self.switched.of(met.before), constants.rates[:, self.indices]
        phase = self.phase_of_event(nodes, constants)
        if phase is None:
            return np.nan, np.full(n, np.nan), np.full(len(self.units), np.nan)
        end = np.array([phase])
        states, matrices, vectors = flow.linearize(nodes, self.start, end, constants, along)
        varied = np.hstack([matrices[0], vectors[0]])
        margin = self._margin(constants)
        by_state, by_phase, by_parameters = margin.slopes(states[0], phase, along)
        slope = by_state @ varied
        slope[n:] += by_parameters
        if met.stops is not None:  # at a minimum the margin does not change with the phase
            rates = flow.rates(states, end, constants)[0]
            place = self.switched.quantities.places[met.stops.which].start
            slips = self.switched.slips.at(states[0], phase, constants, along)
            slip_by_state, slip_by_phase, slip_by_parameters = (item[place] for item in slips)
            later = slip_by_state @ varied
            later[n:] += slip_by_parameters
            later /= -(slip_by_state @ rates + slip_by_phase)
            slope += (by_state @ rates + by_phase) * later
        value = float(margin.values(states, end)[0])
        by_nodes, by_free = slope[:n] * self.scales, slope[n:] * self.units
        return value / met.size - met.level, by_nodes / met.size, by_free / met.size

    def condition_of(
        self, by: SwitchedShooting, nodes: Array, constants: Constants
    ) -> tuple[float, Array, Array]:
        """Return the same of an orbit given at the node of another. Shapes: nodes (1, n)."""
        if by is self:
            return self.condition(nodes, constants)
        _, states, matrices, vectors = by.propagate_to(nodes, constants, self.start)
        value, by_state, by_free = self.condition(states, constants)
        moved = vectors[0] * (self.units / self.scales[:, None])
        return value, by_state @ (matrices[0] * self.ratios), by_free + by_state @ moved

    def better(
        self, nodes: Array, constants: Constants, blocks: Array | None = None
    ) -> Self | None:
        """Return one in whose window the event lies in the middle, None if it does here."""
        phase = self.phase_of_event(nodes, constants)
        if phase is None or abs(phase - self.met.phase) < WINDOW.off_center * self.met.reach:
            return None
        again = type(self).at(self, nodes, constants, self.met.kind)
        met = replace(self.met, phase=phase)
        return again or type(self)(self.model, self.free, self.period, met)

    def with_period(self, period: int) -> Self:
        """Return the same for orbits of another period."""
        return type(self)(self.model, self.free, period, self.met)

    def with_other_errors(self, nodes: Array, constants: Constants) -> Self:
        """Return the same with an earlier beginning of the window: all steps then are others."""
        return type(self)(self.model, self.free, self.period, self.met, lead=0.8)

    def spans(
        self, nodes: Array, constants: Constants, group: Sequence[int] | None = None
    ) -> list[Span]:
        """Leave out what is as good as none: at stops, or at the grazing of the other half."""
        found, half, grazes = super().spans(nodes, constants, group), self.period / 2, None
        if self.met.stops is None:
            grazes = self.phase_of_event(nodes, constants) if self.met.several else None
            if grazes is None:
                return found

        def lasts(begin: float, end: float, mode: Mode) -> bool:
            if grazes is None:
                return end - begin > WINDOW.instant or Status.STICK not in mode
            away = (begin - grazes) / half
            return max(abs(away - round(away)) * half, end - begin) > WINDOW.grazing

        return joined((span for span in found if lasts(*span)), self.period)

    def passed(self, start: Array, begin: float, end: float, constants: Constants) -> Passed:
        """Integrate a state from the node to another phase; nothing where it cannot continue.

        Shapes: start (n,).
        """
        if not (np.isfinite(start).all() and np.isfinite(constants.values).all()):
            return []
        flow, met = self.switched, self.met
        none, until = np.zeros(2 * len(met.before)), min(end, self._beyond)
        window, mode, state = list[tuple[SmoothPhase, Mode]](), met.before, start
        if met.stops is not None:
            phase = self.phase_of_event(start[None], constants, begin)
            if phase is None:
                return []
            if phase < end:
                state = flow.held(
                    met.held, self._in(mode, state, begin, phase, constants), phase, constants
                )
                window = [(SmoothPhase(mode, begin, phase, state, none, met.stops), met.after)]
                begin, mode = phase, met.after
        state = flow.held(mode, self._in(mode, state, begin, until, constants), until, constants)
        window.append((SmoothPhase(mode, begin, until, state, none, None), mode))
        if end <= self._beyond:
            return window
        if met.kind == "STICK":
            assert met.stops is not None
            slip = self._slips(met.stops.which, state[None], np.array([until]), constants)[0]
            if not slip * float(met.after[met.stops.which]) > 0:
                return []
        system = flow.system(start, constants)
        try:
            found = list(smooth_phases(system, mode, state, end, begin=self._beyond))
        except (Broken, Undecided, UndeterminedMode):
            return []
        return [*window, *found] if found[-1][0].end <= end else []

    def phase_of_event(
        self, nodes: Array, constants: Constants, begin: float | None = None
    ) -> float | None:
        """Return the phase in the window at which the margin is smallest, or slip is zero.

        None if there is none. Shapes: nodes (1, n).
        """
        flow, start = self.switched.of(self.met.before), self.start if begin is None else [begin]
        phases = np.linspace(start[0], self._beyond, WINDOW.samples // 4 + 1)
        states = flow.along(nodes, phases[None], constants)[0]
        values = self._rising(states, phases, constants)
        crossed = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
        if not len(crossed):
            return None
        i = int(crossed[np.abs(phases[crossed] - self.met.phase).argmin()])
        (last, phase), (before, value) = phases[i : i + 2].tolist(), values[i : i + 2].tolist()
        low, high = last, phase
        for _ in range(8):  # by secants: the function is as good as straight
            following = phase - value * (phase - last) / (value - before)
            last, before, phase = phase, value, min(max(following, low), high)
            if abs(phase - last) < WINDOW.exact:
                break
            at = np.array([phase])
            ends = flow.advance(nodes, np.array(start, dtype=float), at, constants)
            value = float(self._rising(ends, at, constants)[0])
        return phase

    def _rising(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Return what crosses zero upwards at the event: slip, or the margin's rate a phase.

        Shapes: states (p, n).
        """
        met = self.met
        if met.stops is not None:
            which = met.stops.which
            return -int(met.before[which]) * self._slips(which, states, phases, constants)
        margin, none = self._margin(constants), np.empty((len(constants.values), 0))
        rates, found = self.switched.of(met.before).rates(states, phases, constants), list[float]()
        for state, phase, rate in zip(states, phases.tolist(), rates, strict=True):
            by_state, by_phase, _ = margin.slopes(state, phase, none)
            found.append(float(by_state @ rate) + by_phase)
        return np.array(found)

    def _margin(self, constants: Constants) -> EventMargin:
        return EventMargin(self.switched, self.met.held, self.met.event, constants)

    def _slips(self, contact: int, states: Array, phases: Array, constants: Constants) -> Array:
        place = self.switched.quantities.places[contact].start
        return np.asarray(self.switched.slips.values(states, phases, constants)[:, place])

    def _in(
        self, mode: Mode, state: Array, begin: float, end: float, constants: Constants
    ) -> Array:
        """Integrate a state in one mode, whatever happens. Shapes: state (n,); returns (n,)."""
        flow, span = self.switched.of(mode), (np.array([begin]), np.array([end]))
        return np.asarray(flow.advance(state[None], *span, constants)[0])
