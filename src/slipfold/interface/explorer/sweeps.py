"""Motions followed up and down a parameter, value by value as they are known."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slipfold.computations.arguments import equidistant
from slipfold.errors import InputError
from slipfold.flow.simulate import initial_state, simulate
from slipfold.flow.trajectory import Trajectory
from slipfold.interface.explorer.messages import SweepRequest
from slipfold.interface.explorer.motions import period_of
from slipfold.interface.explorer.plain import Check, Emit, axis_of, short
from slipfold.interface.explorer.sounds import SOUND, swept_clip, times_faster
from slipfold.interface.explorer.trajectories import start_of, timed
from slipfold.lines import parts_of
from slipfold.models.model import Model
from slipfold.progress import Progress

PARTS = (64, 128, 256)
"""Periods that a motion has to settle in, one number after the other until it has."""


def send_sweep(model: Model, request: SweepRequest, send: Emit, check: Check) -> None:
    """Follow a motion up the span, then down; send each value when it is known.

    A run ends where the motion meets a limit of the model. The run down begins from the last
    state of the run up, or both begin from one motion.
    """
    axis_of(model, request.show)  # before what takes time
    start = state = initial_state(model, start_of(model, request))
    model, ends, faster = swept_model(model, request), dict[str, str](), 0
    for run, values in values_of_runs(model, request).items():
        state = state if request.begin is None else start
        for value in values:
            known = _followed(model, {request.vary: float(value)}, state, check)
            if isinstance(known, str):
                ends[run] = known
                break
            state = known.states[-1]
            faster = faster or times_faster(1 / period_of(known))
            sound = swept_clip(known, request.heard or request.show, faster)
            send(
                {
                    "run": run,
                    "x": float(value),
                    "y": _shown(known, request),
                    "sound": {**sound, "rate": SOUND.swept_rate, "faster": faster},
                    "done": False,
                }
            )
    send({"ends": ends, "done": True})


def values_of_runs(model: Model, request: SweepRequest) -> dict[str, NDArray[np.float64]]:
    """Return the values of each run in order: of the span, or from one of them to its ends."""
    values = equidistant(model.variable_parameter(request.vary), request.span, request.points)
    ways = {"up": values, "down": values[::-1]}
    if request.begin is not None:
        begin, width = request.begin, values[-1] - values[0]
        for run, end in (("up", values[-1]), ("down", values[0])):
            count = math.ceil(request.points * min(abs(end - begin) / width, 1.0))
            ways[run] = np.linspace(begin, end, max(count, 1))
    return {run: ways[run] for run in request.runs}


def swept_model(model: Model, request: SweepRequest) -> Model:
    """Return the model; if autonomous, with the interval that suits where a sweep begins."""
    if model.forced:
        return model
    first = min(request.span) if request.begin is None else request.begin
    return timed(model.replace(**{request.vary: first}), request)


def _followed(
    model: Model, changes: dict[str, float], state: NDArray[np.float64], check: Check
) -> Trajectory | str:
    """Return the end of the motion at one value, or why there is none. Shapes: state (n,)."""

    def watch(progress: Progress) -> None:
        check()

    for periods in PARTS:
        try:
            result = simulate(model.replace(**changes), periods, state, observer=watch)
        except InputError as error:
            return str(error)
        if result.stopped is not None:
            return result.stopped.reason
        if result.settlement.settled:
            break
        state = result.states[-1]
    return result


def _shown(trajectory: Trajectory, request: SweepRequest) -> list[float]:
    """Return extrema of an output in the last periods, each that differs where it is drawn once."""
    parts = [trajectory.extrema(request.show, part) for part in parts_of(request.statistic)]
    return [float(value) for value in np.unique(short(np.concatenate(parts)))]
