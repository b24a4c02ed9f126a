"""Newton's method with step halving, for rest points, from many starts at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from slipfold.arrays import Array

ITERATIONS = 60
HALVINGS = 30

TOLERANCE = 1e-13
"""Newton step, relative to the states or their scales, at which only rounding is left."""

ROUNDING = 1e-8
"""A step below this is taken whole: the rates may no longer shrink for rounding alone."""


def damped_newton(
    linear: Callable[[Array], tuple[Array, Array]],
    starts: Array,
    scales: Array,
    halvings: int = HALVINGS,
) -> Array:
    """Find states at which all rates vanish, going downhill from each start; NaN where none is.

    A step is halved until the scaled rates shrink, which keeps the search on the side of a
    singularity on which the structure itself would stay. `linear` gives rates and Jacobians.

    Shapes: linear (a, n) -> (a, n), (a, n, n); starts (k, n); scales (n,); returns (k, n).

    >>> import numpy as np
    >>> starts = np.array([[1.0], [-5.0]])
    >>> damped_newton(lambda x: (x**2 - 2, 2 * x[:, None]), starts, np.ones(1)).round(9).ravel()
    array([ 1.41421356, -1.41421356])
    """
    states, found = starts.copy(), np.full_like(starts, np.nan)
    active, before = np.arange(len(starts)), np.full(len(starts), np.inf)
    for _ in range(ITERATIONS):
        if not len(active):
            break
        at = states[active]
        rates, jacobians = linear(at)
        steps = _newton_steps(jacobians, rates)
        lengths = np.max(np.abs(steps) / np.maximum(scales, np.abs(at)), axis=1)
        shares = np.where(lengths <= ROUNDING, 1.0, 0.0)
        far = np.flatnonzero(lengths > ROUNDING)
        with np.errstate(over="ignore"):  # what is tried may be anywhere
            shares[far] = _shares(linear, at[far], rates[far], steps[far], scales, halvings)
        states[active] = at + shares[:, None] * steps
        # Beside fast modes rounding alone may make a longer step: then it does not shrink.
        done = (lengths <= TOLERANCE) | ((lengths <= ROUNDING) & (lengths > 0.5 * before[active]))
        before[active] = lengths
        found[active[done]] = states[active[done]]
        active = active[~done & (shares > 0)]
    return found


def _newton_steps(jacobians: Array, rates: Array) -> Array:
    """Return Newton's steps; none from a state of rest, be it singular; NaN where there is none."""
    steps = np.full_like(rates, np.nan)
    finite = np.isfinite(rates).all(axis=1) & np.isfinite(jacobians).all(axis=(1, 2))
    for i in np.flatnonzero(finite):
        if not rates[i].any():
            steps[i] = 0.0
            continue
        try:
            steps[i] = -np.linalg.solve(jacobians[i], rates[i])
        except np.linalg.LinAlgError:
            continue
    return steps


def _shares(
    linear: Callable[[Array], tuple[Array, Array]],
    states: Array,
    rates: Array,
    steps: Array,
    scales: Array,
    halvings: int,
) -> Array:
    """Return the largest of 1, 1/2, 1/4 ... of each step that lessens the scaled rates, else 0."""
    shares, before = np.zeros(len(states)), np.linalg.norm(rates / scales, axis=1)
    left, share = np.arange(len(states)), 1.0
    for _ in range(halvings):
        if not len(left):
            break
        tried = linear(states[left] + share * steps[left])[0]
        less = np.linalg.norm(tried / scales, axis=1) < before[left]
        shares[left[less]] = share
        left, share = left[~less], share / 2
    return shares
