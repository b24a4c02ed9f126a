"""Where a model rests when its forcing is switched off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.damped_newton import damped_newton
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model

__all__ = ["find_static_point"]

Array = NDArray[np.float64]

ROUNDING = 1e-12
"""A static point smaller than this, in scaled states, may be zero but for rounding."""


def find_static_point(model: Model) -> NDArray[np.float64]:
    """Find the static point that is reached from the model's start, with the forcing off.

    Returns shape (n_states,).

    Examples
    --------
    >>> from slipfold.models import SlidingOscillator
    >>> [round(float(value), 6) for value in find_static_point(SlidingOscillator())[:2]]
    [0.117403, 0.061107]
    """
    quiet = model if model.quiet is None else model.replace(**{model.quiet: 0.0})
    functions = evaluation_of(quiet)
    scales = quiet.state_scales()

    def found_from(start: Array, scales: Array) -> Array | None:
        return damped_newton(
            lambda state: functions.rates(quiet, state),
            lambda state: functions.jacobian(quiet, state),
            start,
            scales,
        )

    state = found_from(quiet.start, scales)
    size = 0.0 if state is None else float(np.max(np.abs(state) / scales))
    if state is not None and ROUNDING < size < 1:  # it may be known to few digits yet
        finer = found_from(state, size * scales)
        state = state if finer is None else finer
    if state is None:
        raise InputError(
            f"no static point of {model!r} was found from zero; the static load is too large for "
            "the structure, lower it or stiffen the structure"
        )
    return state
