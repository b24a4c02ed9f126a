"""A flow that watches the model's limits and stops where one is met."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.batches import (
    ARRIVED,
    CALL,
    LONGEST,
    STEEP,
    STEP_LIMIT,
    go_on,
)
from slipfold.flow.compiled_code import shared_by_kind
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.implicit_steps import MOST, End, StiffFallback, Watch
from slipfold.models.model import Model
from slipfold.models.turns import without_turns

CHUNK = 16
"""Forcing periods per call: enough to hide its cost, and phases stay small, hence exact."""


@dataclass(frozen=True)
class Stop:
    """Why and when a trajectory ended early.

    Parameters
    ----------
    kind
        Name of the limit met, e.g. ``"stick"``, ``"singular"`` or ``"stiff"``.
    reason
        A sentence that says what happened and what can be done.
    time
        Seconds from the start.
    """

    kind: str
    reason: str
    time: float


class Strobe(NamedTuple):
    """States after some forcing periods, shape (m, n), why the trajectory ended, if it did.

    And how many periods took implicit steps.
    """

    states: Array
    stop: Stop | None = None
    implicit: int = 0


class GuardedFlow:
    """The flow of a model from one forcing period to the next, ended where a limit is met.

    The values of the model's parameters play no part.
    """

    def __init__(self, model: Model) -> None:
        self.limits = model.limits
        self._flow: Flow = flow_of(model)
        self._forced = model.forced
        self._whole_turns = model.whole_turns
        # The more turns an angle has made, the larger the errors of steps: begin each period again.
        self._together = 1 if self._whole_turns.any() else CHUNK
        self._watched = [self._flow.output_index(limit.output) for limit in model.limits]
        self._bounds = np.array([limit.bound for limit in model.limits])

    def strobe(self, state: Array, periods: int, constants: Constants) -> Array:
        """Return the states after each of some forcing periods, as far as the trajectory comes.

        Shapes: state (n,); returns (periods + 1, n).
        """
        pieces = self.pieces(state, periods, constants)
        return np.concatenate([state[None], *(piece.states for piece in pieces)])

    def pieces(
        self,
        state: Array,
        periods: int,
        constants: Constants,
        before: int = 0,
        weights: Array | None = None,
    ) -> Iterator[Strobe]:
        """Propagate a state over forcing periods, a few at a time; the phase restarts with them.

        Shapes: state (n,).
        """
        stop = self._stop_at_start(state, before, constants)
        if stop is not None:
            yield Strobe(state[None][:0], stop)
            return
        weights = self.weights(state, constants) if weights is None else weights
        parameters = np.concatenate([constants.values, constants.scales, weights])
        done = 0
        while done < periods and stop is None:
            count = min(self._together, periods - done)
            piece = self._run(state, count, constants, parameters, before + done)
            states, stop = without_turns(piece.states, self._whole_turns), piece.stop
            yield piece._replace(states=states)
            done += len(states)
            state = states[-1] if len(states) else state

    def released(self, state: Array, phase: float, constants: Constants) -> Strobe:
        """Carry a state from a phase below one to the end of that period. Shapes: state (n,)."""
        stop = self._stop_at_start(state, 0, constants, phase)
        if stop is not None:
            return Strobe(state[None][:0], stop)
        weights = self.weights(state, constants)
        parameters = np.concatenate([constants.values, constants.scales, weights])
        return self._run(state, 1, constants, parameters, -phase, phase)

    def _run(
        self,
        state: Array,
        count: int,
        constants: Constants,
        parameters: Array,
        done: float,
        phase: float = 0.0,
    ) -> Strobe:
        """Integrate a chunk; return the states after each whole period."""
        integrator = self._flow.integrator(self.limits)
        integrator.time = phase
        integrator.state[:] = state / constants.scales
        integrator.pars[:] = parameters
        events = 0
        if integrator.with_events:
            integrator.reset_cooldowns()
            events = len(integrator.t_events)
        grid = np.arange(count + 1.0)
        grid[0] = phase
        # A stop cuts the grid short, a singularity fills it with what is no number.
        result = integrator.propagate_grid(grid, max_steps=min(CALL * count, STEEP))
        outcome, states = int(result[0]), result[-1][1:] * constants.scales
        finite = np.isfinite(states).all(axis=1)
        states = states if finite.all() else states[: int(finite.argmin())]
        if outcome == STEP_LIMIT and not len(states):
            takeover = StiffFallback(self._flow, constants)
            left = go_on(integrator, 1.0, takeover, steep=events > len(self.limits))
            if left is None:
                return self._implicitly(takeover, integrator, constants, done)
            outcome = left
            if outcome == ARRIVED:
                return Strobe(np.array(integrator.state)[None] * constants.scales)
        if len(states) == count or (outcome == STEP_LIMIT and len(states)):
            return Strobe(states)
        time = (done + float(integrator.time)) * constants.period
        if -len(self.limits) <= outcome < 0:
            met = integrator.state * constants.scales
            return Strobe(states, self._stop(-1 - outcome, met, integrator.time, constants, time))
        known = np.isfinite(time)
        if not known:  # an overflow left nothing but what is no number
            time = (done + len(states)) * constants.period
        place = f"{'' if known else 'more than '}{time:.6g} s after the start"
        if self._forced:
            place += f", in forcing period {math.ceil(done) + len(states) + 1}"
        if outcome == STEP_LIMIT and abs(integrator.last_h) > 1e-9:  # else before a singularity
            return Strobe(states, self._stiff(LONGEST, place, constants, time))
        return Strobe(states, self._singular(place, time))

    def _implicitly(
        self, takeover: StiffFallback, integrator: Any, constants: Constants, done: float
    ) -> Strobe:
        """Continue to the end of a period in implicit steps."""
        motion = takeover.motion(integrator, 1.0, watch=self._margins(constants))
        met, time = motion.state * constants.scales, (done + motion.phase) * constants.period
        if motion.end is End.ARRIVED:
            return Strobe(met[None], implicit=1)
        place = f"{time:.6g} s after the start"
        if self._forced:
            place += f", in forcing period {math.ceil(done) + 1}"
        if motion.limit is not None:
            stop = self._stop(motion.limit, met, motion.phase, constants, time)
        elif motion.end is End.MANY:
            stop = self._stiff(MOST, place, constants, time)
        else:
            stop = self._singular(place, time)
        return Strobe(np.empty((0, len(met))), stop)

    def _margins(self, constants: Constants) -> Watch | None:
        """Return what tells how far scaled states are from the limits; None if there are none."""
        if not self.limits:
            return None

        def margins(phases: Array, states: Array) -> Array:
            values = self._flow.outputs(states * constants.scales, phases, constants)
            return np.asarray(values[:, self._watched] - self._bounds)

        return margins

    def _stiff(self, steps: int, place: str, constants: Constants, time: float) -> Stop:
        piece = "a forcing period" if self._forced else f"{constants.period:g} s"
        return Stop(
            "stiff",
            f"the motion would need more than {steps} steps in {piece} {place}; make what is "
            "steep or fast in the model less so",
            time,
        )

    def _singular(self, place: str, time: float) -> Stop:
        advice = "start nearer to rest or lower the forcing" if self._forced else "start elsewhere"
        return Stop("singular", f"the motion became singular {place}; {advice}", time)

    def _stop(
        self, which: int, state: Array, phase: float, constants: Constants, time: float
    ) -> Stop:
        limit = self.limits[which]
        values = self._flow.outputs(np.array([state]), np.array([phase]), constants)
        value = float(values[0, self._watched[which]])
        return Stop(limit.name, limit.reason.format(value=value), time)

    def weights(self, state: Array, constants: Constants) -> Array:
        """Return one over the scales of what is watched, which counts in the length of a step.

        Shapes: state (n,).
        """
        around = np.diag(constants.scales)
        states = np.concatenate([state[None], state + around, state - around])
        phases = np.repeat(np.arange(4) / 4, len(states))
        values = self._flow.outputs(np.tile(states, (4, 1)), phases, constants)
        distances = np.abs(values[:, self._watched] - self._bounds)
        sizes = np.max(distances, axis=0, initial=0.0, where=np.isfinite(distances))
        return 1 / np.where(sizes > 0, sizes, 1.0)

    def _stop_at_start(
        self, state: Array, before: int, constants: Constants, phase: float = 0.0
    ) -> Stop | None:
        values = self._flow.outputs(state[None], np.full(1, phase), constants)[0]
        for which, limit in enumerate(self.limits):
            # An event fires where the output crosses its bound, so not if it begins below.
            if not values[self._watched[which]] > limit.bound:
                return self._stop(which, state, phase, constants, before * constants.period)
        return None


@shared_by_kind
def guarded_flow_of(model: Model) -> GuardedFlow:
    """Return the guarded flow of a model; models with the same equations share one.

    >>> from slipfold.models import SlidingOscillator
    >>> [limit.name for limit in guarded_flow_of(SlidingOscillator()).limits]
    ['stick', 'lost contact', 'spring collapse']
    """
    return GuardedFlow(model)
