"""Views of the end of a simulation: over time, as a Poincare section, as a spectrum."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from slipfold.flow.flow import flow_of
from slipfold.flow.trajectory import Trajectory
from slipfold.interface.explorer.messages import MotionRequest
from slipfold.interface.explorer.plain import Check, Emit, axis_of, number, short
from slipfold.interface.explorer.settings import PAGE
from slipfold.interface.explorer.trajectories import (
    Kept,
    finite_columns,
    solution_of,
    spectrum_view,
)
from slipfold.long_term.spectrum import Spectrum, find_spectrum
from slipfold.models.model import Model

ROUNDS = 2
"""Responses that are shown of a motion that repeats: one alone does not show that it does."""

OPEN = 32
"""Forcing periods that are shown of another motion."""

LEVEL = 1e-9
"""Mean over the range below which a motion is about zero: the rest is rounding."""


def send_motion(model: Model, request: MotionRequest, emit: Emit, check: Check, kept: Kept) -> None:
    """Send views of the end of a simulation; what has no value in places is left out."""
    for name in request.outputs:
        axis_of(model, name)  # before what takes time
    trajectory = solution_of(model, request, emit, check, kept)
    if trajectory.periods == 0:
        emit({"empty": True})
        return
    period, settlement = period_of(trajectory), trajectory.settlement
    response = (settlement.period or 1) * period
    emit(
        {
            **_window(trajectory, request, period),
            "section": _section(trajectory, request.outputs),
            "spectrum": spectrum_view(
                steady_spectrum(trajectory),
                PAGE.orders * intervals_in(trajectory),
                request.outputs,
            ),
            "forcing": 1 / period if model.forced else None,
            "frequency": number(1 / response) if repeated(trajectory) else None,
            "settled": settlement.settled,
        }
    )


def period_of(trajectory: Trajectory) -> float:
    """Return the forcing period, the round of a cycle, or the interval of another motion, in s."""
    return float(flow_of(trajectory.model).constants_of(trajectory.steady_model).period)


def repeated(trajectory: Trajectory) -> bool:
    """Whether a trajectory ends on a response or a cycle."""
    settlement = trajectory.settlement
    return settlement.settled and bool(trajectory.model.forced or settlement.duration)


def _window(trajectory: Trajectory, request: MotionRequest, period: float) -> dict[str, Any]:
    """Return outputs over the last periods, or over rounds of a cycle."""
    settlement = trajectory.settlement
    usual = ROUNDS * (settlement.period or 1) if settlement.settled else OPEN
    count = trajectory.steady_periods(min(request.window or usual, PAGE.window))
    if settlement.duration is None:
        count = min(count, trajectory.periods)
    wanted = 4 * PAGE.samples * intervals_in(trajectory)
    each = max(min(wanted, PAGE.max_samples // count), PAGE.least_samples)
    values = trajectory.steady_outputs(count, each)
    return {
        "periods": count,
        "duration": count * period,
        "columns": finite_columns(trajectory.model, values, request.outputs),
    }


def intervals_in(trajectory: Trajectory) -> int:
    """Return the intervals of its own duration that a round of a cycle takes, else 1.

    A round may hold many oscillations, as where several masses stick and slip.
    """
    duration = trajectory.settlement.duration
    return 1 if duration is None else max(math.ceil(duration / trajectory.forcing_period), 1)


def steady_spectrum(trajectory: Trajectory) -> Spectrum:
    """Return the spectrum of one response, or of many periods of what does not repeat."""
    if trajectory.settlement.settled:
        fine = min(PAGE.samples * intervals_in(trajectory), PAGE.max_samples)
        return find_spectrum(trajectory, trajectory.settlement.period or 1, fine)
    periods = PAGE.window // (1 if trajectory.sticking is None else 4)
    return find_spectrum(trajectory, periods, PAGE.samples, tapered=True)


def _section(trajectory: Trajectory, names: tuple[str, ...]) -> dict[str, Any]:
    """Return outputs at phase zero, or where the first one passes its mean upwards."""
    flow, settlement = flow_of(trajectory.model), trajectory.settlement
    # Of one that has settled, what it settled on: the rest is what is left of the way there.
    most = PAGE.section if settlement.period is None else settlement.period
    kept = min(max(trajectory.periods // 2, 1), most)
    if trajectory.model.forced:
        states = trajectory.states[-kept:]
        constants = flow.constants_of(trajectory.model)
        values = flow.outputs(states, np.zeros(len(states)), constants)
        return {"level": None, "columns": finite_columns(trajectory.model, values, names)}
    settled = trajectory.settlement.settled
    each = PAGE.samples * intervals_in(trajectory)
    samples = trajectory.steady_outputs(ROUNDS + 1 if settled else min(kept, PAGE.window), each)
    first = samples[:, flow.output_index(names[0])]
    level = float(first.mean())
    if abs(level) < LEVEL * float(np.ptp(first)):
        level = 0.0
    columns = finite_columns(trajectory.model, samples, names)
    return {"level": number(level), "columns": _passed(columns, level)}


def _passed(columns: dict[str, list[float]], level: float) -> dict[str, list[float]]:
    """Return values where the first column passes a level upwards, by splines through samples."""
    from scipy.interpolate import CubicSpline  # takes half a second to import

    splines = {name: CubicSpline(range(len(c)), c) for name, c in columns.items()}
    if not splines or not np.isfinite(level):
        return {}
    first = next(iter(splines.values()))
    passed = first.solve(level, extrapolate=False)
    upward = passed[first(passed, 1) > 0]
    return {name: short(spline(upward)) for name, spline in splines.items()}
