"""Where a model rests when its forcing is switched off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.damped_newton import damped_newton
from slipfold.models.evaluation import evaluation_of
from slipfold.models.followed import check_followed
from slipfold.models.model import Model

ROUNDING = 1e-12
"""A static point smaller than this, in scaled states, may be zero but for rounding."""


def find_static_point(model: Model) -> NDArray[np.float64]:
    """Find the static point that is reached from the model's start, with the forcing off.

    Returns shape (n_states,).

    >>> from slipfold.models import SlidingOscillator
    >>> [round(float(value), 6) for value in find_static_point(SlidingOscillator())[:2]]
    [0.117403, 0.061107]
    """
    check_followed(model)
    quiet = model if model.quiet is None else model.replace(**{model.quiet: 0.0})
    functions = evaluation_of(quiet)
    scales = quiet.state_scales()

    linear = functions.linear_of(quiet)
    state = damped_newton(linear, quiet.start[None], scales)[0]
    size = float(np.max(np.abs(state) / scales))
    if ROUNDING < size < 1:  # it may be known to few digits yet
        finer = damped_newton(linear, state[None], size * scales)[0]
        state = state if np.isnan(finer).any() else finer
    if np.isnan(state).any():
        raise InputError(
            f"no static point of {model!r} was found from zero; the static load is too large for "
            "the structure, lower it or stiffen the structure"
        )
    return state
