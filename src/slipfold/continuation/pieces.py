"""Piecewise smooth curves: where one piece ends, and where the next one continues."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.curve import Curve, P
from slipfold.continuation.interpolation import POINTS, hermite, well_spaced
from slipfold.continuation.locate import ALONG, LostCurveError, insert, point_at
from slipfold.continuation.newton import correct

CLOSE = 1e-11
"""Arclength to which the end of a piece is found, by bisection: nothing is smooth across it."""

LOST = 1e-6
"""Arclength to which the place is found where a piece ends and nothing is beyond."""

LOOKS = (1e-6, 1e-5, 1e-4, 1e-3)
"""Steps onto the next piece that tell in which direction of its tangent it lies."""

HOPS, LEFT = 4, 1e-3
"""Times that a fold between two pieces is approached, and what is left of the way each time."""

APART = 1e-4
"""Distance of two points, where one piece ends and the next begins, with nothing in common."""

REACH = 100.0
"""Steps within which the other piece lies."""


@dataclass(frozen=True, eq=False)
class Seam(Generic[P]):
    """Two neighboring points on either side of the end of a piece."""

    before: P
    after: P
    met: P  # where the pieces meet, as far as it is known: beside, or beyond, the point before

    @property
    def apart(self) -> float:
        """Distance of the two points."""
        return float(np.linalg.norm(self.after.z - self.before.z))


def locate_seam(curve: Curve[P], known: Sequence[P], a: P, b: P) -> Seam[P]:
    """Return where the piece of a point ends on the way to one of another piece.

    The two may have nothing in common. The next one may continue in the parameter, but back along
    their chord.
    """
    seam = _halved(curve, known, a, b)
    if seam.apart < APART:
        return seam
    with suppress(LostCurveError):
        again = _halved(curve, known, a, b, _parameter(a, b.z[-1] - a.z[-1]))
        if again.apart < APART:
            return again
    return seam


def _parameter(point: P, sign: float) -> Array:
    """Return the direction in which the parameter grows or falls, whatever else does."""
    row = np.zeros(len(point.z))
    row[-1] = math.copysign(1.0, sign)
    return row


def _halved(curve: Curve[P], known: Sequence[P], a: P, b: P, row: Array | None = None) -> Seam[P]:
    """Halve a chord, or its shadow along a row, until two neighbors of different pieces are left.

    The place on it belongs to a point alone, while errors of arclengths, which are summed from
    guess to guess, would grow with every halving.
    """
    chord = _ChordAhead(curve, [point for point in known if point.piece == a.piece], a, b, row)
    low, high = 0.0, chord.length
    while high - low > max(CLOSE, 2 * np.spacing(high)):
        place = 0.5 * (low + high)
        middle = chord.point_at(place)
        if middle.piece == a.piece:
            low, a = place, middle
        else:
            high, b = place, middle
    return Seam(a, b, a)


class _ChordAhead(Generic[P]):
    """The chord from the last point of a piece to one of another, seen from the piece."""

    def __init__(
        self, curve: Curve[P], own: Sequence[P], a: P, b: P, row: Array | None = None
    ) -> None:
        self._curve, self._a, self._b = curve, a, b
        difference = b.z - a.z
        size = float(np.linalg.norm(difference)) or 1.0
        self._row = difference / size if row is None else row
        self.length = float(difference @ self._row) or 1.0
        self._known: list[P] = []
        for point in reversed(own):
            place = float((point.z - a.z) @ self._row)
            if float(point.tangent @ self._row) <= ALONG or place > 0:
                break
            self._known.insert(0, self._projected(point, place))

    def point_at(self, place: float) -> P:
        """Return the point at a place along the chord, whatever its piece."""
        share = place / self.length
        arclength = self._a.arclength + share * (self._b.arclength - self._a.arclength)
        for guess in self._guesses(place):
            correction = correct(self._curve, guess, self._row)
            if correction.converged:
                point = self._curve.point(correction, arclength)
                if point.piece == self._a.piece and float(point.tangent @ self._row) > ALONG:
                    insert(self._known, self._projected(point, place))
                return point
        raise LostCurveError(correction.failure)

    def _guesses(self, place: float) -> Iterator[Array]:
        """Yield where the piece leads, then the place on the chord itself."""
        straight = self._a.z + place * self._row
        if self._known:
            guess, _ = hermite(well_spaced(self._known, place, place, POINTS), place)
            yield guess + float((straight - guess) @ self._row) * self._row
        yield straight

    def _projected(self, point: P, place: float) -> P:
        """Return a point with its place along the chord and the derivative with respect to it."""
        return replace(point, arclength=place, tangent=point.tangent / (point.tangent @ self._row))


def locate_loss(curve: Curve[P], known: list[P], a: P, b: P) -> P | None:
    """Return the last point of a piece that ends before one of another, with nothing between.

    None if it continues where it was not found at first.
    """
    own, end = [point for point in known if point.piece == a.piece], b
    while end.arclength - a.arclength > LOST:
        try:
            middle = _between(curve, own, a, end)
        except LostCurveError:
            middle = replace(b, arclength=0.5 * (a.arclength + end.arclength))
        if middle.piece == a.piece:
            insert(own, middle)
            a = middle
        else:
            end = middle
    correction = correct(curve, a.z + 2 * LOST * a.tangent, a.tangent)
    goes_on = correction.converged and curve.point(correction, 0.0).piece == a.piece
    return None if goes_on else a


def _between(curve: Curve[P], own: list[P], a: P, b: P) -> P:
    """Return the point halfway between two others, seen from the piece of the first."""
    place = 0.5 * (a.arclength + b.arclength)
    try:
        found = point_at(curve, own, place)
    except LostCurveError:  # seen along the chord
        row = b.z - a.z
        correction = correct(curve, 0.5 * (a.z + b.z), row / np.linalg.norm(row))
        if not correction.converged:
            raise
        found = curve.point(correction, place)
    return replace(found, arclength=place)


def locate_fold(curve: Curve[P], last: P) -> Seam[P] | None:
    """Return where a curve turns back on the next piece, that is where a piece and the next meet.

    Beyond there is nothing, so it ends shortly before; what is beside its last point on the other
    piece, at the same value of the parameter, tells where.
    """
    other = next(filter(None, (_beside(curve, last, step) for step in LOOKS)), None)
    if other is None:
        return None
    for _ in range(HOPS):
        left, beyond = _distances(last, other)
        if not CLOSE < left < 1:
            break
        row = last.tangent
        correction = correct(curve, last.z + (1 - LEFT) * left * row, row)
        if not correction.converged:
            break
        nearer = curve.point(correction, last.arclength + (1 - LEFT) * left)
        across = _beside(curve, nearer, 2 * LEFT * left) if nearer.piece == last.piece else None
        if across is None:
            break
        last, other = nearer, across
    left, beyond = _distances(last, other)
    other = other if beyond > 0 else curve.turned(other)
    apart = max(float(np.linalg.norm(other.z - last.z)), CLOSE)
    met = replace(last, z=last.z + left * last.tangent) if 0 < left < apart else last
    return Seam(last, replace(other, arclength=last.arclength + apart), met)


def locate_ahead(curve: Curve[P], last: P) -> Seam[P] | None:
    """Return where a piece ends whose next one continues in the parameter, but back in the states.

    No step along the tangent leads onto it. None where no point that begins there is found.
    """
    row = _parameter(last, last.tangent[-1])
    for step in LOOKS:
        far = step * abs(last.tangent[-1])
        correction = correct(curve, last.z + far * row, row)
        if not correction.converged or np.linalg.norm(correction.z - last.z) > REACH * step:
            continue
        found = curve.point(correction, last.arclength + step)
        if found.piece != last.piece:
            seam = _halved(curve, [last], last, found, row)
            return seam if seam.apart < APART else None
    return None


def _beside(curve: Curve[P], last: P, step: float) -> P | None:
    """Return a point of another piece with the same value of the parameter."""
    row = np.zeros(len(last.z))
    row[-1] = 1.0
    guess = last.z + step * last.tangent
    guess[-1] = last.z[-1]
    correction = correct(curve, guess, row)
    if not correction.converged or np.linalg.norm(correction.z - last.z) > REACH * step:
        return None
    found = curve.point(correction, last.arclength)
    return found if found.piece != last.piece else None


def _distances(last: P, other: P) -> tuple[float, float]:
    """Return how far along their tangents two points lie before and beyond where pieces meet."""
    sides = np.column_stack([last.tangent, other.tangent])
    found = np.linalg.lstsq(sides, other.z - last.z, rcond=None)[0]
    return float(found[0]), float(found[1])


def ahead_of(curve: Curve[P], before: P, after: P) -> P | None:
    """Return the first point of the next piece with the direction in which that piece lies.

    The tangent jumps, and the parameter may turn there. A piece so thin that the first look is
    beyond it is passed. None where no solution is near.
    """
    for step in LOOKS:
        for sign in (1.0, -1.0):
            row = sign * after.tangent
            correction = correct(curve, after.z + step * row, row)
            if not correction.converged:
                continue
            if np.linalg.norm(correction.z - after.z) > 10 * step:
                continue
            point = curve.point(correction, after.arclength + step)
            if point.piece == after.piece:
                turned = curve.turned(after) if sign < 0 else after
                return replace(turned, arclength=after.arclength)
            if sign > 0 and point.piece != before.piece:
                return point
    return None


POWERS = np.array([0.0, 1.0, 1.5, 2.0])
"""Powers of what is left in which unknowns are expanded."""

PROBE = 1e-4
"""Arclength backwards over which the first rate of what is left is seen."""

APPROACHES, NEARER, ENOUGH = 16, 0.2, 1.5
"""Steps to the place at most, the share that each of them leaves at least, and how much more than
what is wanted may be left after the last one."""

AIMS = 2.0 ** np.array([3.0, 2.0, 1.0, 0.0])
"""What is left at the points from which the place follows, in the least that is allowed."""

DISTANCES = 4.0 ** np.arange(6)
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
        correction = correct(curve, _extended(passed[-POINTS:], place, row), row)
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
        if last <= ENOUGH * aims[0]:
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
    for distance in place.reach * DISTANCES:
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
