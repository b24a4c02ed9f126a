"""Where a model rests when its forcing is switched off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.damped_newton import damped_newton
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model

__all__ = ["find_static_point"]


def find_static_point(model: Model) -> NDArray[np.float64]:
    """Find the static point that is reached from the model's start, with the forcing off.

    Parameters
    ----------
    model
        Its parameter named by `quiet` is set to zero.

    Returns
    -------
    ndarray, shape (n_states,)
        The state at which all rates vanish.

    Raises
    ------
    InputError
        If Newton's method finds none.

    Examples
    --------
    >>> from slipfold.models import SlidingOscillator
    >>> [round(float(value), 6) for value in find_static_point(SlidingOscillator())[:2]]
    [0.117403, 0.061107]
    """
    quiet = model if model.quiet is None else model.replace(**{model.quiet: 0.0})
    functions = evaluation_of(quiet)
    scales = quiet.state_scales()
    state = damped_newton(
        lambda state: functions.rates(quiet, state),
        lambda state: functions.jacobian(quiet, state),
        quiet.start,
        scales,
    )
    if state is None:
        raise InputError(
            f"no static point of {model!r} was found from zero; the static load is too large for "
            "the structure, lower it or stiffen the structure"
        )
    return state
