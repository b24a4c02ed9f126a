"""Events of modes whose rates and event functions are affine, in closed form."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.flow.affine_flow import (
    AffineFlow,
    AffineSolutions,
    Harmonics,
    harmonics_of,
    is_affine,
)
from slipfold.flow.compiled_code import Slopes
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.flow.modes import CONTACT, Ending, SwitchingEvent


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
    iterations: int = 60  # of Newton's method for the time of an event, which bisects if need be


SEARCH = EventSearch()


class AffineEvents:
    """The events of a mode whose rates and event functions are affine."""

    def __init__(
        self, flow: AffineFlow, events: Sequence[SwitchingEvent], slopes: Slopes, contacts: int
    ) -> None:
        self._flow, self._events, self._slopes = flow, events, slopes
        falls = np.array([-1.0 if event.rising else 1.0 for event in events])
        self._falls = falls
        self._weights = [
            event.which + (0 if event.ending is Ending.STOPS else contacts) for event in events
        ]
        self._known: tuple[Constants | None, Array, Harmonics | None] = None, falls, None

    @classmethod
    def of(
        cls, flow: Flow, events: Sequence[SwitchingEvent], slopes: Callable[[], Slopes], count: int
    ) -> AffineEvents | None:
        """Return the events, None if they are not affine."""
        if not isinstance(flow, AffineFlow) or flow.dimension < SEARCH.many:
            return None
        if any(event.scaled or event.ending is Ending.LIMIT for event in events):
            return None
        if not is_affine([event.expression for event in events], flow.equations):
            return None
        return cls(flow, events, slopes(), count)

    def first(
        self, state: Array, begin: float, end: float, constants: Constants, weights: Array
    ) -> tuple[SwitchingEvent | None, float, Array] | None:
        """Return the first event, its phase and the state there, else those at the end.

        None where no closed form has enough digits. Shapes: state (n,).
        """
        solutions = self._flow.solutions(constants)
        if solutions is None:
            return None
        watched = self._watched(solutions, state, begin, constants, weights)
        if watched is None:
            return None
        event, phase = None, end
        found = watched.first(end) if self._events else None
        if found is not None:
            event, phase = self._events[found[0]], found[1]
        return event, phase, (watched.motions(np.array([phase])) @ solutions.shapes.T).real[0]

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

    def at(self, phases: Array) -> tuple[Array, Array, Complex]:
        """Return the functions and their slopes, shape (p, q), and the solution."""
        moved = self.motions(phases)
        rates = self.solutions.rates(moved, phases)
        turned = np.exp(phases[:, None] * self.own.exponents)
        values = moved @ self.seen.T + turned @ self.own.values
        slopes = rates @ self.seen.T + (turned * self.own.exponents) @ self.own.values
        return values.real + CONTACT.event_distance, slopes.real, moved

    def _step(self, phase: float, motion: Complex, longest: float) -> float:
        """Return the distance of samples that shows all vibrations that matter from a phase on."""
        solutions, seen = self.solutions, np.abs(self.seen)
        exponents = solutions.forcing.exponents
        left = np.abs(motion - np.exp(phase * exponents) @ solutions.answers)
        total = seen @ np.abs(motion) + np.finfo(float).tiny
        visible = (seen * left > SEARCH.visible * total[:, None]).any(axis=0)
        fastest = max(
            np.abs(solutions.values[visible]).max(initial=0.0),
            np.abs(exponents).max(initial=0.0),
            np.abs(self.own.exponents).max(initial=0.0),
        )
        return min(longest, SEARCH.turn / fastest) if fastest else longest

    def first(self, end: float) -> tuple[int, float] | None:
        """Return the number and the phase of the first event up to a phase, None if none."""
        phase, motion, longest = self.begin, self.start, (end - self.begin) / SEARCH.fewest
        while phase < end:
            step = self._step(phase, motion, longest)
            regular = phase + step * np.arange(SEARCH.samples + 1)
            phases: Array = np.append(regular[regular < end - 0.01 * step], end)
            phases = phases[: SEARCH.samples + 1]
            values, slopes, moved = self.at(phases)
            found = self._between(phases, values, slopes)
            if found is not None:
                return found
            phase, motion = float(phases[-1]), moved[-1]
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
        values, slopes, _ = self.at(np.array([phase]))
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
        phase = high
        for _ in range(SEARCH.iterations):
            if not low < high:
                break
            value, slope = self._one(which, phase)
            low, high = (phase, high) if value > 0 else (low, phase)
            after = phase - value / slope if slope < 0 else np.inf
            after = after if low < after < high else 0.5 * (low + high)
            if abs(after - phase) <= np.spacing(abs(phase)) or not low < after < high:
                break
            phase = float(after)
        return phase
