"""An equilibrium of an autonomous model: from its start, else from around it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.models.damped_newton import ITERATIONS, ROUNDING, TOLERANCE, damped_newton
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model

__all__ = ["search_equilibrium"]

Array = NDArray[np.float64]

REACHES = (0.1, 1.0, 10.0, 100.0)
"""How far around the start is searched, in scaled states, one after the other."""

TRIES = 24
"""Starts within each of these distances."""

HALVINGS = 12
"""Times a step is halved before a start is given up: there are others."""


def search_equilibrium(model: Model, start: Array) -> Array | None:
    """Return an equilibrium near a state, None if there is none to be found.

    Newton's method may be stuck where it begins, as on the axis of a symmetry or at the top of a
    parabola, or run into a singularity. Then it is begun anew all around, at the same places
    every time: nearby first, and of what is found from one distance the nearest is taken.

    Shapes: start (n_states,).

    Examples
    --------
    >>> from slipfold.models import System
    >>> fold = System(parameters={"a": -1.0}, states={"x": "a + x^2"})
    >>> float(abs(search_equilibrium(fold, fold.start)[0]))
    1.0
    """
    functions, scales = evaluation_of(model), model.state_scales()
    found = damped_newton(
        lambda at: functions.rates(model, at),
        lambda at: functions.jacobian(model, at),
        start,
        scales,
    )
    if found is not None:
        return found
    around = np.random.default_rng(0)
    for reach in REACHES:
        places = start + reach * scales * around.uniform(-1.0, 1.0, (TRIES, len(start)))
        reached = [state for state in _newton(model, places) if _within_limits(model, state)]
        if reached:
            return min(reached, key=lambda at: float(np.abs((at - start) / scales).max()))
    return None


def _newton(model: Model, states: Array) -> Array:
    """Take Newton steps from many states at once, halved until rates shrink.

    Return the equilibria that were found, each in a row.
    """
    scales = model.state_scales()
    found = [states[:0]]
    for _ in range(ITERATIONS):
        rates, jacobians = _linear(model, states)
        usable = np.isfinite(rates).all(axis=1) & np.isfinite(jacobians).all(axis=(1, 2))
        states, rates, jacobians = states[usable], rates[usable], jacobians[usable]
        if not len(states):
            break
        steps = _solved(jacobians * scales / scales[:, None], -rates / scales) * scales
        lengths = np.abs(steps / np.maximum(scales, np.abs(states))).max(axis=1)
        shares = _shares(model, states, rates, np.where(lengths <= ROUNDING, 0.0, 1.0), steps)
        still = lengths <= TOLERANCE
        found.append(states[still] + steps[still])
        going = ~still & (shares > 0)
        states = states[going] + shares[going, None] * steps[going]
    return np.concatenate(found)


def _shares(model: Model, states: Array, rates: Array, first: Array, steps: Array) -> Array:
    """Return the largest of 1, 1/2, 1/4 ... of each step that lessens the scaled rates.

    Zero where none does; a step of rounding size, marked by zero, is taken whole.
    """
    scales = model.state_scales()
    before = np.linalg.norm(rates / scales, axis=1)
    shares = np.where(first > 0, first, 1.0)
    open_ = first > 0
    for _ in range(HALVINGS):
        if not open_.any():
            return shares
        tried, _ = _linear(model, states[open_] + shares[open_, None] * steps[open_])
        after = np.linalg.norm(tried / scales, axis=1)
        worse = ~(after < before[open_])
        places = np.flatnonzero(open_)
        shares[places[worse]] /= 2
        open_[places[~worse]] = False
    shares[open_] = 0.0
    return shares


def _linear(model: Model, states: Array) -> tuple[Array, Array]:
    return evaluation_of(model).linear(model, states, np.zeros(len(states)))


def _solved(matrices: Array, right: Array) -> Array:
    """Solve many systems; where one is singular, all of them in the sense of least squares."""
    try:
        return np.asarray(np.linalg.solve(matrices, right[..., None])[..., 0], dtype=float)
    except np.linalg.LinAlgError:
        return np.asarray((np.linalg.pinv(matrices) @ right[..., None])[..., 0], dtype=float)


def _within_limits(model: Model, state: Array) -> bool:
    functions = evaluation_of(model)
    values = dict(zip(functions.names, functions.outputs(model, state, np.zeros(())), strict=True))
    return all(values[limit.output] > limit.bound for limit in model.limits)
