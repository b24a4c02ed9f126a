"""Events of modes whose rates and event functions are affine, in closed form."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
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


@dataclass(frozen=True)
class EventSearch:
    """How the first event of a solution in closed form is found."""

    many: int = 24  # fewer are followed from event to event in less time by an integrator
    turn: float = 0.6  # radians of the fastest visible vibration between two samples of events
    visible: float = 1e-8  # part of an event function below which a vibration is no reason to look
    samples: int = 32  # of events at a time
    fewest: int = 4  # samples of a smooth phase
    rounding: float = 1e-12  # event functions, over their scales, that may be zero
    near: float = 0.3  # least value of a cubic over its ends' above which no zero is looked for
    halvings: int = 40  # of the first interval where an event function begins at zero
    exact: float = 1e-15  # phases by which the last step of Newton's method moves an event
    settled: float = 0.5  # ratio of two steps above which it no longer converges,
    fine: float = 1e-11  # if they are as short: rounding is what is left
    iterations: int = 60  # of Newton's method for the time of an event, which bisects if need be


SEARCH = EventSearch()


@dataclass(frozen=True)
class DenseSteps:
    """Steps of dense output, and of integrals over solutions."""

    order: int = 20  # of Taylor polynomials
    turn: float = 1.8  # radians of the fastest visible vibration in a step: errors are 5e-15
    visible: float = 1e-14  # size of a vibration, in scaled states, below which it is left out
    samples: int = 16  # steps of one length
    fewest: int = 1  # steps of a smooth phase


STEPS = DenseSteps()

GAUSS = gauss_points(8)
"""Points of a step for integrals of powers, which turn by 3.6: errors are 2e-14."""


class AffineEvents:
    """The events of a mode whose rates and event functions are affine."""

    def __init__(
        self, flow: AffineFlow, events: Sequence[SwitchingEvent], slopes: Slopes, contacts: int
    ) -> None:
        self._flow, self._events, self._slopes = flow, events, slopes
        falls = np.array([-1.0 if event.rising else 1.0 for event in events])
        self._falls = falls
        places = {Ending.STOPS: 0, Ending.LIMIT: 2 * contacts}
        self._weights = [event.which + places.get(event.ending, contacts) for event in events]
        self._known: tuple[Constants | None, Array, Harmonics | None] = None, falls, None

    @classmethod
    def of(
        cls, flow: Flow, events: Sequence[SwitchingEvent], slopes: Callable[[], Slopes], count: int
    ) -> AffineEvents | None:
        """Return the events, None if they are not affine."""
        if not isinstance(flow, AffineFlow) or flow.dimension < SEARCH.many:
            return None
        if any(event.scaled for event in events):
            return None
        if not is_affine([event.expression for event in events], flow.equations):
            return None
        return cls(flow, events, slopes(), count)

    def follow(
        self, state: Array, begin: float, end: float, constants: Constants, weights: Array
    ) -> AffinePhase | None:
        """Return the solution up to the first event, or to the end if there is none.

        None where no closed form has enough digits. Shapes: state (n,).
        """
        solutions = self._flow.solutions(constants)
        watched = None
        if solutions is not None:
            watched = self._watched(solutions, state, begin, constants, weights)
        if watched is None:
            return None
        found = watched.first(end) if self._events else None
        which, phase = (None, end) if found is None else found
        event = None if which is None else self._events[which]
        return AffinePhase(event, begin, phase, watched, constants.scales)

    def _watched(
        self,
        solutions: AffineSolutions,
        state: Array,
        begin: float,
        constants: Constants,
        weights: Array,
    ) -> _Watched | None:
        known, by_states, explicit = self._known
        if known is not constants:
            n, nothing = len(state), np.empty((len(constants.values), 0))
            zero = np.zeros(n)
            by_states = self._slopes.at(zero, 0.0, constants, nothing)[0]
            explicit = harmonics_of(
                lambda at: self._slopes.values(np.zeros((len(at), n)), at, constants)[..., None],
                np.ones(1),
                1 / weights[self._weights],
            )
            self._known = constants, by_states, explicit
        if explicit is None:
            return None
        scales = self._falls * weights[self._weights]
        seen = (scales[:, None] * by_states) @ solutions.shapes
        own = Harmonics(explicit.exponents, explicit.values * scales)
        return _Watched(solutions, solutions.into @ state, begin, seen, own)


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
        here, left = self.begin, watched.free
        while here < self.end:
            visible = sizes * np.abs(left) > STEPS.visible
            step = watched.step(visible, STEPS.turn, (self.end - self.begin) / STEPS.fewest)
            count = max(1, int(np.ceil((self.end - here) / step * (1 - TOLERANCE))))
            step, taken = (self.end - here) / count, min(count, STEPS.samples)
            left, known = watched.advanced(here, left, step, taken)
            phases.append(here + step * np.arange(1.0, taken + 1))
            free.append(np.where(visible, known[:-1], 0.0))
            here = self.end if taken == count else float(phases[-1][-1])
            phases[-1][-1] = here
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
class _Watched:
    """Event functions along a solution, scaled, positive before their events."""

    solutions: AffineSolutions
    start: Complex  # in the basis of eigenvectors, shape (n,)
    begin: float
    seen: Complex  # of eigenvectors, shape (q, n)
    own: Harmonics  # what depends on the phase alone, shape (H, q)

    def motions(self, phases: Array) -> Complex:
        """Return the solution, shape (p, n)."""
        begin = np.array([self.begin])
        return self.solutions.motions(self.start[None], begin, (phases - self.begin)[None])[0]

    @cached_property
    def free(self) -> Complex:
        """The solution less the answer to the forcing where it begins, shape (n,)."""
        turned = np.exp(self.begin * self.solutions.forcing.exponents)
        return np.asarray(self.start - turned @ self.solutions.answers)

    def advanced(
        self, phase: float, free: Complex, step: float, count: int
    ) -> tuple[Complex, Complex]:
        """Return free motions after so many steps, (n,), and at the beginning and after each.

        Shapes: free (n,); returns (n,), (count + 1, n).
        """
        solutions = self.solutions
        growth = np.exp(solutions.values * step)
        known = np.concatenate([free[None], np.broadcast_to(growth, (count, len(free)))])
        known = np.cumprod(known, axis=0)
        known = self._with_resonances(known, phase, step * np.arange(count + 1.0))
        return known[-1], known

    def _with_resonances(self, free: Complex, begin: float, times: Array) -> Complex:
        """Add answers to resonant forcing since a phase. Shapes: free (p, n); times (p,)."""
        solutions = self.solutions
        for h, j in solutions.resonant:
            value, exponent = solutions.values[j], solutions.forcing.exponents[h]
            push = solutions.forcing.values[h, j] * np.exp(begin * exponent)
            free[:, j] += push * times * divided(value * times, exponent * times)
        return free

    @cached_property
    def _parts(self) -> tuple[Complex, tuple[Harmonics, Harmonics]]:
        """Slopes by free motions, shape (n, q), and what the phase gives."""
        solutions, seen = self.solutions, self.seen.T
        forced = Harmonics(solutions.forcing.exponents, solutions.answers @ seen)
        return solutions.values[:, None] * seen, (forced, self.own)

    def _functions(self, phases: Array, free: Complex) -> tuple[Array, Array]:
        """Return the functions and their slopes from free motions, both (p, q)."""
        solutions, seen, (turned, parts) = self.solutions, self.seen.T, self._parts
        values = (free @ seen).real + CONTACT.event_distance
        slopes = (free @ turned).real
        for part in parts:
            known = np.exp(phases[:, None] * part.exponents)
            values += (known @ part.values).real
            slopes += ((known * part.exponents) @ part.values).real
        for h, j in solutions.resonant:
            push = solutions.forcing.values[h, j] * np.exp(phases * solutions.forcing.exponents[h])
            slopes += (push[:, None] * seen[j]).real
        return values, slopes

    def at(self, phases: Array) -> tuple[Array, Array]:
        """Return the functions and their slopes, both (p, q)."""
        times = phases - self.begin
        free = self.free * np.exp(times[:, None] * self.solutions.values)
        return self._functions(phases, self._with_resonances(free, self.begin, times))

    def step(self, visible: Mask, turn: float, longest: float) -> float:
        """Return the distance of samples that shows forcing and visible vibrations."""
        fastest = max(
            np.abs(self.solutions.values[visible]).max(initial=0.0),
            np.abs(self.solutions.forcing.exponents).max(initial=0.0),
            np.abs(self.own.exponents).max(initial=0.0),
        )
        return min(longest, turn / fastest) if fastest else longest

    def first(self, end: float) -> tuple[int, float] | None:
        """Return the number and the phase of the first event up to a phase, None if none."""
        phase, free, longest = self.begin, self.free, (end - self.begin) / SEARCH.fewest
        seen = np.abs(self.seen)
        total = seen @ np.abs(self.start) + np.finfo(float).tiny
        while phase < end:
            visible = np.any(seen * np.abs(free) > SEARCH.visible * total[:, None], axis=0)
            step = self.step(visible, SEARCH.turn, longest)
            count = max(1, int(np.ceil((end - phase) / step * (1 - TOLERANCE))))
            step, taken = (end - phase) / count, min(count, SEARCH.samples)
            free, known = self.advanced(phase, free, step, taken)
            phases: Array = phase + step * np.arange(taken + 1.0)
            phases[-1] = end if taken == count else phases[-1]
            found = self._between(phases, *self._functions(phases, known))
            if found is not None:
                return found
            phase = float(phases[-1])
        return None

    def _between(self, phases: Array, values: Array, slopes: Array) -> tuple[int, float] | None:
        """Return the first event between samples, shape (p,) and (p, q)."""
        before, after, falls, rises = values[:-1], values[1:], slopes[:-1] < 0, slopes[1:] > 0
        crosses = (before > 0) & (after <= 0)
        dips = (before > 0) & (after > 0) & falls & rises
        if phases[0] == self.begin:
            starts = np.abs(before[0]) <= SEARCH.rounding
            dips[0] &= ~starts
            crosses[0] = np.where(starts, after[0] < -SEARCH.rounding, crosses[0])
        for place in np.flatnonzero((crosses | dips).any(axis=1)).tolist():
            met = list[tuple[float, int]]()
            for which in np.flatnonzero(crosses[place] | dips[place]).tolist():
                low, high = float(phases[place]), float(phases[place + 1])
                if dips[place, which]:
                    ends = before[place, which], after[place, which]
                    rates = slopes[place, which], slopes[place + 1, which]
                    low, high = self._lowest(which, low, high, ends, rates)
                elif not before[place, which] > SEARCH.rounding:
                    low, high = self._begun(which, low, high)
                if low <= high:
                    met.append((self._zero(which, low, high), which))
            if met:
                at, which = min(met)
                return which, at
        return None

    def _one(self, which: int, phase: float) -> tuple[float, float]:
        values, slopes = self.at(np.array([phase]))
        return float(values[0, which]), float(slopes[0, which])

    def _begun(self, which: int, low: float, high: float) -> tuple[float, float]:
        """Return an interval with the zero of a function that begins at zero.

        Where it falls at once, that is the beginning itself.
        """
        phases: Array = low + (high - low) * np.exp2(-np.arange(float(SEARCH.halvings)))
        positive = np.flatnonzero(self.at(phases)[0][:, which] > SEARCH.rounding)
        if not len(positive):
            return low, low
        return float(phases[positive[0]]), float(phases[positive[0] - 1])

    def _lowest(
        self,
        which: int,
        low: float,
        high: float,
        ends: tuple[float, float],
        rates: tuple[float, float],
    ) -> tuple[float, float]:
        """Return an interval with the zero before a minimum; an empty one if that is positive."""
        length = high - low
        places = np.linspace(0.0, 1.0, 17)
        cubic = (
            (1 + 2 * places) * (1 - places) ** 2 * ends[0]
            + places**2 * (3 - 2 * places) * ends[1]
            + length * places * (1 - places) * ((1 - places) * rates[0] - places * rates[1])
        )
        if cubic.min() > SEARCH.near * min(ends):
            return high, low
        left, right = low, high
        for _ in range(SEARCH.iterations):
            middle = 0.5 * (left + right)
            value, slope = self._one(which, middle)
            if value <= 0:
                return low, middle
            if not left < middle < right:
                break
            left, right = (middle, right) if slope < 0 else (left, middle)
        return high, low

    def _zero(self, which: int, low: float, high: float) -> float:
        """Return the phase in an interval at which a function falls through zero."""
        phase, before = high, np.inf
        for _ in range(SEARCH.iterations):
            value, slope = self._one(which, phase)
            low, high = (phase, high) if value > 0 else (low, phase)
            after = phase - value / slope if slope < 0 else np.inf
            after = after if low <= after <= high else 0.5 * (low + high)
            moved, phase = abs(after - phase), after
            if moved <= SEARCH.exact or SEARCH.settled * before < moved < SEARCH.fine:
                break
            before = moved
        return float(phase)
