"""Where a model rests when its forcing is switched off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.evaluation import Evaluation, evaluation_of
from slipfold.models.model import Model

__all__ = ["find_static_point"]

ITERATIONS = 60
HALVINGS = 30

TOLERANCE = 1e-13
"""Newton step, relative to the states or their scales, at which only rounding is left."""


def find_static_point(model: Model) -> NDArray[np.float64]:
    """Find the static point that is reached from zero, with the forcing off.

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

    Notes
    -----
    Newton's method with step halving: a step is halved until the scaled rates shrink, which keeps
    the point on the side of zero that the structure itself would come to.

    Examples
    --------
    >>> from slipfold.models import SlidingOscillator
    >>> [round(float(value), 6) for value in find_static_point(SlidingOscillator())[:2]]
    [0.117403, 0.061107]
    """
    quiet = model if model.quiet is None else model.replace(**{model.quiet: 0.0})
    functions = evaluation_of(quiet)
    scales = quiet.state_scales()
    state = np.zeros(len(scales))
    for _ in range(ITERATIONS):
        step = _newton_step(functions, quiet, state)
        if step is None:
            break
        state = state + _shorten(functions, quiet, state, step, scales) * step
        if np.max(np.abs(step) / np.maximum(scales, np.abs(state))) <= TOLERANCE:
            return state
    raise InputError(
        f"no static point of {model!r} was found from zero; the static load is too large for the "
        "structure, lower it or stiffen the structure"
    )


def _newton_step(
    functions: Evaluation, model: Model, state: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    matrix = functions.jacobian(model, state)
    rates = functions.rates(model, state)
    if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(rates))):
        return None
    try:
        return np.asarray(-np.linalg.solve(matrix, rates), dtype=float)
    except np.linalg.LinAlgError:
        return None


def _shorten(
    functions: Evaluation,
    model: Model,
    state: NDArray[np.float64],
    step: NDArray[np.float64],
    scales: NDArray[np.float64],
) -> float:
    """Return the largest fraction 1, 1/2, 1/4 ... of the step that lessens the scaled rates."""
    before = np.linalg.norm(functions.rates(model, state) / scales)
    fraction = 1.0
    for _ in range(HALVINGS):
        after = np.linalg.norm(functions.rates(model, state + fraction * step) / scales)
        if after < before or np.max(np.abs(step) / np.maximum(scales, np.abs(state))) <= 1e-8:
            break
        fraction /= 2
    return fraction
