"""An equilibrium of an autonomous model: from its start, else from around it."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.models.damped_newton import damped_newton
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model
from slipfold.models.turns import without_turns

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

    >>> from slipfold.models import System
    >>> fold = System(parameters={"a": -1.0}, states={"x": "a + x^2"})
    >>> float(abs(search_equilibrium(fold, fold.start)[0]))
    1.0
    """
    linear, scales = evaluation_of(model).linear_of(model), model.state_scales()
    found = damped_newton(linear, start[None], scales)[0]
    if not np.isnan(found).any():
        return without_turns(found, model.whole_turns)
    around = np.random.default_rng(0)
    for reach in REACHES:
        places = start + reach * scales * around.uniform(-1.0, 1.0, (TRIES, len(start)))
        states = damped_newton(linear, places, scales, HALVINGS)
        reached = [state for state in states if _within_limits(model, state)]
        if reached:
            nearest = min(reached, key=lambda at: float(np.abs((at - start) / scales).max()))
            return without_turns(nearest, model.whole_turns)
    return None


def _within_limits(model: Model, state: Array) -> bool:
    if np.isnan(state).any():
        return False
    functions = evaluation_of(model)
    values = dict(zip(functions.names, functions.outputs(model, state, np.zeros(())), strict=True))
    return all(values[limit.output] > limit.bound for limit in model.limits)
