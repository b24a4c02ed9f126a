r"""Derivatives of the end of a hybrid trajectory by its start and by parameters.

In each mode they follow from the variations of the flow. The time of an event
:math:`h(x, t, p) = 0` varies as well. With rates :math:`f^-, f^+` before and after it, this is the
saltation matrix (di Bernardo et al., Piecewise-smooth Dynamical Systems),

.. math:: \delta t = -\frac{h_x \delta x + h_p \delta p}{h_x f^- + h_t}, \qquad
          \delta x^+ = \delta x^- + (f^- - f^+)\, \delta t .

A contact that sticks afterwards has no slip in any variation: that direction vanishes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.batches import LANES
from slipfold.flow.contact_state import Instant, changed
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.flow.hybrid_flow import HybridFlow, HybridSystem, SmoothPhase
from slipfold.flow.modes import CONTACT, Ending, Mode, Status, SwitchingEvent, reported_mode
from slipfold.flow.polynomials import SlowPolynomials
from slipfold.flow.release import Release
from slipfold.newton import zero_between

PARTS = (LANES, 8 * LANES)
"""Numbers of parts of a smooth phase with too many steps: stiff slip lasts for whole periods."""

UNCHANGED = (Ending.SLOWS, Ending.QUICKENS)
"""Events that only change the variables of the integration."""


@dataclass(frozen=True, eq=False)
class LinearizedTrajectory:
    """Derivatives of a trajectory's end, by its beginning and along changes of the coefficients."""

    matrix: Array  # shape (n, n)
    vectors: Array  # shape (n, k)
    # Those of the beginning of each smooth phase, (n, n + k), and of its time, (n + k,); of the end
    begins: list[tuple[Array, Array]]


def linearized_trajectory(
    system: HybridSystem,
    start: Array,
    passed: Sequence[tuple[SmoothPhase, Mode]],
    directions: Array,
) -> LinearizedTrajectory:
    """Linearize a trajectory of some smooth phases, each with the mode that follows.

    Shapes: start (n,); directions (n_c, k).
    """
    variations, n = _Variations(system, directions), len(start)
    first = passed[0][0]
    start = system.held(_equations_in(first), start, first.begin)
    beyond = [variations.beyond(part, after) for part, after in passed]
    starts = np.array([start, *_starts(passed, beyond)[:-1]])
    ends, matrices, vectors = variations.propagated([part for part, _ in passed], starts)
    varied = np.eye(n, n + directions.shape[1])
    varied = variations.held(_equations_in(first), start, first.begin, varied)
    begins, delay = list[tuple[Array, Array]](), np.zeros(varied.shape[1])
    for index, (part, after) in enumerate(passed):
        begins.append((varied, delay))
        delay = np.zeros(varied.shape[1])
        varied = matrices[index] @ varied
        varied[:, n:] += vectors[index]
        if part.released or part.event is None:
            continue
        if part.event.ending not in UNCHANGED:
            varied, delay = variations.changed(part, after, ends[index], beyond[index], varied)
    begins.append((varied, delay))
    return LinearizedTrajectory(varied[:, :n], varied[:, n:], begins)


def _equations_in(part: SmoothPhase) -> Mode:
    """Return the mode whose equations hold in a smooth phase."""
    return reported_mode(part.mode)


def _starts(passed: Sequence[tuple[SmoothPhase, Mode]], beyond: Sequence[Array]) -> list[Array]:
    """Return the start of the next smooth phase after each one."""
    result = list[Array]()
    for index, (part, _) in enumerate(passed):
        # After a release at once there is no onset before.
        at_once = bool(result) and part.released and part.onset is None
        follows = index + 1 < len(passed) and passed[index + 1][0].onset is not None
        result.append(result[-1] if at_once else part.state if follows else beyond[index])
    return result


class _Variations:
    """Propagates variations of a trajectory, shape (n, n + k), through smooth phases and events."""

    def __init__(self, system: HybridSystem, directions: Array) -> None:
        self._system, self._directions = system, directions
        self._flow, self._constants = system.flow, system.constants

    def beyond(self, part: SmoothPhase, after: Mode) -> Array:
        """Return the state after a smooth phase, with small slip in released contacts."""
        state = part.state
        if part.event is None or part.released:
            return state
        for contact, status in enumerate(after):
            stop = part.ended_by(Ending.STOPS)
            rests = part.mode[contact] is Status.STICK or (stop and stop.which == contact)
            if status is Status.SLOW and rests:
                along = Release(self._system, after, contact).direction(state, part.end)
                slip = CONTACT.linearized / self._system.weights[contact] * along
                return self._system.slipping(after, state, slip, part.end)
        return state

    def propagated(self, parts: Sequence[SmoothPhase], starts: Array) -> tuple[Array, Array, Array]:
        """Return the ends of smooth phases with their derivatives, those of one mode in one batch.

        Shapes: starts (m, n); returns (m, n), (m, n, n), (m, n, k).
        """
        begin, end = (np.array([getattr(part, at) for part in parts]) for at in ("begin", "end"))
        for index, part in enumerate(parts):
            stop = part.ended_by(Ending.STOPS)
            if stop and part.mode[stop.which] is Status.SLOW:  # it comes to rest in the plane
                end[index] -= CONTACT.linearized * (part.end - part.begin)
        n, k = starts.shape[1], self._directions.shape[1]
        ends, matrices = starts.copy(), np.tile(np.eye(n), (len(parts), 1, 1))
        vectors = np.zeros((len(parts), n, k))
        modes = [_equations_in(part) for part in parts]
        started = np.zeros(len(parts), dtype=bool)
        for one, part in enumerate(parts):
            if part.onset is not None:
                started[one], ends[one] = True, part.state
                known = part.onset.linearized(part.end, self._directions)
                matrices[one], vectors[one] = known
        for mode in dict.fromkeys(modes):
            in_mode = np.array([item == mode for item in modes]) & (end > begin)
            rows = np.flatnonzero(in_mode & ~started)
            if len(rows):
                given = starts[rows], begin[rows], end[rows], self._constants, self._directions
                ends[rows], matrices[rows], vectors[rows] = self._flow.of(mode).linearize(*given)
        # Slip in the plane takes many steps where its direction turns as it vanishes: there are no
        # derivatives there
        lines = all(place.stop - place.start == 1 for place in self._system.places)
        lost = ~np.isfinite(matrices).all(axis=(1, 2)) & lines
        for row in np.flatnonzero(lost):
            flow, span = self._flow.of(modes[row]), (begin[row], end[row])
            ends[row], matrices[row], vectors[row] = self._in_parts(flow, starts[row], *span)
        return ends, matrices, vectors

    def _in_parts(
        self, flow: Flow, start: Array, begin: float, end: float
    ) -> tuple[Array, Array, Array]:
        """Return the same for a smooth phase that takes more steps than a batch is given.

        Shapes: start (n,); returns (n,), (n, n), (n, k).
        """
        n, k = len(start), self._directions.shape[1]
        for count in PARTS:
            phases = np.linspace(begin, end, count + 1)
            states = flow.trajectory(start, self._constants, phases)[:-1]
            ends, matrices, vectors = flow.linearize(
                states, phases[:-1], phases[1:], self._constants, self._directions
            )
            if np.isfinite(matrices).all():
                matrix, vector = np.eye(n), np.zeros((n, k))
                for one, along in zip(matrices, vectors, strict=True):
                    matrix, vector = one @ matrix, one @ vector + along
                return ends[-1], matrix, vector
        return np.full(n, np.nan), np.full((n, n), np.nan), np.full((n, k), np.nan)

    def changed(
        self, part: SmoothPhase, after: Mode, end: Array, beyond: Array, varied: Array
    ) -> tuple[Array, Array]:
        """Return variations after an event, and of its time."""
        mode, event = reported_mode(part.mode), part.event
        assert event is not None
        # Contacts alike change at once, each at a time of its own: one after the other
        events, delays = [event, *self._others(part, after, event.which)], list[Array]()
        sides = end, beyond
        for one in events:
            following = changed(mode, {one.which: after[one.which]})
            following = after if one is events[-1] else following
            varied, delay = self._past(one, mode, following, part.end, sides, varied)
            mode, sides = following, (beyond, beyond)
            delays.append(delay)
        return self.held(after, part.state, part.end, varied), delays[0]

    def _others(self, part: SmoothPhase, after: Mode, which: int) -> list[SwitchingEvent]:
        """Return the events of contacts along lines that happen at once with that of another."""
        mode, places, found = reported_mode(part.mode), self._system.places, list[SwitchingEvent]()
        changed = [
            contact
            for contact, components in enumerate(places)
            if contact != which
            and mode[contact] is not after[contact]
            and components.stop - components.start == 1
        ]
        if not changed:
            return found
        now = self._system.at(part.state, part.end)
        friction, rates = Instant(now, places, tuple(range(len(mode))), mode).forces(mode)
        for contact in changed:
            at, limit = places[contact].start, now.holding[contact] * (1 - CONTACT.slack)
            # The other's change may release one that has friction left, or stop one that starts
            if mode[contact] is not Status.STICK and float(mode[contact]) * rates[at] < 0:
                found.append(SwitchingEvent(Ending.STOPS, contact, None))
            elif mode[contact] is Status.STICK and abs(friction[at]) >= limit:
                towards = after[contact]
                found.append(SwitchingEvent(Ending.YIELDS, contact, None, towards=towards))
        return found

    def _past(
        self,
        event: SwitchingEvent,
        mode: Mode,
        after: Mode,
        phase: float,
        sides: tuple[Array, Array],
        varied: Array,
    ) -> tuple[Array, Array]:
        """Return variations after a change of mode, and of its time, from states on its sides."""
        margin, at = EventMargin(self._flow, mode, event, self._constants), np.array([phase])
        states, explicit, by_parameters = margin.slopes(sides[0], phase, self._directions)
        rates, new_rates = (
            self._flow.of(each).rates(state[None], at, self._constants)[0]
            for each, state in zip((mode, after), sides, strict=True)
        )
        met = states @ varied
        met[len(states) :] += by_parameters
        delay = -met / (states @ rates + explicit)
        return varied + np.outer(rates - new_rates, delay), delay

    def held(self, mode: Mode, state: Array, phase: float, varied: Array) -> Array:
        """Return variations without slip in the contacts that stick in a mode."""
        compiled = self._flow.mode(reported_mode(mode))
        held = compiled.held_at(self._constants)
        if not held:
            return varied
        known = compiled.held_slopes.at(state, phase, self._constants, self._directions)
        states, _, by_parameters = known
        result = varied.copy()
        result[held] = states @ varied
        result[held, len(state) :] += by_parameters
        return result


def grazing_distances(
    system: HybridSystem, start: Array, passed: Sequence[tuple[SmoothPhase, Mode]]
) -> list[float]:
    """Return how far an orbit in the plane is from grazing. Shapes: start (n,).

    These are the minimum speed of each phase of slow slip, over its scale, and the square of the
    duration of each stop with the slip after it. If static friction exceeds kinetic friction, a
    stop has a duration as soon as slip reaches zero. Then the duration is replaced by the unused
    fraction of kinetic friction.
    """
    result = list[float]()
    state, stopped, released = start, dict[int, float](), False
    for part, after in passed:
        slow = part.mode.index(Status.SLOW) if Status.SLOW in part.mode else None
        if slow is not None and not (part.released or released or part.ended_by(Ending.STOPS)):
            again = system.run(part.mode, state, part.begin, part.end, dense=True).polynomials
            assert isinstance(again, SlowPolynomials)
            result += [speed * system.weights[slow] for speed in _least_speeds(again, len(start))]
        for contact, components in enumerate(system.places):
            if components.stop - components.start < 2:
                continue
            if part.mode[contact] is not Status.STICK and after[contact] is Status.STICK:
                stopped[contact] = part.end
                result += _unused(system, part, after, contact)
            elif after[contact] is not Status.STICK and contact in stopped:
                result.append((part.end - stopped.pop(contact)) ** 2)
        state, released = part.state, part.released
    return result


def _unused(system: HybridSystem, part: SmoothPhase, after: Mode, contact: int) -> list[float]:
    """Return the square of the fraction of kinetic friction that a stop in the plane leaves unused.

    Nothing where static friction is not more.
    """
    now = system.at(part.state, part.end)
    limit = now.starting[contact]
    if now.holding[contact] <= limit * (1 + CONTACT.slack):
        return []
    friction, _ = Instant(now, system.places, (), after).forces(after)
    return [(1 - math.hypot(*friction[system.places[contact]]) / limit) ** 2]


def _least_speeds(slow: SlowPolynomials, n: int) -> list[float]:
    """Return the minima of a speed inside of a smooth phase, in m/s."""
    inner, result = slow.inner, list[float]()
    for begin, end, powers in zip(inner.times, inner.times[1:], inner.tcs[:, n], strict=False):
        logarithm, length = np.polynomial.Polynomial(powers), float(end - begin)
        slope = logarithm.deriv()
        if slope(0.0) < 0 <= slope(length):
            lowest = zero_between(slope, 0.0, length, np.finfo(float).eps * length)
            result.append(float(np.exp(CONTACT.unit * logarithm(lowest))))
    return result


@dataclass(frozen=True, eq=False)
class EventMargin:
    """The function of an event, positive before it; of slip in the plane its speed."""

    flow: HybridFlow
    mode: Mode
    event: SwitchingEvent
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
        if event.ending in (Ending.SLOWS, Ending.STOPS):
            which = flow.quantities.places[event.which]
            slip = flow.slips.values(state[None], np.array([phase]), self.constants)[0, which]
            ahead = np.array([-1.0 if event.rising else 1.0])
            along = slip / np.linalg.norm(slip) if len(slip) == 2 else ahead
            given = flow.slips.at(state, phase, self.constants, directions)
            parts = [along @ item[which] for item in given]
        else:
            slopes, place = flow.mode(self.mode).slopes_of(event)
            given = slopes.at(state, phase, self.constants, directions)
            parts = [-item[place] if event.rising else item[place] for item in given]
        return parts[0], float(parts[1]), parts[2]


CLOSER, EXACT = 9, 1e-7
"""Phases among which a margin is smallest, ever nearer, and their last extent."""


class Least(NamedTuple):
    """A margin where it is least."""

    value: float
    margin: EventMargin
    part: int  # number of the smooth phase
    start: Array  # state in which that begins, shape (n,)
    phase: float

    def slopes(self, linearized: LinearizedTrajectory, part: SmoothPhase, along: Array) -> Array:
        """Return its derivatives by an orbit's first state and along changes of the coefficients.

        Where an event begins or ends the smooth phase, its time varies too. Shapes: along
        (n_c, k); returns (n + k,).
        """
        n, margin, at = len(self.start), self.margin, np.array([self.phase])
        (varied, late), flow = linearized.begins[self.part], margin.flow.of(margin.mode)
        state, given = self.start, (np.array([part.begin]), at, margin.constants, along)
        if self.phase > part.begin:
            ends, matrices, vectors = flow.linearize(state[None], *given)
            state, varied = ends[0], matrices[0] @ varied
            varied[:, n:] += vectors[0]
            late = np.zeros(len(late))
            if self.phase == part.end and part.event is not None:
                late = linearized.begins[self.part + 1][1]
        by_state, by_phase, by_free = margin.slopes(state, self.phase, along)
        rate = by_state @ flow.rates(state[None], at, margin.constants)[0] + by_phase
        result = by_state @ varied + rate * late
        result[n:] += by_free
        return np.asarray(result)


def least_near(found: Least, phases: Array, at: int) -> Least:
    """Return the least value of a margin near the smallest of some. Shapes: phases (p,)."""
    margin, near = found.margin, phases
    flow, starts = margin.flow.of(margin.mode), np.tile(found.start, (CLOSER, 1))
    while True:
        low, high = near[max(at - 1, 0)], near[min(at + 1, len(near) - 1)]
        near = np.linspace(low, high, CLOSER)
        states = flow.advance(starts, np.full(CLOSER, phases[0]), near, margin.constants)
        values = margin.values(states, near)
        at = int(values.argmin())
        if high - low < EXACT:
            return found._replace(value=float(values[at]), phase=float(near[at]))
