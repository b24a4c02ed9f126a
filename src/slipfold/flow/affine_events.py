"""Events of modes whose rates and event functions are affine, in closed form."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from slipfold.arrays import Array, Complex, Mask
from slipfold.collocation_points import gauss_points
from slipfold.flow.affine_flow import (
    AffineFlow,
    AffineSolutions,
    Harmonics,
    divided,
    harmonics_of,
    is_affine,
)
from slipfold.flow.batches import TOLERANCE
from slipfold.flow.compiled_code import Slopes
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.flow.modes import CONTACT, Ending, SwitchingEvent
from slipfold.flow.polynomials import StepPolynomials


class EVENT:
    """How the first event of a solution in closed form is found."""

    # Fewer are followed from event to event in less time by an integrator, unless they are fast
    many: int = 24
    # Radians of the fastest visible vibration between two samples of events: bounds between them
    # are off by 2e-6 of it
    turn: float = 1.2
    visible: float = 1e-8  # part of an event function below which a vibration causes no event
    samples: int = 32  # of events at a time
    fewest: int = 4  # samples of a smooth phase
    rounding: float = 1e-12  # event functions, over their scales, that may be zero
    shortest: float = 1e-13  # phases: a minimum that is not decided within them is rounding
    exact: float = 1e-15  # phases by which the last step of Newton's method moves an event
    settled: float = 0.5  # ratio of two steps above which it no longer converges,
    fine: float = 1e-11  # if they are as short: rounding is what is left
    iterations: int = 60  # of Newton's method for the time of an event, which bisects if need be


class STEPS:
    """Steps of dense output, and of integrals over solutions."""

    order: int = 20  # of Taylor polynomials
    turn: float = 1.8  # radians of the fastest visible vibration in a step: errors are 5e-15
    visible: float = 1e-14  # size of a vibration, in scaled states, below which it is left out
    samples: int = 16  # steps of one length
    fewest: int = 1  # steps of a smooth phase


ORDERS = np.arange(4)
"""Derivatives of event functions that are computed at samples."""


def _two_point(count: int) -> Array:
    """Return the matrix from c derivatives at both ends to Bernstein coefficients, (2 c + 1, 2 c).

    The polynomial with these derivatives is written in one degree more: its difference from the
    function then changes the coefficient in the middle alone.
    """
    degree = 2 * count - 1
    own = np.zeros((2 * count, 2 * count))
    for i in range(count):
        for j in range(i + 1):
            part = math.comb(i, j) / math.perm(degree, j)
            own[i, j], own[degree - i, count + j] = part, (-1) ** j * part
    raised, before = np.zeros((2 * count + 1, 2 * count)), np.arange(2.0 * count) / (2 * count)
    raised[:-1] += np.diag(1 - before)
    raised[1:] += np.diag(before + 1 / (2 * count))
    return raised @ own


VALUES, SLOPES = _two_point(len(ORDERS)), _two_point(len(ORDERS) - 1)
"""Bernstein coefficients of an event function between two samples, and of its slope."""


def _enclosed(weights: Array, left: Array, right: Array, bend: Array) -> tuple[Array, Array]:
    """Return lower and upper bounds of Bernstein coefficients of functions between two places.

    Each function lies between the least and the greatest of its coefficients. Shapes: left, right
    (c, ...), derivatives times powers of the distance; bend bounds the one of order 2 c.
    """
    count, known = len(left), np.concatenate([left, right])
    low = (weights @ known.reshape(2 * count, -1)).reshape(-1, *left.shape[1:])
    high, off = low.copy(), bend * (math.factorial(count) / math.factorial(2 * count)) ** 2
    low[count] -= off
    high[count] += off
    return low, high


GAUSS = gauss_points(8)
"""Points of a step for integrals of powers, which turn by 3.6: errors are 2e-14."""


def is_large(dimension: int) -> bool:
    """Whether events of so many states are found in less time in closed form."""
    return dimension >= EVENT.many


def pays(flow: Flow, constants: Constants) -> bool:
    """Whether events in closed form take less time than an integrator."""
    if not isinstance(flow, AffineFlow):
        return False
    return is_large(flow.dimension) or flow.takes_many_steps(constants)


Parts = Callable[[Constants, Array], tuple[Array, Harmonics | None]]
"""Derivatives of event functions by states, and what the phase gives, None if that has no few
harmonics; from the coefficients and sizes below which values are none."""


class AffineEvents:
    """The events of a mode whose rates and event functions are affine."""

    def __init__(
        self, flow: AffineFlow, events: Sequence[SwitchingEvent], affine: Parts, contacts: int
    ) -> None:
        self._flow, self._events, self._affine = flow, events, affine
        falls = np.array([-1.0 if event.rising else 1.0 for event in events])
        self._falls = falls
        places = {Ending.STOPS: 0, Ending.LIMIT: 2 * contacts}
        self._weights = [event.which + places.get(event.ending, contacts) for event in events]
        # Computed for these solutions and scales of events, among which a limit may be missing
        none: tuple[AffineSolutions | None, bytes, EventFunctions | None] = None, b"", None
        self._known = none

    @classmethod
    def of(
        cls, flow: Flow, events: Sequence[SwitchingEvent], slopes: Callable[[], Slopes], count: int
    ) -> AffineEvents | None:
        """Return the events, None if they are not affine."""
        if not isinstance(flow, AffineFlow):
            return None
        if any(event.scaled for event in events):
            return None
        if not is_affine([event.expression for event in events], flow.equations):
            return None
        known = slopes()

        def affine(constants: Constants, floor: Array) -> tuple[Array, Harmonics | None]:
            n, nothing = flow.dimension, np.empty((len(constants.values), 0))
            own = harmonics_of(
                lambda at: known.values(np.zeros((len(at), n)), at, constants)[..., None],
                np.ones(1),
                floor,
            )
            return known.at(np.zeros(n), 0.0, constants, nothing)[0], own

        return cls(flow, events, affine, count)

    def follow(
        self, state: Array, begin: float, end: float, constants: Constants, weights: Array
    ) -> AffinePhase | None:
        """Return the solution up to the first event, or to the end if there is none.

        None where no closed form has enough digits. Shapes: state (n,).
        """
        watched = self._watched(state, begin, constants, weights)
        if watched is None:
            return None
        found = watched.first(end) if self._events else None
        which, phase = (None, end) if found is None else found
        event = None if which is None else self._events[which]
        return AffinePhase(event, begin, phase, watched, constants.scales)

    def _watched(
        self, state: Array, begin: float, constants: Constants, weights: Array
    ) -> _Watched | None:
        sizes, solutions = weights[self._weights], self._flow.solutions(constants)
        if solutions is None:
            return None
        known, scaled, functions = self._known
        if known is not solutions or scaled != sizes.tobytes():
            (by_states, own), scales = self._affine(constants, 1 / sizes), self._falls * sizes
            if own is not None:
                seen = (scales[:, None] * by_states) @ solutions.shapes
                own = Harmonics(own.exponents, own.values * scales)
                functions = EventFunctions(solutions, seen, own)
            else:
                functions = None
            self._known = solutions, sizes.tobytes(), functions
        if functions is None:
            return None
        return _Watched(functions, solutions.into @ state, begin)


@dataclass(frozen=True, eq=False)
class AffinePhase:
    """A solution in closed form up to an event, or up to a phase."""

    event: SwitchingEvent | None
    begin: float
    end: float
    watched: _Watched
    scales: Array  # units of the states, shape (n,)

    @property
    def state(self) -> Array:
        """State at the end, shape (n,)."""
        return self._states(np.array([self.end]))[0]

    def _states(self, phases: Array) -> Array:
        watched = self.watched
        return np.asarray((watched.motions(phases) @ watched.solutions.shapes.T).real)

    @cached_property
    def _steps(self) -> tuple[Array, Complex]:
        """Ends of steps, shape (m + 1,), and what is visible of free motions, shape (m, n)."""
        watched, shapes = self.watched, self.watched.solutions.shapes
        sizes = np.abs(shapes / self.scales[:, None]).max(axis=0)
        phases, free = [np.array([self.begin])], [np.empty((0, len(shapes)), dtype=complex)]
        parts = watched.samples(self.end, STEPS, lambda moved: sizes * moved > STEPS.visible)
        for places, known, visible in parts:
            phases.append(places[1:])
            free.append(np.where(visible, known[:-1], 0.0))
        return np.concatenate(phases), np.concatenate(free)

    def polynomials(self) -> StepPolynomials:
        """Return dense output of scaled states."""
        phases, free = self._steps
        solutions, orders = self.watched.solutions, np.arange(STEPS.order + 1)
        exponents = solutions.forcing.exponents
        turned = np.exp(phases[:-1, None] * exponents)
        factorials = np.cumprod(np.maximum(orders, 1.0))
        forced = exponents ** orders[:, None]  # (order + 1, H)
        terms = np.empty((len(free), len(orders), free.shape[1]), dtype=complex)
        terms[:, 0] = free
        for order in range(STEPS.order):
            terms[:, order + 1] = solutions.values * terms[:, order]
            for h, j in solutions.resonant:
                push = solutions.forcing.values[h, j] * forced[order, h]
                terms[:, order + 1, j] += push * turned[:, h]
        terms += (turned[:, None] * forced) @ solutions.answers
        powers = (terms @ (solutions.shapes / self.scales[:, None]).T).real
        return StepPolynomials(phases, (powers / factorials[:, None]).transpose(0, 2, 1))

    def integral(self, rates: Callable[[Array, Array], Array]) -> Array:
        """Return integrals over the phase of functions, shape (q,).

        They map states (p, n) and phases (p,) to values (p, q).
        """
        phases, lengths = self._steps[0], np.diff(self._steps[0])
        if not len(lengths):
            return 0.0 * rates(self._states(phases), phases)[0]
        places = (phases[:-1, None] + lengths[:, None] * GAUSS.points).ravel()
        weights = (lengths[:, None] * GAUSS.weights).ravel()
        return np.asarray(weights @ rates(self._states(places), places))


@dataclass(frozen=True, eq=False)
class EventFunctions:
    """Event functions of all solutions, scaled, positive before their events."""

    solutions: AffineSolutions
    seen: Complex  # of eigenvectors, shape (q, n)
    own: Harmonics  # what depends on the phase alone, shape (H, q)

    def only(self, left: Sequence[int] | Array) -> EventFunctions:
        """Return some of the functions."""
        own = Harmonics(self.own.exponents, self.own.values[:, left])
        return EventFunctions(self.solutions, self.seen[left], own)

    @cached_property
    def parts(self) -> tuple[Complex, Harmonics, Complex]:
        """Derivatives by free motions, (n, c, q), what the phase gives, and its own, (H, c, q)."""
        solutions, seen, own = self.solutions, self.seen.T, self.own
        exponents = np.concatenate([solutions.forcing.exponents, own.exponents])
        phased = Harmonics(exponents, np.concatenate([solutions.answers @ seen, own.values]))
        free, turned = (
            part[:, None, None] ** ORDERS[:, None] for part in (solutions.values, exponents)
        )
        return free * seen[:, None], phased, turned * phased.values[:, None]


@dataclass(frozen=True, eq=False)
class _Watched:
    """Event functions along a solution."""

    functions: EventFunctions
    start: Complex  # in the basis of eigenvectors, shape (n,)
    begin: float

    @property
    def solutions(self) -> AffineSolutions:
        """All solutions, of which this is one."""
        return self.functions.solutions

    def motions(self, phases: Array) -> Complex:
        """Return the solution, shape (p, n)."""
        begin = np.array([self.begin])
        return self.solutions.motions(self.start[None], begin, (phases - self.begin)[None])[0]

    @cached_property
    def free(self) -> Complex:
        """The solution less the answer to the forcing where it begins, shape (n,)."""
        turned = np.exp(self.begin * self.solutions.forcing.exponents)
        return np.asarray(self.start - turned @ self.solutions.answers)

    def samples(
        self, end: float, rule: type[EVENT | STEPS], visible: Callable[[Array], Mask]
    ) -> Iterator[tuple[Array, Complex, Mask]]:
        """Yield phases up to an end, free motions there, and which are visible by their sizes.

        Phases are as close as forcing and visible vibrations need. Some are yielded at a time; the
        first is the last of those before. Shapes: yields (p,), (p, n), (n,).
        """
        phase, free, values = self.begin, self.free, self.solutions.values
        known = self.solutions.forcing.exponents, self.functions.own.exponents
        slowest = max(np.abs(part).max(initial=0.0) for part in known)
        while phase < end:
            seen = visible(np.abs(free))
            fastest = max(np.abs(values[seen]).max(initial=0.0), slowest)
            step = (end - self.begin) / rule.fewest
            step = min(step, rule.turn / fastest) if fastest else step
            count = max(1, int(np.ceil((end - phase) / step * (1 - TOLERANCE))))
            step, taken = (end - phase) / count, min(count, rule.samples)
            growth = np.broadcast_to(np.exp(values * step), (taken, len(free)))
            motions = np.cumprod(np.concatenate([free[None], growth]), axis=0)
            times = step * np.arange(taken + 1.0)
            motions, phases = self._with_resonances(motions, phase, times), phase + times
            phases[-1] = end if taken == count else phases[-1]
            yield phases, motions, seen
            phase, free = float(phases[-1]), motions[-1]

    def _with_resonances(self, free: Complex, begin: float, times: Array) -> Complex:
        """Add answers to resonant forcing since a phase. Shapes: free (p, n); times (p,)."""
        solutions = self.solutions
        for h, j in solutions.resonant:
            value, exponent = solutions.values[j], solutions.forcing.exponents[h]
            push = solutions.forcing.values[h, j] * np.exp(begin * exponent)
            free[:, j] += push * times * divided(value * times, exponent * times)
        return free

    def _derivatives(self, phases: Array, free: Complex, visible: Mask | bool = True) -> Array:
        """Return the functions with derivatives, shape (c, p, q), from free motions.

        Vibrations that are not visible contribute to the values alone.
        """
        solutions, (by_free, phased, rising) = self.solutions, self.functions.parts
        shape = len(phases), *by_free.shape[1:]
        result = np.empty(shape)
        result[:, 0] = (free @ by_free[:, 0]).real + CONTACT.event_distance
        others = by_free[:, 1:].reshape(len(by_free), -1)
        result[:, 1:] = ((free * visible) @ others).real.reshape(shape[0], -1, shape[2])
        known = np.exp(phases[:, None] * phased.exponents)
        result += (known @ rising.reshape(len(rising), math.prod(shape[1:]))).real.reshape(shape)
        for h, j in solutions.resonant:
            value, exponent = solutions.values[j], solutions.forcing.exponents[h]
            push = solutions.forcing.values[h, j] * np.exp(phases * exponent)
            factor: complex = 0.0
            for order in ORDERS[1:].tolist():
                factor = value * factor + exponent ** (order - 1)
                result[:, order] += (factor * push[:, None] * self.functions.seen[:, j]).real
        return result.transpose(1, 0, 2)

    def at(self, phases: Array) -> tuple[Array, Array]:
        """Return the functions and their slopes, both (p, q)."""
        values, slopes, *_ = self._derivatives(phases, self._free_at(phases))
        return values, slopes

    def _free_at(self, phases: Array) -> Complex:
        times = phases - self.begin
        free = self.free * np.exp(times[:, None] * self.solutions.values)
        return self._with_resonances(free, self.begin, times)

    def first(self, end: float) -> tuple[int, float] | None:
        """Return the number and the phase of the first event up to a phase, None if none."""
        seen = np.abs(self.functions.seen)
        least = EVENT.visible * (seen @ np.abs(self.start) + np.finfo(float).tiny)[:, None]
        parts = self.samples(end, EVENT, lambda sizes: np.any(seen * sizes > least, axis=0))
        return next(filter(None, (self._between(*part) for part in parts)), None)

    def _between(self, phases: Array, free: Complex, visible: Mask) -> tuple[int, float] | None:
        """Return the first event between samples. Shapes: phases (p,); free (p, n)."""
        step = phases[1] - phases[0]
        powers = step ** ORDERS[:, None, None]
        ends = self._derivatives(phases, free, visible) * powers
        bend = self._bend(free[0], phases[-1] - phases[0], step, visible, 2 * len(ORDERS))
        positive = _enclosed(VALUES, ends[:, :-1], ends[:, 1:], bend)[0].min(axis=0)
        undecided = (positive <= 0) | (ends[0, 1:] <= 0)
        if phases[0] == self.begin:
            starts = (np.abs(ends[0, 0]) <= EVENT.rounding) & (ends[0, 1] > 0)
            undecided[0] &= ~(starts & (positive[0] > -EVENT.rounding))
        for place in np.flatnonzero(undecided.any(axis=1)).tolist():
            met, (low, high) = None, phases[place : place + 2].tolist()
            left = np.flatnonzero(undecided[place]).tolist()
            while left:
                which, *left = left
                phase = self._only([which])._first_zero(low, high, visible)
                if phase is not None and (met is None or phase < high):
                    met, high = (which, phase), phase
                    if left:  # most fall later
                        falls = self._only(left)._may_fall(low, high, visible)
                        left = [one for one, may in zip(left, falls, strict=True) if may]
            if met:
                return met
        return None

    def _only(self, left: Sequence[int] | Array) -> _Watched:
        """Return some of the functions."""
        return replace(self, functions=self.functions.only(left))

    def _may_fall(self, low: float, high: float, visible: Mask) -> Mask:
        """Return which functions are not known to be positive between two phases, shape (q,)."""
        phases, step = np.array([low, high]), high - low
        free = self._free_at(phases)
        ends = self._derivatives(phases, free, visible) * step ** ORDERS[:, None, None]
        bend = self._bend(free[0], step, step, visible, 2 * len(ORDERS))
        positive = _enclosed(VALUES, ends[:, 0], ends[:, 1], bend)[0].min(axis=0)
        return np.asarray((positive <= 0) | (ends[0, 1] <= 0))

    def _bend(self, free: Complex, span: float, step: float, visible: Mask, order: int) -> Array:
        """Return bounds of a derivative over a span, shape (q,), times a power of the step."""
        solutions, values = self.solutions, self.solutions.values
        sizes, turns = np.abs(free) * visible, np.abs(values) * step
        bends = np.zeros(len(values))
        for h, j in solutions.resonant:
            push = abs(solutions.forcing.values[h, j])
            fastest = max(turns[j], abs(solutions.forcing.exponents[h]) * step)
            sizes[j] += push * span
            bends[j] += order * push * step * fastest ** (order - 1)
        bends += sizes * np.exp(np.maximum(values.real, 0.0) * span) * turns**order
        result: Array = np.abs(self.functions.seen) @ bends
        phased = self.functions.parts[1]
        return result + (np.abs(phased.exponents) * step) ** order @ np.abs(phased.values)

    def _first_zero(self, first: float, last: float, visible: Mask) -> float | None:
        """Return where the only function first falls to zero between two phases, None if nowhere.

        Intervals are halved until the function is positive or monotonic on each.
        """
        intervals, begins = [(first, last)], first == self.begin
        while intervals:
            low, high = intervals.pop()
            phases, step = np.array([low, high]), high - low
            free = self._free_at(phases)
            ends = self._derivatives(phases, free, visible)[..., 0] * step ** ORDERS[:, None]
            at_zero = low == self.begin and abs(ends[0, 0]) <= EVENT.rounding
            if ends[0, 0] <= 0 and not at_zero:
                return self.begin if begins else low  # it has fallen since
            bends = (self._bend(free[0], step, step, visible, order)[0] for order in (8, 7))
            values = _enclosed(VALUES, ends[:, 0], ends[:, 1], next(bends))
            no_more = at_zero or values[1].max() <= EVENT.rounding  # than rounding is a fall
            if ends[0, 1] > 0 and values[0].min() > (-EVENT.rounding if no_more else 0.0):
                continue
            slopes = _enclosed(SLOPES, ends[1:, 0], ends[1:, 1], next(bends))
            if slopes[0].min() > 0 and ends[0, 1] > 0:
                continue
            if slopes[1].max() < 0 or step <= EVENT.shortest:
                if ends[0, 1] > 0:
                    continue
                return self._zero(low, high)
            middle = 0.5 * (low + high)
            intervals += [(middle, high), (low, middle)]
        return None

    def _zero(self, low: float, high: float) -> float:
        """Return the phase in an interval at which the only function falls through zero."""
        phase, before = high, np.inf
        for _ in range(EVENT.iterations):
            value, slope = (float(item[0, 0]) for item in self.at(np.array([phase])))
            low, high = (phase, high) if value > 0 else (low, phase)
            after = phase - value / slope if slope < 0 else np.inf
            after = after if low <= after <= high else 0.5 * (low + high)
            moved, phase = abs(after - phase), after
            if moved <= EVENT.exact or EVENT.settled * before < moved < EVENT.fine:
                break
            before = moved
        return float(phase)
