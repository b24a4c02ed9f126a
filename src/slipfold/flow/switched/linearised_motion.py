r"""How the end of a switched motion depends on its beginning and on parameters.

In each mode that is what the variations of its flow say. At an event :math:`h(x, t, p) = 0` the
mode changes at a time that depends on them as well: with rates :math:`f^-, f^+` on either side

.. math:: \delta t = -\frac{h_x \delta x + h_p \delta p}{h_x f^- + h_t}, \qquad
          \delta x^+ = \delta x^- + (f^- - f^+)\, \delta t .

What sticks afterwards has no slip, however the motion is varied: that direction is lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.equations import Constants
from slipfold.flow.switched.events import Ending
from slipfold.flow.switched.mode import Mode, Status, shown
from slipfold.flow.switched.release import FIRST, direction_of_release
from slipfold.flow.switched.switched_flow import Leg, SwitchedFlow

__all__ = ["LinearisedMotion", "linearised_motion"]

Array = NDArray[np.float64]

SHORT = 1e-9
"""Share of a leg of slow slip that is left out before it comes to rest: there the equations are
singular, and what happens to perturbations in so short a time is of second order."""

BEGUN = 1e-9
"""Slip in the plane, over its size, with which slip begins that grows at once: less has too few
digits for its direction."""


WIDER = 1.3
"""Pieces in which slip that begins slowly is followed grow by this."""

UNCHANGED = (Ending.SLOWS, Ending.QUICKENS)
"""Events at which only the variables of the integration change."""


@dataclass(frozen=True, eq=False)
class LinearisedMotion:
    """Derivatives of a motion's end, by its beginning and along changes of the coefficients."""

    matrix: Array  # shape (n, n)
    vectors: Array  # shape (n, k)


def linearised_motion(
    flow: SwitchedFlow,
    start: Array,
    passed: Sequence[tuple[Leg, Mode]],
    constants: Constants,
    weights: Array,
    directions: Array,
) -> LinearisedMotion:
    """Linearise a motion that was carried through its legs, each with the mode that follows.

    Shapes: start (n,); directions (n_c, k).
    """
    variations, n = _Variations(flow, constants, weights, directions), len(start)
    first = passed[0][0]
    start = flow.held(_equations_in(first), start, first.begin, constants)
    beyond = [variations.beyond(leg, after) for leg, after in passed]
    starts = np.array([start, *_starts(passed, beyond)[:-1]])
    ends, matrices, vectors = variations.carried([leg for leg, _ in passed], starts)
    varied = np.eye(n, n + directions.shape[1])
    varied = variations.held(_equations_in(first), start, first.begin, varied)
    delay = np.zeros(varied.shape[1])
    for place, (leg, after) in enumerate(passed):
        varied = matrices[place] @ varied
        varied[:, n:] += vectors[place]
        if leg.released:
            follows = passed[place + 1 : place + 2]
            if leg.held is not None and not any(item.released for item, _ in follows):
                varied = variations.slipping(leg, varied, delay)
        elif leg.event is not None and leg.event.ending not in UNCHANGED:
            varied, delay = variations.changed(leg, after, ends[place], beyond[place], varied)
    return LinearisedMotion(varied[:, :n], varied[:, n:])


def _equations_in(leg: Leg) -> Mode:
    """Return the mode whose equations hold in a leg."""
    return shown(leg.held or leg.mode)


def _starts(passed: Sequence[tuple[Leg, Mode]], beyond: Sequence[Array]) -> list[Array]:
    """Return the states from which motions go on after each leg."""
    found = list[Array]()
    for place, (leg, _) in enumerate(passed):
        # Where a motion begins so, its state is all that is known.
        at_once = bool(found) and leg.released and leg.held is None
        follows = place + 1 < len(passed) and passed[place + 1][0].held is not None
        found.append(found[-1] if at_once else leg.state if follows else beyond[place])
    return found


class _Variations:
    """Carries variations of a motion, shape (n, n + k), through legs and events."""

    def __init__(
        self, flow: SwitchedFlow, constants: Constants, weights: Array, directions: Array
    ) -> None:
        self._flow, self._constants = flow, constants
        self._weights, self._directions = weights, directions

    def beyond(self, leg: Leg, after: Mode) -> Array:
        """Return the state after a leg, a little slip in what begins to slip in the plane."""
        state = leg.state
        if leg.event is None or leg.released:
            return state
        for contact, status in enumerate(after):
            if status is Status.SLOW and _rests(leg, contact):
                args = self._flow, after, contact, state, leg.end, self._constants
                slip = BEGUN / self._weights[contact] * direction_of_release(*args)
                return self._flow.slipping(after, state, slip, leg.end, self._constants)
        return state

    def carried(self, legs: Sequence[Leg], starts: Array) -> tuple[Array, Array, Array]:
        """Return the ends of legs with their derivatives, those of one mode side by side.

        Shapes: starts (m, n); returns (m, n), (m, n, n), (m, n, k).
        """
        begin, end = (np.array([getattr(leg, at) for leg in legs]) for at in ("begin", "end"))
        for place, leg in enumerate(legs):
            if _comes_to_rest_in_the_plane(leg):
                end[place] -= SHORT * (leg.end - leg.begin)
        n, k = starts.shape[1], self._directions.shape[1]
        ends, matrices = starts.copy(), np.tile(np.eye(n), (len(legs), 1, 1))
        vectors = np.zeros((len(legs), n, k))
        modes = [_equations_in(leg) for leg in legs]
        stiff = np.array([False, *(leg.released and leg.held is not None for leg in legs[:-1])])
        stiff &= [not leg.released for leg in legs]
        for mode in dict.fromkeys(modes):
            in_mode = np.array([item == mode for item in modes]) & (end > begin)
            some = np.flatnonzero(in_mode & ~stiff)
            if len(some):
                ends[some], matrices[some], vectors[some] = self._flow.of(mode).linearise(
                    starts[some], begin[some], end[some], self._constants, self._directions
                )
            for one in np.flatnonzero(in_mode & stiff):
                spans = _growing_spans(begin[one], end[one])
                found = self._through(mode, starts[one], spans)
                ends[one], matrices[one], vectors[one] = found
        return ends, matrices, vectors

    def _through(self, mode: Mode, start: Array, phases: Array) -> tuple[Array, Array, Array]:
        """Return the same of one leg that is cut at some phases, one piece after the other.

        Shapes: start (n,); phases (p,); returns (n,), (n, n), (n, k).
        """
        flow, n = self._flow.of(mode), len(start)
        end, varied = start[None], np.eye(n, n + self._directions.shape[1])
        for begin, until in pairwise(phases[:, None]):
            end, matrices, vectors = flow.linearise(
                end, begin, until, self._constants, self._directions
            )
            varied = matrices[0] @ varied
            varied[:, n:] += vectors[0]
        return end[0], varied[:, :n], varied[:, n:]

    def changed(
        self, leg: Leg, after: Mode, end: Array, beyond: Array, varied: Array
    ) -> tuple[Array, Array]:
        """Return variations after an event, and by how much it comes later."""
        mode, phase = shown(leg.mode), np.array([leg.end])
        states, explicit, pulls = self._event_slopes(leg, end)
        rates = self._flow.of(mode).rates(end[None], phase, self._constants)[0]
        new_rates = self._flow.of(after).rates(beyond[None], phase, self._constants)[0]
        met = states @ varied
        met[len(end) :] += pulls
        delay = -met / (states @ rates + explicit)
        varied = varied + np.outer(rates - new_rates, delay)
        return self.held(after, leg.state, leg.end, varied), delay

    def _event_slopes(self, leg: Leg, end: Array) -> tuple[Array, float, Array]:
        """Return the derivatives of what is zero at an event."""
        event, flow = leg.event, self._flow
        assert event is not None
        if event.ending is Ending.STOPS:
            place = flow.quantities.places[event.which]
            slip = np.array(flow.quantities.at(end, leg.end, self._constants).slip[place])
            along = slip / np.linalg.norm(slip) if len(slip) == 2 else np.ones(1)
            found = flow.slips.at(end, leg.end, self._constants, self._directions)
            states, explicit, pulls = (along @ item[place] for item in found)
            return states, float(explicit), pulls
        slopes, which = flow.event_slopes(shown(leg.mode), event)
        found = slopes.at(end, leg.end, self._constants, self._directions)
        states, explicit, pulls = (item[which] for item in found)
        return states, float(explicit), pulls

    def held(self, mode: Mode, state: Array, phase: float, varied: Array) -> Array:
        """Return variations as the contacts of a mode hold them: what sticks has no slip."""
        mode = shown(mode)
        places = self._flow.places_held(mode)
        if not places:
            return varied
        slopes = self._flow.held_slopes(mode)
        states, _, pulls = slopes.at(state, phase, self._constants, self._directions)
        result = varied.copy()
        result[places] = states @ varied
        result[places, len(state) :] += pulls
        return result

    def slipping(self, leg: Leg, varied: Array, delay: Array) -> Array:
        """Return variations where slip that grows slowly has begun: it began as much later."""
        flow, constants = self._flow, self._constants
        contact = leg.mode.index(Status.SLOW)
        place = flow.quantities.places[contact]
        slip = np.array(flow.quantities.at(leg.state, leg.end, constants).slip[place])
        # It grows with the square of the time, and the leg is the second half of that.
        rate = slip / (leg.end - leg.begin)
        states = flow.slips.at(leg.state, leg.end, constants, self._directions)[0]
        moved = np.zeros((len(states), len(delay)))
        moved[place] = -np.outer(rate, delay)
        known = [
            row
            for status, each in zip(leg.mode, flow.quantities.places, strict=True)
            if status in (Status.STICK, Status.SLOW)
            for row in range(each.start, each.stop)
        ]
        places, result = flow.places_held(leg.mode), varied.copy()
        result[places] += np.linalg.solve(states[np.ix_(known, places)], moved[known])
        return result


def _growing_spans(begin: float, end: float) -> Array:
    """Return phases that cut a leg the less finely the longer slip has grown.

    Friction turns slow slip so firmly that an integrator would take its steps for hopeless.
    """
    count = max(1, int(np.log((end - begin) / FIRST + 1) / np.log(WIDER)))
    lengths = FIRST * (WIDER ** np.arange(count) - 1)
    return np.append(begin + lengths, end)


def _rests(leg: Leg, contact: int) -> bool:
    """Whether a contact has no slip at the end of a leg."""
    event = leg.event
    stops = event is not None and event.ending is Ending.STOPS and event.which == contact
    return stops or leg.mode[contact] is Status.STICK


def _comes_to_rest_in_the_plane(leg: Leg) -> bool:
    event = leg.event
    if event is None or event.ending is not Ending.STOPS:
        return False
    return leg.mode[event.which] is Status.SLOW
