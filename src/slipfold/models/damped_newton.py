"""Newton's method with step halving, for rest points."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

__all__ = ["ITERATIONS", "ROUNDING", "TOLERANCE", "damped_newton"]

Array = NDArray[np.float64]

ITERATIONS = 60
HALVINGS = 30

TOLERANCE = 1e-13
"""Newton step, relative to the states or their scales, at which only rounding is left."""

ROUNDING = 1e-8
"""A step below this is taken whole: the rates may no longer shrink for rounding alone."""


def damped_newton(
    rates: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    start: Array,
    scales: Array,
) -> Array | None:
    """Find a state at which all rates vanish, going downhill from a start.

    A step is halved until the scaled rates shrink, which keeps the search on the side of a
    singularity on which the structure itself would stay.

    Shapes: rates (n,); jacobian (n, n); start, scales (n,); returns (n,).

    Examples
    --------
    >>> import numpy as np
    >>> one = np.ones(1)
    >>> float(damped_newton(lambda x: x**2 - 2, lambda x: np.diag(2 * x), one, one)[0])
    1.414213562373095
    """
    state = start
    for _ in range(ITERATIONS):
        matrix, found = jacobian(state), rates(state)
        if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(found))):
            return None
        if not found.any():  # a state of rest, be the derivatives singular there
            return state
        try:
            step = np.asarray(-np.linalg.solve(matrix, found), dtype=float)
        except np.linalg.LinAlgError:
            return None
        length = np.max(np.abs(step) / np.maximum(scales, np.abs(state)))
        state = (
            state + (1.0 if length <= ROUNDING else _fraction(rates, state, step, scales)) * step
        )
        if length <= TOLERANCE:
            return state
    return None


def _fraction(rates: Callable[[Array], Array], state: Array, step: Array, scales: Array) -> float:
    """Return the largest of 1, 1/2, 1/4 ... of the step that lessens the scaled rates."""
    before = np.linalg.norm(rates(state) / scales)
    fraction = 1.0
    for _ in range(HALVINGS):
        if np.linalg.norm(rates(state + fraction * step) / scales) < before:
            break
        fraction /= 2
    return fraction
