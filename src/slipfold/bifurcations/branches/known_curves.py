"""Whether a curve that was followed passes through an orbit, or begins or ends there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import groupby

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.closed_branches import asymmetry
from slipfold.continuation.curve_set import FollowedCurve
from slipfold.continuation.interpolation import arc_between, hermite
from slipfold.continuation.newton import correct
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.orbit_curve import OrbitCurve, OrbitPoint, Orbits
from slipfold.orbits.shooting import Shooting
from slipfold.orbits.switched_shooting import SwitchedShooting


class KNOWN:
    """How near is near along curves: distances in scaled variables, numbers of order one."""

    near: float = 0.02  # distance from the interpolated curve at which the curve itself is examined
    same: float = 1e-4  # two orbits this close are one: of curves, directions differ by more
    samples: int = 16  # arclengths between neighboring points that are examined first


Meets = Callable[[Sequence[OrbitPoint], Orbits, Array], bool]
"""Whether an orbit, an unknown of some orbits, has to do with a curve through points."""


def passing(
    curves: Iterable[FollowedCurve[OrbitPoint]], curve: OrbitCurve, z: Array, meets: Meets
) -> int | None:
    """Return the number of the curve that an orbit meets, None if none of them does.

    Between its points a curve is computed, but where two cross it is singular.
    """
    for followed in curves:
        traced, own = followed.traced, followed.traced.curve
        if own.sort != curve.sort:
            continue
        alone = []
        if meets is lies_on:
            alone = [[item.point] for item in traced.found]
        elif meets is begins_or_ends_at:
            alone = [[point] for point in traced.reached if point.curve.sort == own.sort]
        for points in (traced.points, *alone):
            with suppress(*BREAKDOWNS):  # what breaks down in its terms is none of its orbits
                if meets(points, *in_period(own.orbits.period, curve.orbits, z)):
                    return followed.number
    return None


def lies_on(points: Sequence[OrbitPoint], orbits: Orbits, z: Array) -> bool:
    """Whether an orbit, an unknown of some orbits, is one of a curve, or a later phase of one."""
    return any(
        _meets(curve, run, copy)
        for curve, run in runs(points)
        for copy in _copies(curve.orbits, curve.orbits.adopt(orbits, z))
    )


def begins_or_ends_at(points: Sequence[OrbitPoint], orbits: Orbits, z: Array) -> bool:
    """Whether a curve of doubled orbits begins or ends where these have no amplitude.

    It may end a short step before, by about as much as the halves of its last orbit differ.
    """
    for point in (points[0], points[-1]):
        own = point.curve.orbits
        gap = own.distance(own.adopt(orbits, z), point.z)
        apart = float(np.linalg.norm(asymmetry(own, point.z)))
        if gap < KNOWN.same + 2 * apart < KNOWN.near:
            return True
    return False


def runs(points: Sequence[OrbitPoint]) -> Iterator[tuple[OrbitCurve, list[OrbitPoint]]]:
    """Points whose unknowns mean the same, each run with the first point of the next one.

    That point was found by the same equations: those of the next run may not hold so far back.
    """
    for curve, run in groupby(points, lambda point: point.curve):
        own = list(run)
        after = points.index(own[-1]) + 1
        again = curve.converted(points[after]) if after < len(points) else None
        if again is not None:
            place = own[-1].arclength + arc_between(own[-1], again)
            own.append(replace(again, arclength=place))
        yield curve, own


def _copies(orbits: Orbits, z: Array) -> Iterator[Array]:
    """The same orbit started in each forcing period, as far as its nodes allow."""
    if not orbits.model.forced:  # it is aligned with what it is compared with
        yield z
        return
    nodes = z[: orbits.size].reshape(orbits.segments, -1)
    each, rest = divmod(orbits.segments, orbits.period)
    for turn in range(orbits.period if rest == 0 else 1):
        moved = np.roll(nodes, -turn * each, axis=0).ravel()
        yield np.concatenate([moved, z[orbits.size :]])


def _meets(curve: OrbitCurve, points: Sequence[OrbitPoint], z: Array) -> bool:
    where = np.array([point.z for point in points])
    size = curve.orbits.size
    tails = np.linalg.norm(where[:, size:] - z[size:], axis=1)
    try:
        z = curve.orbits.started_near(z, where[tails.argmin()])
    except BREAKDOWNS:  # contacts of its run do something else
        return False
    ends = np.linalg.norm(where - z, axis=1)
    if ends.min() < KNOWN.same:
        return True
    lengths = np.linalg.norm(np.diff(where, axis=0), axis=1)
    # Between two points the curve stays within a length of them.
    near = np.flatnonzero(np.minimum(ends[:-1], ends[1:]) < lengths + KNOWN.near).tolist()
    return any(_meets_between(curve, points[i], points[i + 1], z) for i in near)


def _meets_between(curve: OrbitCurve, a: OrbitPoint, b: OrbitPoint, z: Array) -> bool:
    grid = np.linspace(a.arclength, b.arclength, KNOWN.samples + 1)
    distances = [float(np.linalg.norm(hermite([a, b], s)[0] - z)) for s in grid]
    spacing = float(grid[1] - grid[0])
    nearest = int(np.argmin(distances))
    if distances[nearest] > spacing + KNOWN.near:
        return False
    place = float(grid[nearest])
    for _ in range(4):  # to where z lies abeam
        guess, row = hermite([a, b], place)
        place = float(np.clip(place + row @ (z - guess), a.arclength, b.arclength))
    guess, row = hermite([a, b], place)
    correction = correct(curve, guess, row, reach=2 * KNOWN.near)
    if not correction.converged:
        return False
    gap = curve.orbits.started_near(z, correction.z) - correction.z
    return bool(np.linalg.norm(gap - (gap @ row) * row) < KNOWN.same + (gap @ row) ** 2)


def in_period(period: int, orbits: Orbits, z: Array) -> tuple[Orbits, Array]:
    """Return a cycle as one of another period: one that settled after it had doubled has 1."""
    if period == orbits.period:
        return orbits, z
    smooth, model = orbits.by.smooth, orbits.model_at(z)
    model = model.replace(duration=model.values["duration"] * orbits.period / period)
    nodes = orbits.evenly(z) if smooth else orbits.nodes(z)
    by = Shooting if smooth else SwitchedShooting
    same = orbits_of(orbits.model, orbits.varied, period, len(nodes), by=by)
    return same, same.unknown(nodes, model)
