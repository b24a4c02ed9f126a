"""Where a piece of a curve ends with something that vanishes, found from beside that place.

Equations may be singular where it has vanished and stiff just before, so that nothing is computed
there. What vanishes unfolds the curve: unknowns are polynomials in its square root.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.curve import Curve
from slipfold.continuation.newton import correct
from slipfold.continuation.point import P

POWERS = np.array([0.0, 1.0, 1.5, 2.0])
"""Powers of what is left in which unknowns are expanded."""

PROBE = 1e-4
"""Arclength backwards over which the first rate of what is left is seen."""

APPROACHES, NEARER, CLOSE = 16, 0.2, 1.5
"""Steps to the place at most, the share that each of them leaves at least, and how much more than
what is wanted may be left after the last one."""

AIMS = 2.0 ** np.array([3.0, 2.0, 1.0, 0.0])
"""What is left at the points from which the place follows, in the least that is allowed."""

KNOWN = 3
"""Points before it from which the next one is guessed."""

LOOKS = 4.0 ** np.arange(6)
"""Distances beyond the place at which the next piece is looked for, in those of the farthest of
these points."""

ASTRAY = 30.0
"""Distance from the place, over that looked at, of a point that has nothing to do with it."""


@dataclass(frozen=True, eq=False)
class Vanishing(Generic[P]):
    """A place where something vanishes along a curve."""

    points: tuple[P, ...]  # computed points before it, the nearest one last
    weights: Array  # of what these points have: the sum is what there is at the place
    left: Array  # what is left at these points, shape (4,)
    z: Array  # the unknown there
    error: Array  # by how much it is uncertain

    @property
    def nearest(self) -> P:
        """The nearest point before it."""
        return self.points[-1]

    @property
    def reach(self) -> float:
        """Distance of the farthest of the points."""
        return float(np.linalg.norm(self.z - self.points[0].z))


def locate_vanishing(
    curve: Curve[P], start: P, left: Callable[[P], float | None], least: float, farthest: float
) -> Vanishing[P] | None:
    """Return where a positive function of the points of a piece vanishes, beyond a point of it.

    Points are computed where no less than `least` is left. None where it does not vanish within
    some arclength.
    """
    row, passed = start.tangent, [(0.0, start.z)]

    def at(place: float) -> tuple[P, float] | None:
        """The point of the piece at a place along the tangent, and what is left there."""
        correction = correct(curve, _extended(passed[-KNOWN:], place, row), row)
        if not correction.converged:
            return None
        point = curve.point(correction, start.arclength + place)
        value = left(point) if point.piece == start.piece else None
        if value is None:
            return None
        passed.append((place, point.z))
        return point, value

    before, here, last = -PROBE, 0.0, left(start)
    probed = at(before)
    if probed is None or last is None:
        return None
    earlier, aims = probed[1], least * AIMS
    for _ in range(APPROACHES):
        rate = (earlier - last) / (here - before)
        if not 0 < last < rate * (farthest - here):
            return None
        zero = here + last / rate
        if last <= CLOSE * aims[0]:
            break
        place = zero - max(NEARER, aims[0] / last) * (zero - here)
        found = at(place)
        if found is None:
            return None
        before, earlier, here, last = here, last, place, found[1]
    else:
        return None
    return _expanded([at(zero - aim / rate) for aim in aims])


def _extended(passed: Sequence[tuple[float, Array]], place: float, row: Array) -> Array:
    """Return where the curve leads from some points: a guess that is off may lie beyond its end."""
    if len(passed) == 1:
        return passed[0][1] + (place - passed[0][0]) * row
    places = np.array([there for there, _ in passed])
    weights = [
        np.prod([(place - other) / (there - other) for other in places if other != there])
        for there in places
    ]
    return np.asarray(weights @ np.array([z for _, z in passed]))


def _expanded(found: Sequence[tuple[P, float] | None]) -> Vanishing[P] | None:
    """Return the place from points before it, with what is left at each of them."""
    known = [item for item in found if item is not None]
    values = np.array([value for _, value in known])
    if len(known) < len(found) or not (np.diff(values) < 0).all():
        return None
    unknowns, scaled = np.array([point.z for point, _ in known]), values[:, None] / values[0]
    weights = np.linalg.inv(scaled**POWERS)[0]
    fewer = np.linalg.inv(scaled[1:] ** POWERS[:-1])[0]
    z = weights @ unknowns
    return Vanishing(
        tuple(point for point, _ in known), weights, values, z, np.abs(z - fewer @ unknowns[1:])
    )


def beyond_vanishing(curve: Curve[P], place: Vanishing[P]) -> P | None:
    """Return a first point of the next piece, followed away from the place; None if none is near.

    It lies ahead, or at the same values of the parameter, so that the curve turns back there.
    """
    nearest, held = place.nearest, np.zeros(len(place.z))
    held[-1] = 1.0
    for distance in place.reach * LOOKS:
        ahead = place.z + distance * nearest.tangent
        beside = ahead.copy()
        beside[-1] = place.z[-1] - distance * nearest.tangent[-1]
        for guess, row in ((ahead, nearest.tangent), (beside, held)):
            correction = correct(curve, guess, row)
            if not correction.converged:
                continue
            away = correction.z - place.z
            apart = float(np.linalg.norm(away))
            if apart > ASTRAY * distance:
                continue
            point = curve.point(correction, nearest.arclength + apart + place.reach)
            if point.piece == nearest.piece:
                continue
            if float(point.tangent @ away) < 0:
                arclength, point = point.arclength, curve.turned(point)
                point = replace(point, arclength=arclength)
            return point
    return None
