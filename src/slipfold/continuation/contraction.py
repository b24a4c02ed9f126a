"""Stretches of a branch on which no bifurcation is possible, whatever the multipliers' phases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipfold.continuation.interpolation import lagrange
from slipfold.continuation.point import Point

SHARE = 0.5
"""Share of its distance from zero by which the bound of the multipliers may change in one step."""


def contracts_between(a: Point, b: Point) -> bool:
    """Whether perturbations shrink on all orbits between two points, so that nothing happens.

    They do at both, and the bound of the multipliers changes by less from one to the other than
    by what it lies below zero.
    """
    least = max(a.growth, b.growth)
    if not -np.inf < min(a.growth, b.growth) <= least < 0:
        return False
    same = all((a.tests[name] > 0) == (b.tests[name] > 0) for name in a.tests)
    return same and a.orientation == b.orientation and abs(a.growth - b.growth) <= SHARE * -least


def contraction_drift(recent: Sequence[Point], point: Point) -> float:
    """Return how badly the bound of the multipliers was foreseen, relative to what is allowed.

    Multipliers turn with the forcing frequency, and test functions with them, also where nothing
    can happen; what could is limited by the bound, which does not turn. Infinite where the bound
    does not exclude bifurcations.
    """
    if not contracts_between(recent[-1], point):
        return np.inf
    if not all(np.isfinite(item.growth) for item in recent):
        return 0.0
    weights = lagrange([item.arclength for item in recent], point.arclength)
    expected = float(weights @ [item.growth for item in recent])
    allowed = SHARE * min(-recent[-1].growth, -point.growth)
    change = max(abs(point.growth - expected), abs(point.growth - recent[-1].growth))
    return float(change / allowed)
