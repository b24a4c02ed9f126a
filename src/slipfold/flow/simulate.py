"""Simulation, smooth or through stick and slip: a number of periods, or to a steady state."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.equations import Constants
from slipfold.flow.equilibrium import divided, paced
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import Stop
from slipfold.flow.integration import HybridIntegration, SmoothIntegration
from slipfold.flow.modes import contacts_of
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import Model
from slipfold.models.suggestion import unknown
from slipfold.progress import Observer


def simulate(
    model: Model,
    periods: int | None = None,
    state: ArrayLike | Mapping[str, float] | None = None,
    *,
    tolerance: float = 1e-9,
    observer: Observer | None = None,
    through_stick: bool = True,
) -> Trajectory:
    """Integrate a model, and say whether its trajectory has converged, and to what.

    Where a contact sticks or opens the trajectory continues, unless it is not to continue
    `through_stick`: then it ends there, as at other limits. If it is observed, an interrupted
    trajectory is returned as far as it came. Shapes: state (n_states,).

    >>> from slipfold.models.registry import model_named
    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> trajectory = simulate(SlidingOscillator(f=12.2, Nd=0.05), periods=1000)
    >>> trajectory.settlement.settled, trajectory.settlement.period
    (True, 1)
    >>> print(simulate(model_named("vanderpol-free")).settlement.kind)
    cycle
    """
    periods, tolerance = checked_periods(periods), checked_tolerance(tolerance)
    start = initial_state(model, state)
    if not through_stick or starts_in_slip(model, start):
        result = _simulate_in_slip(model, periods, start, tolerance, observer)
        if not (through_stick and reaches_stick_limit(result.stopped, model)):
            return result
    hybrid = HybridIntegration.begin(model, start, paced=periods is None)
    return hybrid.run(periods, tolerance, observer)


def _simulate_in_slip(
    model: Model, periods: int | None, start: Array, tolerance: float, observer: Observer | None
) -> Trajectory:
    if not model.forced:
        model, periods = paced(model, start, periods)
    for _ in range(5):  # intervals are divided where it becomes faster than it began
        result = SmoothIntegration(model, start).run(periods, tolerance, observer)
        if model.forced or result.stopped is None or result.stopped.kind != "stiff":
            break
        model, periods = divided(model, periods)
    return result


def initial_state(model: Model, state: ArrayLike | Mapping[str, float] | None) -> Array:
    """Check an initial state.

    Shapes: state (n_states,); returns (n_states,).

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> [float(value) for value in initial_state(SlidingOscillator(), {"y": 0.1})]
    [0.0, 0.1, 0.0, 0.0]
    """
    names = [item.name for item in model.states]
    if state is None:
        return model.start
    if isinstance(state, Mapping):
        for name in state:
            if name not in names:
                raise unknown(f"{model.name} has no state", name, names)
        own = dict(zip(names, model.start, strict=True))
        state = [state.get(name, own[name]) for name in names]
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


def checked_periods(periods: object) -> int | None:
    """Return a number of periods, or None for as many as it takes."""
    if periods is None:
        return None
    if isinstance(periods, (int, np.integer)) and not isinstance(periods, bool) and periods >= 1:
        return int(periods)
    raise InputError(f"periods = {periods!r} is not a whole number of at least 1; give one")


def checked_tolerance(tolerance: float) -> float:
    """Return a tolerance that is a positive number."""
    if math.isfinite(tolerance) and tolerance > 0:
        return tolerance
    raise InputError(f"tolerance = {tolerance!r} is not a positive number; give one like 1e-9")


def reaches_stick_limit(stopped: Stop | None, model: Model) -> bool:
    """Whether a trajectory ended where a contact may stick or open, and so continues."""
    beyond = {name for contact in contacts_of(model) for name in contact.limits}
    return stopped is not None and stopped.kind in beyond


def starts_in_slip(model: Model, start: Array) -> bool:
    """Whether no contact is at one of its limits. Shapes: start (n,)."""
    if not contacts_of(model):
        return True
    constants, starts = flow_of(model).constants_of(model), start[None]
    reached, bounds = _limits_at(model, starts, constants)
    return limits_are_defined(model, starts, constants) and bool(np.all(reached > bounds))


def limits_are_defined(model: Model, starts: Array, constants: Constants) -> bool:
    """Whether trajectories in slip tell where their contacts come to their limits.

    Over the speed of a floor at rest slip is infinite, and no limit can be followed. Shapes: starts
    (m, n); constants of the model or of m like it.
    """
    contacts = contacts_of(model)
    if not contacts:
        return True
    return all(contact.limits for contact in contacts) and bool(
        np.isfinite(_limits_at(model, starts, constants)[0]).all()
    )


def _limits_at(model: Model, starts: Array, constants: Constants) -> tuple[Array, Array]:
    """Return what limits of contacts watch, shape (m, l), and their bounds, shape (l,)."""
    beyond = {name for contact in contacts_of(model) for name in contact.limits}
    flow = flow_of(model)
    values = flow.outputs(starts, np.zeros(len(starts)), constants)
    watched = [item for item in model.limits if item.name in beyond]
    reached = values[:, [flow.output_index(item.output) for item in watched]]
    return reached, np.array([item.bound for item in watched])
