"""Motions from many starts, each with parameters of its own, at the start of every period."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.guarded_flow import Stop
from slipfold.flow.sizes.typical_sizes import measured, measured_within
from slipfold.flow.strobes.crowd import Crowd
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress


@dataclass(frozen=True, eq=False)
class StrobePoints:
    """States of many motions at phase zero of each forcing period."""

    states: Array  # shape (k, periods + 1, n); NaN from where a motion stopped or was interrupted
    stopped: tuple[Stop | None, ...]  # why and when each motion ended early, length k
    # Whether a contact stuck or was open in the period before each point, shape (k, periods + 1)
    stuck: NDArray[np.bool_]
    interrupted: bool = False


def strobe_many(
    model: Model,
    starts: ArrayLike,
    values: Mapping[str, ArrayLike] | None = None,
    periods: int = 1000,
    observer: Observer | None = None,
    *,
    transient: int = 0,
    threads: int | None = None,
) -> StrobePoints:
    """Follow motions from many starts; each may have parameter values of its own.

    A motion that sticks goes on through stick by itself; one that meets another limit stops, and
    says why. The first point kept is that after `transient` periods. Of a model that nothing forces
    periods are intervals of its duration. If it is observed, an interruption keeps what is done.

    Shapes: starts (k, n); values (k,) each.

    >>> from slipfold.models import SlidingOscillator
    >>> points = strobe_many(SlidingOscillator(f=12.2), np.zeros((2, 4)), {"Nd": [0.05, 0.15]}, 400)
    >>> points.states.shape, points.stopped
    ((2, 401, 4), (None, None))
    >>> [bool(abs(states[-1] - states[-2]).max() < 1e-6) for states in points.states]
    [True, False]
    """
    states = _checked_starts(model, starts)
    models = models_with(model, len(states), values or {})
    found = StrobePoints(
        np.full((len(states), periods + 1, states.shape[1]), np.nan),
        (),
        np.zeros((len(states), periods + 1), bool),
    )
    total, interrupted = len(states) * (transient + periods), False
    with Crowd(models, states, threads) as crowd:
        try:
            for period in range(transient + periods + 1):
                if period:
                    crowd.go_on()
                    if observer is not None:
                        observer(Progress("forcing periods", period * len(states), total))
                if period >= transient:
                    found.states[:, period - transient] = crowd.states
                    found.stuck[:, period - transient] = crowd.stuck
        except KeyboardInterrupt:
            if observer is None:
                raise
            interrupted = True
        return StrobePoints(found.states, crowd.stopped, found.stuck, interrupted)


def models_with(model: Model, count: int, values: Mapping[str, ArrayLike]) -> list[Model]:
    """Return the model of each motion."""
    columns = {}
    for name, given in values.items():
        model.variable_parameter(name)
        column = np.asarray(given, dtype=float)
        if column.shape != (count,):
            raise InputError(
                f"the values of {name} have the shape {column.shape}; give one for each of the "
                f"{count} starts"
            )
        columns[name] = column
    ends = [
        {name: float(column[place]) for name, column in columns.items()}
        for place in (0, count // 2, count - 1)
    ]
    model = measured_within(model, ends) if columns else measured(model)
    if not columns:
        return [model] * count
    rows = zip(*columns.values(), strict=True)
    return [model.replace(**dict(zip(columns, map(float, row), strict=True))) for row in rows]


def _checked_starts(model: Model, starts: ArrayLike) -> Array:
    try:
        states = np.array(starts, dtype=float)
    except (TypeError, ValueError):
        states = np.empty(0)
    n = len(model.states)
    if states.ndim != 2 or states.shape[1] != n or not len(states):
        raise InputError(f"the starts have the shape {states.shape}; give (k, {n}) numbers")
    if not np.isfinite(states).all():
        raise InputError("the starts are not all finite numbers; give such")
    return states
