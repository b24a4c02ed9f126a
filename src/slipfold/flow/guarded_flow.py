"""A flow that monitors the model's limits and stops where one is reached."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.batches import ARRIVED, BUDGET, STEP_LIMIT, continue_to
from slipfold.flow.equations import Constants
from slipfold.flow.flow import flow_of
from slipfold.flow.implicit_steps import IMPLICIT, StepsEnd, StiffFallback
from slipfold.models.angles import wrap_angles
from slipfold.models.model import Model
from slipfold.read_only import Documented

CHUNK = 16
"""Forcing periods per call of the integrator. More would not make the overhead of calls smaller by
much, and phases would lose digits."""


@dataclass(frozen=True)
class GuardStop(Documented):
    """Why and when a trajectory ended early."""

    kind: Annotated[
        str,
        'Name of the limit that was reached, e.g. ``"stick"``; or ``"singular"`` or ``"stiff"``.',
    ]
    reason: Annotated[str, "A sentence that says what happened and what can be done."]
    time: Annotated[float, "Seconds from the start."]


class Chunk(NamedTuple):
    """A part of a trajectory."""

    states: Array  # states after each forcing period, shape (m, n)
    stop: GuardStop | None = None  # why the trajectory ended; None if it did not
    implicit: int = 0  # number of periods that took implicit steps


class GuardedFlow:
    """The stroboscopic map of a model along one trajectory, which ends where a limit is reached.

    The scales of the monitored outputs follow from the start of the trajectory. Shapes: start (n,).
    """

    def __init__(self, model: Model, constants: Constants, start: Array) -> None:
        self._model, self._limits = model, model.limits
        self._flow, self._constants = flow_of(model), constants
        # Errors of steps grow with the revolutions of an angle: wrap angles after each period.
        self._angle_periods = model.angle_periods
        self._together = 1 if self._angle_periods.any() else CHUNK
        self._parameters = np.concatenate([constants.known, self._weights(start)])

    def pieces(self, state: Array, periods: int, before: int = 0) -> Iterator[Chunk]:
        """Propagate a state over forcing periods, in parts that each begin at phase zero.

        Shapes: state (n,).
        """
        stop, done = self._stop_at_start(state, 0.0, before), 0
        if stop is not None:
            yield Chunk(state[None][:0], stop)
        while done < periods and stop is None:
            count = min(self._together, periods - done)
            piece = self._run(state, count, before + done)
            states, stop = wrap_angles(piece.states, self._angle_periods), piece.stop
            yield piece._replace(states=states)
            done += len(states)
            state = states[-1] if len(states) else state

    def to_period_end(self, state: Array, phase: float) -> Chunk:
        """Propagate a state from a phase to the end of the period. Shapes: state (n,)."""
        stop = self._stop_at_start(state, phase, 0)
        return self._run(state, 1, -phase, phase) if stop is None else Chunk(state[None][:0], stop)

    def _run(self, state: Array, count: int, done: float, phase: float = 0.0) -> Chunk:
        """Integrate a chunk; return the states after each complete period."""
        integrator, constants = self._flow.integrator(self._limits), self._constants
        integrator.time = phase
        integrator.state[:] = state / constants.scales
        integrator.pars[:] = self._parameters
        events = 0
        if integrator.with_events:
            integrator.reset_cooldowns()
            events = len(integrator.t_events)
        grid = np.arange(count + 1.0)
        grid[0] = phase
        # After a stop the grid is shorter; after a singularity it contains NaN.
        result = integrator.propagate_grid(grid, max_steps=min(BUDGET.call * count, BUDGET.steep))
        outcome, states = int(result[0]), result[-1][1:] * constants.scales
        finite = np.isfinite(states).all(axis=1)
        states = states if finite.all() else states[: int(finite.argmin())]
        if outcome == STEP_LIMIT and not len(states):
            fallback = StiffFallback(self._flow, constants)
            left = continue_to(integrator, 1.0, fallback, steep=events > len(self._limits))
            if left is None:
                return self._run_implicitly(fallback, integrator, done)
            outcome = left
            if outcome == ARRIVED:
                return Chunk(np.array(integrator.state)[None] * constants.scales)
        if len(states) == count or (outcome == STEP_LIMIT and len(states)):
            return Chunk(states)
        if -len(self._limits) <= outcome < 0:
            met, phase = integrator.state * constants.scales, float(integrator.time)
            return Chunk(states, self._limit_stop(-1 - outcome, met, phase, done))
        # Steps become short before a singularity. If the last one is not, the motion is stiff.
        stiff = (
            BUDGET.trajectory if outcome == STEP_LIMIT and abs(integrator.last_h) > 1e-9 else None
        )
        return Chunk(states, self._failed(stiff, done, len(states), float(integrator.time)))

    def _run_implicitly(self, fallback: StiffFallback, integrator: Any, done: float) -> Chunk:
        """Continue to the end of a period in implicit steps."""
        trajectory = fallback.motion(integrator, 1.0, watch=self._margins if self._limits else None)
        state = trajectory.state * self._constants.scales
        if trajectory.end is StepsEnd.ARRIVED:
            return Chunk(state[None], implicit=1)
        if trajectory.limit is not None:
            stop = self._limit_stop(trajectory.limit, state, trajectory.phase, done)
        else:
            stop = self._failed(
                IMPLICIT.max_steps if trajectory.end is StepsEnd.MANY else None,
                done,
                0,
                trajectory.phase,
            )
        return Chunk(np.empty((0, len(state))), stop)

    def _margins(self, phases: Array, states: Array) -> Array:
        """Return how far scaled states are from the limits, shape (m, limits)."""
        scales = self._constants.scales
        return self._flow.margins(self._limits, states * scales, phases, self._constants)

    def _failed(self, steps: int | None, done: float, periods: int, phase: float) -> GuardStop:
        """Return the stop of a trajectory that takes too many steps or became singular."""
        forced, period = self._model.forced, self._constants.period
        time = (done + phase) * period
        known = np.isfinite(time)
        if not known:  # after an overflow
            time = (done + periods) * period
        where = f"{'' if known else 'more than '}{time:.6g} s after the start"
        if forced:
            where += f", in forcing period {math.ceil(done) + periods + 1}"
        if steps is None:
            away = forced and time > 0  # at its start it is the start that has no derivative
            advice = "start nearer to rest or lower the forcing" if away else "start elsewhere"
            return GuardStop("singular", f"the trajectory became singular {where}; {advice}", time)
        piece = "a forcing period" if forced else f"{period:g} s"
        reason = (
            f"the trajectory would need more than {steps} steps in {piece} {where}; make the steep "
            "or fast terms of the model less so"
        )
        return GuardStop("stiff", reason, time)

    def _limit_stop(self, which: int, state: Array, phase: float, done: float) -> GuardStop:
        limit = self._limits[which]
        values = self._flow.outputs(np.array([state]), np.array([phase]), self._constants)
        value = float(values[0, self._flow.output_index(limit.output)])
        reason = limit.reason.format(value=value)
        return GuardStop(limit.name, reason, (done + phase) * self._constants.period)

    def _stop_at_start(self, state: Array, phase: float, before: int) -> GuardStop | None:
        at = np.full(1, phase)
        margins = self._margins(at, state[None] / self._constants.scales)[0]
        # An event occurs where the output crosses its bound, so none occurs if it starts below.
        (below,) = np.nonzero(~(margins > 0))
        if len(below):
            return self._limit_stop(int(below[0]), state, phase, before - phase)
        (unknown,) = np.nonzero(~np.isfinite(self._flow.rates(state[None], at, self._constants)[0]))
        if not len(unknown):
            return None
        name = self._model.states[int(unknown[0])].name
        reason = f"the rate of {name} has no value where the trajectory starts; start elsewhere"
        return GuardStop("singular", reason, before * self._constants.period)

    def _weights(self, state: Array) -> Array:
        """Return one over the scales of the monitored outputs, which limit the step length."""
        around = np.diag(self._constants.scales)
        states = np.concatenate([state[None], state + around, state - around])
        phases = np.repeat(np.arange(4) / 4, len(states))
        distances = np.abs(self._margins(phases, np.tile(states / self._constants.scales, (4, 1))))
        sizes = np.max(distances, axis=0, initial=0.0, where=np.isfinite(distances))
        return 1 / np.where(sizes > 0, sizes, 1.0)
