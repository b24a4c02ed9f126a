"""Newton's method for many systems of equations at once, and the zero of one function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isnan

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Indices


@dataclass(frozen=True)
class Rule:
    """When Newton's method has converged, and when it has failed."""

    close: float  # a step shorter than this may be the last
    longest: float = np.inf  # a step this long leads to another solution, or to none
    growth: float = np.inf  # a step this many times the one before means divergence
    # Where derivatives are not renewed at each step: estimated distance to the solution after the
    # last one
    remaining: float = np.inf
    iterations: int = 8  # steps that may be taken


BEND = 100.0
"""Curvature, in scaled variables, that `Rule.remaining` reckons with after the first step."""


@dataclass(frozen=True, eq=False)
class Solved:
    """Results of Newton's method in each of k systems."""

    z: Array  # solutions, shape (k, u); NaN where there is none
    moved: Array  # length of the last step, shape (k,); infinite likewise
    failures: NDArray[np.str_]  # why there is none, shape (k,); empty where there is one

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether each has a solution, shape (k,)."""
        return np.asarray(self.failures == "")


@np.errstate(over="ignore", invalid="ignore")  # what overflows diverges
def correct_many(steps: Callable[[Indices, Array], Array], guesses: Array, rule: Rule) -> Solved:
    """Take Newton steps in many systems of equations until each has converged or failed.

    `steps` returns those of some systems, by number, from their unknowns; NaN where there is none.

    Shapes: guesses (k, u); steps (a,), (a, u) -> (a, u).
    """
    z, moved = guesses.copy(), np.full(len(guesses), np.inf)
    known = np.isfinite(z).all(axis=1)
    failures = np.where(known, f"no convergence in {rule.iterations} corrections", "no guess")
    active = np.flatnonzero(known)
    for _ in range(rule.iterations):
        if not len(active):
            break
        step = steps(active, z[active])
        length, before = np.linalg.norm(step, axis=1), moved[active]
        good = (length < rule.longest) & (length < rule.growth * before)
        z[active] += step
        moved[active] = length
        # The iteration contracts at least as it did last time; at first, as Newton's method does.
        rate = np.where(np.isinf(before), BEND * length, length / before)
        done = good & (length < rule.close) & (length * rate < rule.remaining)
        failures[active[~good]] = "Newton's method diverged"
        failures[active[done]] = ""
        active = active[good & ~done]
    lost = failures != ""
    z[lost], moved[lost] = np.nan, np.inf
    return Solved(z, moved, failures)


def solve_each(matrices: Array, right: Array) -> Array:
    """Solve linear systems; NaN where one has no solution.

    Shapes: matrices (k, u, u); right (k, u) or (k, u, r).
    """
    columns = right if right.ndim == 3 else right[..., None]
    try:
        return np.asarray(np.linalg.solve(matrices, columns), dtype=float).reshape(right.shape)
    except np.linalg.LinAlgError:
        # One singular matrix makes all of them fail: find out which.
        if len(matrices) == 1:
            return np.full_like(right, np.nan)
        half = len(matrices) // 2
        parts = [
            solve_each(matrices[part], right[part]) for part in (slice(half), slice(half, None))
        ]
        return np.concatenate(parts)


def find_root(step: Callable[[Array], Array], guess: Array, rule: Rule) -> Array | None:
    """Return the solution of one system near a guess; None where Newton's method finds none.

    `step` returns Newton's step, NaN where there is none. Shapes: guess, step (u,).
    """
    found = correct_many(lambda _, z: step(z[0])[None], guess[None], rule)
    return found.z[0] if found.found[0] else None


def zero_between(
    function: Callable[[float], float], low: float, high: float, close: float
) -> float:
    """Return the zero of a function that has different signs at two places, so far known."""
    from scipy.optimize import brentq  # a fifth of a second to import, and seldom needed

    def known(place: float) -> float:
        value = float(function(place))
        if isnan(value):
            raise ArithmeticError(f"a function with a zero is not known at {place:.9g}")
        return value

    try:
        return float(brentq(known, low, high, xtol=close))
    except ValueError as error:  # no longer of different signs
        raise ArithmeticError(str(error)) from None
