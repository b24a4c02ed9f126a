"""Simulation: thousands of forcing periods from rest or from any state."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.errors import InputError
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import Stop, guarded_flow_of
from slipfold.flow.settlement import Settlement, judge_settlement
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import Model
from slipfold.models.suggestion import suggest

__all__ = ["initial_state", "simulate"]


def simulate(
    model: Model,
    periods: int = 1000,
    state: ArrayLike | Mapping[str, float] | None = None,
    *,
    tolerance: float = 1e-9,
) -> Trajectory:
    """Integrate a model over forcing periods, and say whether it has settled.

    Parameters
    ----------
    model
        The model with its parameter values.
    periods
        Forcing periods to integrate.
    state
        Initial state at phase zero, shape (n_states,), or some states by name; zero if None.
    tolerance
        Distance from a periodic response at which the motion counts as settled, in scaled states.

    Returns
    -------
    Trajectory
        Ends early, with the reason, where the model meets one of its limits.

    Raises
    ------
    InputError
        If `periods`, `state` or `tolerance` cannot be used.

    Examples
    --------
    >>> from slipfold.models import SlidingOscillator
    >>> trajectory = simulate(SlidingOscillator(f=12.2, Nd=0.05), periods=1000)
    >>> trajectory.settlement.settled, trajectory.settlement.period
    (True, 1)
    """
    count = _whole_number(periods)
    if not (math.isfinite(tolerance) and tolerance > 0):
        raise InputError(f"tolerance = {tolerance!r} is not a positive number; give one like 1e-9")
    start = initial_state(model, state)
    constants = flow_of(model).constants_of(model)
    strobe, stop = guarded_flow_of(model).strobe(start, count, constants)
    strobe.setflags(write=False)
    if stop is None:
        settlement = judge_settlement(strobe, model.state_scales(), tolerance)
    else:
        settlement = _cut_short(stop)
    return Trajectory(model, strobe, settlement, stop)


def initial_state(
    model: Model, state: ArrayLike | Mapping[str, float] | None
) -> NDArray[np.float64]:
    """Check an initial state.

    Parameters
    ----------
    model
        Gives the names of the states.
    state
        Shape (n_states,), or some states by name; zero if None.

    Returns
    -------
    ndarray, shape (n_states,)
        States.

    Raises
    ------
    InputError
        For a wrong number of values, an unknown name, or a value that is not a finite number.

    Examples
    --------
    >>> from slipfold.models import SlidingOscillator
    >>> [float(value) for value in initial_state(SlidingOscillator(), {"y": 0.1})]
    [0.0, 0.1, 0.0, 0.0]
    """
    names = [item.name for item in model.states]
    if state is None:
        return np.zeros(len(names))
    if isinstance(state, Mapping):
        for name in state:
            if name not in names:
                raise InputError(
                    f"{model.name} has no state {name!r}; {suggest(str(name), names)}"
                    f"it has {', '.join(names)}"
                )
        state = [state.get(name, 0.0) for name in names]
    try:
        values = np.array(state, dtype=float)
    except (TypeError, ValueError):
        raise InputError(
            f"the state {state!r} is not a list of numbers; give {', '.join(names)}"
        ) from None
    if values.shape != (len(names),):
        raise InputError(
            f"the state has the shape {values.shape}; give {len(names)} numbers: {', '.join(names)}"
        )
    for name, value in zip(names, values, strict=True):
        if not math.isfinite(value):
            raise InputError(f"the state {name} = {value} is not a finite number; give one")
    return values


def _whole_number(periods: object) -> int:
    if isinstance(periods, (int, np.integer)) and not isinstance(periods, bool) and periods >= 1:
        return int(periods)
    raise InputError(f"periods = {periods!r} is not a whole number of at least 1; give one")


def _cut_short(stop: Stop) -> Settlement:
    return Settlement(
        False, None, math.nan, None, f"not settled: ended after {stop.time:.6g} s, {stop.reason}"
    )
