"""What stays on the unit circle from one point of a branch to another, and is left out of tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.continuation.locate import locate
from slipfold.continuation.search import Zeros, slope_at
from slipfold.continuation.traced_curve import Found
from slipfold.orbits.bifurcation_types import PAIRED
from slipfold.orbits.kinds import Equilibria
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.test_functions import (
    ALIKE,
    Standing,
    collision,
    evaluate_tests,
    reciprocal_sums,
)
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


@dataclass(frozen=True, eq=False)
class Collision(Found[OrbitPoint]):
    """Where two pairs of multipliers meet on the unit circle and leave it, or come onto it."""

    smooth_slope: float = np.nan  # of the function whose derivative by the matrix is known

    @staticmethod
    def test(multipliers: Complex) -> float:
        r"""Return the discriminant of the sums :math:`\mu + 1/\mu`, each factor over its size.

        Where these are real, pairs are on the circle; conjugate ones are of four multipliers that
        left it. The discriminant is smooth, and changes its sign where one becomes the other.
        Shapes: multipliers (n,).
        """
        sums = reciprocal_sums(multipliers)
        first, second = np.triu_indices(len(sums), k=1)
        sizes = np.abs(sums - 2) ** 2
        with np.errstate(divide="ignore", invalid="ignore"):
            factors = (sums[first] - sums[second]) ** 2 / (sizes[first] + sizes[second])
        return float(np.prod(factors).real)

    @staticmethod
    def meeting(multipliers: Complex) -> complex:
        """Return what two sums nearest to each other meet at. Shapes: multipliers (n,)."""
        sums = reciprocal_sums(multipliers)
        first, second = np.triu_indices(len(sums), k=1)
        nearest = np.abs(sums[first] - sums[second]).argmin()
        return complex(sums[first[nearest]] + sums[second[nearest]]) / 2

    @property
    def rounding(self) -> float:
        """What rounding of the matrix and of its eigenvalues does to the test."""
        matrix, known = self.point.monodromy, collision(self.point.monodromy)
        sizes = np.linalg.norm(known.left, axis=1) * np.linalg.norm(known.right, axis=1)
        error = len(matrix) * np.finfo(float).eps * np.linalg.norm(matrix) * sizes.sum()
        return float(error * abs(self.slope / self.smooth_slope))


class Collisions(Zeros[OrbitPoint]):
    """Finds where pairs of multipliers collide that nothing keeps off the unit circle.

    The product of two of them shows none: it is one before and after, as in reversible systems.
    """

    def values(self, point: OrbitPoint) -> Array:
        """Return the discriminant at a point."""
        return np.array([Collision.test(point.multipliers)])

    def extrapolated(self, points: Sequence[OrbitPoint], weights: Array) -> None:
        """Return None: multipliers are known at the points alone."""

    def located(
        self, known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint
    ) -> list[Found[OrbitPoint]]:
        """Return the collision between two points, if there is one on the circle."""

        def test(point: OrbitPoint) -> float:
            return Collision.test(point.multipliers)

        counts = {len(reciprocal_sums(point.multipliers)) for point in (a, b)}
        if len(counts) > 1 or not test(a) * test(b) < 0:
            return []
        point = locate(self.curve, known, a, b, test)
        if abs(Collision.meeting(point.multipliers).real) >= 2:
            return []
        pair = next(name for name in PAIRED if name in point.tests)
        slope, smooth = (slope_at(each, known, point, a, b) for each in (test, _smooth))
        return [Collision(pair, point, slope, smooth_slope=smooth)]


def _smooth(point: OrbitPoint) -> float:
    return collision(point.monodromy).value


def collisions(
    known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint, orbits: Orbits
) -> list[Found[OrbitPoint]]:
    """Return the collisions of pairs between two points of a branch."""
    small = (abs(point.tests.get(name, 1.0)) < ALIKE for name in PAIRED for point in (a, b))
    if sum(small) < 2:
        return []
    # Damping that is more than rounding keeps multipliers off the places of pairs.
    sums = (reciprocal_sums(point.multipliers, rounding(point)) for point in (a, b))
    if min(map(len, sums)) < 2:
        return []
    # Of another search there may be points between, also where functions are interpolated.
    around = [item for item in known if not a.arclength < item.arclength < b.arclength]
    return Collisions(orbits).search(around, a, b)
