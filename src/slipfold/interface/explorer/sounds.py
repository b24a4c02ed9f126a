"""Vibrations as sound: samples at the rate of a loudspeaker, low motions faster than they are."""

from __future__ import annotations

import base64
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.flow.flow import flow_of
from slipfold.flow.trajectory import Trajectory
from slipfold.interface.explorer.messages import SoundRequest
from slipfold.interface.explorer.motions import period_of, repeated, steady_spectrum
from slipfold.interface.explorer.plain import Check, Emit, axis_of
from slipfold.interface.explorer.trajectories import Kept, solution_of
from slipfold.models.model import Model


class SOUND:
    """What is heard of a motion."""

    rate: float = 44_100.0  # samples a second, about; a motion has a whole number a period
    lowest: float = 40.0  # Hz below which little is heard, and nothing of a small loudspeaker
    heard: float = 80.0  # Hz at least to which whole octaves raise what is lower
    seconds: float = 3.0  # that a motion is heard which does not repeat
    piece: int = 16  # periods sampled together: more outputs than the one heard are computed
    least: int = 8  # samples a period at least
    # Of a sweep, which has hundreds of values: samples a second, and seconds each
    swept_rate: float = 22_050.0
    swept_seconds: float = 0.04


def send_sound(model: Model, request: SoundRequest, emit: Emit, check: Check, kept: Kept) -> None:
    """Send the end of a simulation as sound: one response to be repeated, or some seconds."""
    axis_of(model, request.output)  # before what takes time
    trajectory = solution_of(model, request, emit, check, kept)
    settlement = trajectory.settlement
    repeats = repeated(trajectory)
    if trajectory.periods == 0 or (settlement.settled and not repeats):
        emit({"silent": True})  # it ended at once, or on an equilibrium
        return
    period = period_of(trajectory)
    frequency = _frequency(trajectory, request.output)
    faster = times_faster(frequency)
    each = max(round(SOUND.rate * period / faster), SOUND.least)
    if repeats:
        values = _steady(trajectory, request.output, settlement.period or 1, each)
    else:
        count = min(trajectory.periods, math.ceil(SOUND.seconds * faster / period))
        values = _last(trajectory, request.output, count, each, check)
    samples = encoded(values)
    emit(
        {
            "silent": samples["size"] == 0,
            **samples,
            "rate": each * faster / period,
            "faster": faster,
            "frequency": frequency,
            "repeats": repeats,
        }
    )


def times_faster(frequency: float) -> int:
    """Return a power of two that raises a frequency in Hz to where it is heard.

    >>> times_faster(440.0), times_faster(12.5), times_faster(0.19)
    (1, 8, 512)
    """
    if frequency >= SOUND.lowest or not frequency > 0:
        return 1
    return int(2 ** math.ceil(math.log2(SOUND.heard / frequency)))


def encoded(values: NDArray[np.float64]) -> dict[str, Any]:
    """Return 16-bit samples about their mean, little-endian in base 64, with their largest.

    Shapes: values (m,).

    >>> encoded(np.array([1.0, 3.0]))
    {'samples': 'AYD/fw==', 'size': 1.0}
    """
    moving = values - values.mean()
    size = float(np.abs(moving).max())
    # What stands still but for rounding is silent.
    if not np.isfinite(size) or size <= 1e-9 * float(np.abs(values).max()):
        return {"samples": "", "size": 0.0}
    whole = np.round(moving / size * 32767).astype("<i2")
    return {"samples": base64.b64encode(whole.tobytes()).decode(), "size": size}


def swept_clip(trajectory: Trajectory, output: str, faster: int) -> dict[str, Any]:
    """Return whole periods of the end of a trajectory, for some hundredths of a second."""
    period = period_of(trajectory)
    each = max(round(SOUND.swept_rate * period / faster), SOUND.least)
    wanted = max(round(SOUND.swept_seconds * faster / period), 1)
    if trajectory.settlement.settled:
        values = _steady(trajectory, output, wanted, each)
    else:
        values = _last(trajectory, output, min(wanted, trajectory.periods), each, lambda: None)
    return encoded(values)


def _steady(trajectory: Trajectory, output: str, periods: int, each: int) -> NDArray[np.float64]:
    column = flow_of(trajectory.model).output_index(output)
    return trajectory.steady_outputs(periods, each)[:, column]


def _last(
    trajectory: Trajectory, output: str, count: int, each: int, check: Check
) -> NDArray[np.float64]:
    column = flow_of(trajectory.model).output_index(output)
    pieces = []
    for first in range(trajectory.periods - count, trajectory.periods, SOUND.piece):
        check()
        last = min(first + SOUND.piece, trajectory.periods)
        pieces.append(trajectory.sampled(first, last, each)[1].outputs()[:, column])
    return np.concatenate(pieces)


def _frequency(trajectory: Trajectory, output: str) -> float:
    """Return what is heard as the pitch: the response, or the highest line where nothing forces."""
    if trajectory.model.forced:
        return 1 / ((trajectory.settlement.period or 1) * period_of(trajectory))
    spectrum = steady_spectrum(trajectory)
    lines = np.nan_to_num(spectrum.of(output)[1:])
    return float(spectrum.frequency[1 + int(np.argmax(lines))])
