"""All equilibria of an autonomous model in a box, stable or not."""

from __future__ import annotations

import numpy as np

from slipfold.arrays import Array
from slipfold.models.equilibria import damped_newton
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model
from slipfold.models.turns import without_turns

ONE = 1e-8
"""Distance, in scaled states, of two equilibria that are one."""

HALVINGS = 12
"""Times a step is halved before a start is given up: there are others."""


def equilibria_in(model: Model, starts: Array) -> list[Array]:
    """Return what Newton's method finds from many starts, each equilibrium once.

    One at which a limit of the model is passed is none. Shapes: starts (k, n).
    """
    functions, scales = evaluation_of(model), model.state_scales()
    states = damped_newton(functions.linear_of(model), starts, scales, HALVINGS)
    found: list[Array] = []
    for state in states[np.isfinite(states).all(axis=1)]:
        values = dict(
            zip(functions.names, functions.outputs(model, state, np.zeros(())), strict=True)
        )
        if any(not values[limit.output] > limit.bound for limit in model.limits):
            continue
        reduced = without_turns(state, model.whole_turns)
        apart = [without_turns(reduced - other, model.whole_turns) / scales for other in found]
        if all(np.abs(each).max() > ONE for each in apart):
            found.append(reduced)
    return found
