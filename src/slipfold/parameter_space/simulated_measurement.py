"""The measurements of a test rig: a parameter swept in steps, each to a steady state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.simulate import simulate
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import Model
from slipfold.orbits.extrema import steady_extrema
from slipfold.parameter_space.measurement import Measurement, Quantity, read_off
from slipfold.progress import Observer, Progress

EACH = 500
"""Forcing periods after which a trajectory is tested for a steady state."""

MAX_TESTS = 16
"""Maximum number of tests; then the trajectory is measured as it is."""


def swept(
    model: Model,
    vary: str,
    values: Sequence[float],
    ways: Sequence[str],
    quantities: tuple[Quantity, ...],
    errors: Array,
    seed: int,
    observer: Observer | None = None,
) -> Measurement:
    """Sweep a parameter through values in their order and measure the trajectory at each.

    Noise of standard deviations `errors` is added, one for each quantity; 0 adds none. Interrupted,
    or where the trajectory ends at a limit, it returns what was read. Shapes: errors (q,).
    """
    noise = np.random.default_rng(seed)
    state, rows, stopped = model.start, list[Array](), None
    try:
        for value in values:
            if observer is not None:
                observer(Progress("measurements", len(rows), len(values)))
            trajectory = _settled(model.replace(**{vary: value}), state)
            if trajectory.stopped is not None:
                stopped = (
                    f"the trajectory ends at {trajectory.model!r}: {trajectory.stopped.reason}"
                )
                break
            names = tuple(dict.fromkeys(item.output for item in quantities))
            rows.append(read_off(steady_extrema(trajectory, names), quantities)[0])
            state = trajectory.states[-1]
    except KeyboardInterrupt:
        if not rows:
            raise
    if not rows:
        raise InputError(
            f"{stopped}; nothing was measured, so begin within the limits of the model"
        )
    count = len(rows)
    measurements = np.array(rows) + noise.standard_normal((count, len(quantities))) * errors
    known = np.where(errors > 0, errors, np.nan)
    return Measurement(
        vary,
        model.parameter(vary).unit,
        np.array(values[:count], dtype=float),
        quantities,
        measurements,
        np.tile(known, (count, 1)),
        tuple(ways[:count]),
        stopped,
    )


def _settled(model: Model, state: Array) -> Trajectory:
    """Return the end of a trajectory near its steady state, or one that ended early."""
    for _ in range(MAX_TESTS):
        trajectory = simulate(model, EACH, state)
        if trajectory.stopped is not None and trajectory.stopped.kind == "interrupted":
            raise KeyboardInterrupt
        if trajectory.stopped is not None or trajectory.settlement.settled:
            break
        state = trajectory.states[-1]
    return trajectory
