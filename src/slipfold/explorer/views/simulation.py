"""A motion in pieces, each told as soon as it is computed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.explorer.messages import SimulationRequest
from slipfold.explorer.start import start_of
from slipfold.explorer.views.numbers import short
from slipfold.flow import flow_of
from slipfold.flow.flow import Constants, Flow
from slipfold.flow.guarded_flow import CHUNK, Stop, guarded_flow_of
from slipfold.flow.settlement import judge_settlement
from slipfold.flow.simulate import initial_state
from slipfold.models.model import Model

__all__ = ["stream_simulation"]

Array = NDArray[np.float64]

PERIODS = 2 * CHUNK
"""Forcing periods in a piece: as the flow counts them, so that a motion is that of simulate."""

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

    Parameters
    ----------
    model
        The model.
    request
        Says where it starts and how long it lasts.
    emit
        Takes each piece: ``t`` in s and ``states`` by name to draw; ``sections``: for each forcing
        period its number, extrema and the states at its start; the last piece has ``done`` and the
        ``verdict``.
    """
    periods = request.periods
    state = initial_state(model, start_of(model, request))
    constants = flow_of(model).constants_of(model)
    every = _step_between_samples(periods)
    strobe = [state[None]]
    done, stop = 0, None
    while done < periods and stop is None:
        count = min(PERIODS, periods - done)
        states, stop = guarded_flow_of(model).strobe(strobe[-1][-1], count, constants)
        if len(states) > 1:
            emit({**_piece(model, states[:-1], done, every, constants), "done": False})
        strobe.append(states[1:])
        done += len(states) - 1
    emit({"t": [], "states": {}, "sections": None, "done": True, **_verdict(model, strobe, stop)})


def _step_between_samples(periods: int) -> int:
    """Return how many samples make one drawn instant; a divisor of the samples a period."""
    wanted = max(DRAWN / periods, 4)
    return next(step for step in (1, 2, 4, 8, 16) if SAMPLES / step <= wanted or step == 16)


def _piece(
    model: Model, starts: Array, done: int, every: int, constants: Constants
) -> dict[str, Any]:
    flow = flow_of(model)
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


def _verdict(model: Model, strobe: list[Array], stop: Stop | None) -> dict[str, Any]:
    if stop is not None:
        return {"verdict": stop.reason, "settled": False, "period": None}
    judged = judge_settlement(np.concatenate(strobe), model.state_scales(), TOLERANCE)
    return {"verdict": judged.message, "settled": judged.settled, "period": judged.period}
