"""A motion in pieces, each told as soon as it is computed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.explorer.messages import SimulationRequest
from slipfold.explorer.start import start_of, timed
from slipfold.explorer.views.contacts import contacts_view
from slipfold.explorer.views.numbers import short
from slipfold.flow import flow_of
from slipfold.flow.flow import Flow
from slipfold.flow.guarded_flow import CHUNK
from slipfold.flow.simulate import Motion, initial_state
from slipfold.flow.switched.sampled import sample_switched
from slipfold.flow.switched.simulate import (
    begun,
    comes_to_rest,
    ends_of,
    slips_at_first,
    trajectory_of,
)
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import Model

PERIODS = 2 * CHUNK
"""Periods in a piece: as the flow counts them, so that a motion is that of simulate."""

SAMPLES = 64
"""Samples a forcing period that maxima and minima are taken from."""

DRAWN = 20_000
"""Instants of a whole run that are drawn; a longer run is drawn more coarsely."""

TOLERANCE = 1e-9
"""Distance from a periodic response that counts as settled, as in `slipfold.simulate`."""


def stream_simulation(
    model: Model, request: SimulationRequest, emit: Callable[[dict[str, Any]], None]
) -> None:
    """Integrate a motion and tell it piece by piece.

    One that comes to rest in a contact is told anew, with all its stick and slip.
    """
    start = initial_state(model, start_of(model, request))
    every = _step_between_samples(request.periods)
    again = not slips_at_first(model, start)
    if not again:
        motion = _smooth(timed(model, request), start, request.periods, every, emit)
        if comes_to_rest(motion.stopped, model):
            again = True
        else:
            found = Trajectory(
                motion.model, motion.strobe, motion.settlement(TOLERANCE), motion.stopped
            )
    if again:
        emit({**NOTHING, "again": True, "done": False})
        found = _switched(model, start, request.periods, every, emit)
    emit({**NOTHING, "done": True, **_verdict(found), "contacts": contacts_view(found)})


NOTHING: Mapping[str, Any] = {"t": [], "states": {}, "sections": None}


def _smooth(
    model: Model, start: Array, periods: int, every: int, emit: Callable[[dict[str, Any]], None]
) -> Motion:
    motion, flow = Motion(model, start), flow_of(model)
    constants = flow.constants_of(model)
    phases = np.arange(SAMPLES) / SAMPLES
    while motion.periods < periods and motion.stopped is None:
        done = motion.periods
        starts = motion.go_on(min(PERIODS, periods - done))
        if len(starts):
            begin = np.zeros(len(starts))
            states = flow.sample(starts, begin, begin + 1.0, SAMPLES, constants)
            rows = states.reshape(-1, flow.dimension)
            values = flow.outputs(rows, np.tile(phases, len(starts)), constants)
            emit(_piece(model, values.reshape(len(starts), SAMPLES, -1), done, every))
    return motion


def _switched(
    model: Model, start: Array, periods: int, every: int, emit: Callable[[dict[str, Any]], None]
) -> Trajectory:
    motion = begun(model, start, paced=True)
    phases = np.arange(SAMPLES) / SAMPLES
    # What nothing forces goes on until it has settled, as in `slipfold.simulate`.
    for end in ends_of(model, periods if model.forced else None):
        while motion.periods < end and motion.stopped is None:
            done = motion.periods
            motion.go_on(min(PERIODS, end - done))
            begins = zip(motion.strobe[done:-1], motion.modes[done:-1], strict=True)
            values = [
                sample_switched(motion.model, state, mode, phases).outputs()
                for state, mode in begins
            ]
            if values:
                emit(_piece(motion.model, np.array(values), done, every))
        found = trajectory_of(motion, TOLERANCE)
        if found.settlement.settled or motion.stopped is not None:
            break
    return found


def _step_between_samples(periods: int) -> int:
    """Return how many samples make one drawn instant; a divisor of the samples a period."""
    wanted = max(DRAWN / periods, 4)
    return next(step for step in (1, 2, 4, 8, 16) if SAMPLES / step <= wanted or step == 16)


def _piece(model: Model, values: Array, done: int, every: int) -> dict[str, Any]:
    """Tell some periods. Shapes: values (n_periods, SAMPLES, n_outputs), the states first."""
    flow = flow_of(model)
    period = flow.constants_of(model).period
    numbers = done + np.arange(len(values))
    time = (numbers[:, None] + np.arange(SAMPLES) / SAMPLES) * period
    drawn = values[:, ::every].reshape(-1, values.shape[2])
    return {
        "t": short(time[:, ::every].ravel()),
        "states": {item.name: short(drawn[:, i]) for i, item in enumerate(model.states)},
        "sections": {
            "period": numbers.tolist(),
            "duration": period,
            "start": {item.name: short(values[:, 0, i]) for i, item in enumerate(model.states)},
            **_extrema(flow, values),
        },
        "done": False,
    }


def _extrema(flow: Flow, values: Array) -> dict[str, dict[str, list[float]]]:
    """Tell extrema of outputs, but of those that mean nothing, as slip over the speed of a wall."""
    told = [i for i in range(values.shape[2]) if np.isfinite(values[..., i]).all()]
    low, high = values.min(axis=1), values.max(axis=1)
    return {
        "max": {flow.output_names[i]: short(high[:, i]) for i in told},
        "min": {flow.output_names[i]: short(low[:, i]) for i in told},
    }


def _verdict(motion: Trajectory) -> dict[str, Any]:
    judged, stop = motion.settlement, motion.stopped
    return {
        "verdict": judged.message if stop is None else stop.reason,
        "settled": judged.settled,
        "period": judged.period,
        "duration": judged.duration,
    }
