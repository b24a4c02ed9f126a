"""A motion in pieces, each told as soon as it is computed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.explorer.messages import SimulationRequest
from slipfold.explorer.start import start_of, timed
from slipfold.explorer.views.numbers import short
from slipfold.flow import flow_of
from slipfold.flow.flow import Flow
from slipfold.flow.guarded_flow import CHUNK
from slipfold.flow.simulate import Motion, initial_state
from slipfold.models.model import Model

__all__ = ["stream_simulation"]

Array = NDArray[np.float64]

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
    """Integrate a motion and tell it piece by piece."""
    periods = request.periods
    start = initial_state(model, start_of(model, request))
    model = timed(model, request)
    motion = Motion(model, start)
    every = _step_between_samples(periods)
    while motion.periods < periods and motion.stopped is None:
        done = motion.periods
        states = motion.go_on(min(PERIODS, periods - done))
        if len(states):
            emit({**_piece(model, states, done, every), "done": False})
    emit({"t": [], "states": {}, "sections": None, "done": True, **_verdict(motion)})


def _step_between_samples(periods: int) -> int:
    """Return how many samples make one drawn instant; a divisor of the samples a period."""
    wanted = max(DRAWN / periods, 4)
    return next(step for step in (1, 2, 4, 8, 16) if SAMPLES / step <= wanted or step == 16)


def _piece(model: Model, starts: Array, done: int, every: int) -> dict[str, Any]:
    flow = flow_of(model)
    constants = flow.constants_of(model)
    count = len(starts)
    begin = np.zeros(count)
    samples = flow.sample(starts, begin, begin + 1.0, SAMPLES, constants)
    phases = np.tile(np.arange(SAMPLES) / SAMPLES, count)
    values = flow.outputs(samples.reshape(-1, flow.dimension), phases, constants)
    numbers = done + np.arange(count)
    time = (numbers[:, None] + phases.reshape(count, -1)) * constants.period
    drawn = samples[:, ::every].reshape(-1, flow.dimension)
    return {
        "t": short(time[:, ::every].ravel()),
        "states": {item.name: short(drawn[:, i]) for i, item in enumerate(model.states)},
        "sections": {
            "period": numbers.tolist(),
            "duration": constants.period,
            "start": {item.name: short(starts[:, i]) for i, item in enumerate(model.states)},
            **_extrema(flow, values.reshape(count, SAMPLES, -1)),
        },
    }


def _extrema(flow: Flow, values: Array) -> dict[str, dict[str, list[float]]]:
    low, high = values.min(axis=1), values.max(axis=1)
    return {
        "max": {name: short(high[:, i]) for i, name in enumerate(flow.output_names)},
        "min": {name: short(low[:, i]) for i, name in enumerate(flow.output_names)},
    }


def _verdict(motion: Motion) -> dict[str, Any]:
    judged = motion.settlement(TOLERANCE)
    stop = motion.stopped
    return {
        "verdict": judged.message if stop is None else stop.reason,
        "settled": judged.settled,
        "period": judged.period,
        "duration": judged.duration,
    }
