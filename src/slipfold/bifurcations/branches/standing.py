"""What stays on the unit circle from one point of a branch to another, and is left out of tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slipfold.orbits.kinds import Equilibria
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.test_functions import ALIKE, Standing, evaluate_tests
from slipfold.orbits.uncertainty import SPREAD
from slipfold.text import NEUTRAL


def rounding(point: OrbitPoint) -> float:
    """Return what rounding leaves of a test function: of equilibria, also that of derivatives."""
    orbits = point.curve.orbits
    own = SPREAD * orbits.rounding(point.z) if isinstance(orbits, Equilibria) else 0.0
    return max(NEUTRAL, own)


def standing_between(a: OrbitPoint, b: OrbitPoint) -> Standing | None:
    """Return the multipliers that are on the unit circle at two points, to rounding."""
    ends = a.multipliers, b.multipliers
    if any(np.abs(np.abs(values) - 1).min(initial=np.inf) > ALIKE for values in ends):
        return None
    return Standing.between(ends, max(map(rounding, (a, b))))


def counts(standing: Standing | None) -> tuple[int, int]:
    """Return how many multipliers stand, and how many at -1."""
    return (0, 0) if standing is None else (standing.turning.shape[1], standing.flipping.shape[1])


def seen_without(
    standing: Standing | None, orbits: Orbits, points: Sequence[OrbitPoint]
) -> tuple[Orbits, list[OrbitPoint]]:
    """Return orbits, and points, with test functions that leave out what stands.

    Points whose unknowns mean the same share a curve, as before.
    """
    curves = {id(each): each for each in (orbits, *(point.curve for point in points))}
    others = {key: each.leaving_out(standing) for key, each in curves.items()}
    seen = list[OrbitPoint]()
    for point in points:
        curve = others[id(point.curve)]
        tests = evaluate_tests(point.multipliers, curve.spectrum.tests, standing)
        seen.append(replace(point, curve=curve, tests={**point.tests, **tests}))
    return others[id(orbits)], seen
