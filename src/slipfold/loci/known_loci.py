"""Whether an orbit lies on a locus that has been followed already."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.closed_branches import asymmetry
from slipfold.continuation.interpolation import arc_between, hermite
from slipfold.continuation.newton import correct
from slipfold.loci.locus_equations import LocusEquations
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits

ABREAST = 0.02
"""Distance from the interpolated locus within which the locus itself is looked at."""

SAME_CRITICAL = 1e-4
"""Two critical orbits this close are one: beside multipliers of 1e4 they are known to 1e-6, and two
loci differ by more."""

SAMPLES = 16
"""Places between neighbouring points that are looked at first."""


def lies_on(points: Sequence[OrbitPoint], orbits: Orbits, z: Array) -> bool:
    """Whether an orbit, an unknown of some orbits, is one of a locus, or a later phase of one."""
    return any(
        _meets(curve, run, copy)
        for curve, run in _runs(points)
        for copy in _copies(curve.orbits, curve.orbits.adopt(orbits, z))
    )


def begins_or_ends_at(points: Sequence[OrbitPoint], orbits: Orbits, z: Array) -> bool:
    """Whether a locus of doubled orbits begins or ends where these have no amplitude.

    It ends a short step before, by about as much as the halves of its last orbit differ.
    """
    for point in (points[0], points[-1]):
        own = point.curve.orbits
        gap = float(np.linalg.norm(point.z - own.started_near(own.adopt(orbits, z), point.z)))
        apart = float(np.linalg.norm(asymmetry(own, point.z)))
        if gap < SAME_CRITICAL + 2 * apart < ABREAST:
            return True
    return False


def _runs(points: Sequence[OrbitPoint]) -> Iterator[tuple[LocusEquations, list[OrbitPoint]]]:
    """Points whose unknowns mean the same, each run with the last point of the one before."""
    for curve, run in groupby(points, lambda point: point.curve):
        own = list(run)
        before = points.index(own[0]) - 1
        again = curve.converted(points[before]) if before >= 0 else None
        if again is not None:
            place = own[0].arclength - arc_between(again, own[0])
            own.insert(0, replace(again, arclength=place))
        yield curve, own


def _copies(orbits: Orbits, z: Array) -> Iterator[Array]:
    """The same orbit begun in each forcing period, as far as its nodes allow."""
    if not orbits.model.forced:  # it is aligned with what it is compared with
        yield z
        return
    nodes = z[: orbits.size].reshape(orbits.segments, -1)
    each, rest = divmod(orbits.segments, orbits.period)
    for turn in range(orbits.period if rest == 0 else 1):
        moved = np.roll(nodes, -turn * each, axis=0).ravel()
        yield np.concatenate([moved, z[orbits.size :]])


def _meets(curve: LocusEquations, points: Sequence[OrbitPoint], z: Array) -> bool:
    where = np.array([point.z for point in points])
    size = curve.orbits.size
    tails = np.linalg.norm(where[:, size:] - z[size:], axis=1)
    z = curve.orbits.started_near(z, where[tails.argmin()])
    ends = np.linalg.norm(where - z, axis=1)
    if ends.min() < SAME_CRITICAL:
        return True
    lengths = np.linalg.norm(np.diff(where, axis=0), axis=1)
    # Between two points the locus stays within a length of them.
    near = np.flatnonzero(np.minimum(ends[:-1], ends[1:]) < lengths + ABREAST).tolist()
    return any(_meets_between(curve, points[i], points[i + 1], z) for i in near)


def _meets_between(curve: LocusEquations, a: OrbitPoint, b: OrbitPoint, z: Array) -> bool:
    grid = np.linspace(a.arclength, b.arclength, SAMPLES + 1)
    distances = [float(np.linalg.norm(hermite([a, b], s)[0] - z)) for s in grid]
    spacing = float(grid[1] - grid[0])
    nearest = int(np.argmin(distances))
    if distances[nearest] > spacing + ABREAST:
        return False
    place = float(grid[nearest])
    for _ in range(4):  # to where z lies abeam
        guess, row = hermite([a, b], place)
        place = float(np.clip(place + row @ (z - guess), a.arclength, b.arclength))
    guess, row = hermite([a, b], place)
    correction = correct(curve, guess, row, reach=2 * ABREAST)
    if not correction.converged:
        return False
    gap = curve.orbits.started_near(z, correction.z) - correction.z
    return bool(np.linalg.norm(gap - (gap @ row) * row) < SAME_CRITICAL + (gap @ row) ** 2)
