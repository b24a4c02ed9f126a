"""Curves that are smooth piece by piece: where one piece ends, and how the next one goes on."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.curve import Curve
from slipfold.continuation.interpolation import POINTS, hermite, well_spaced
from slipfold.continuation.locate import ALONG, LostCurveError, insert, point_at
from slipfold.continuation.newton import correct
from slipfold.continuation.point import P

CLOSE = 1e-11
"""Arclength to which the end of a piece is found, by bisection: nothing is smooth across it."""

HALVINGS = 60

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
    """Two neighbouring points on either side of the end of a piece."""

    before: P
    after: P
    met: P  # where the pieces meet, as far as it is known: beside, or beyond, the point before

    @property
    def apart(self) -> float:
        """Distance of the two points."""
        return float(np.linalg.norm(self.after.z - self.before.z))


def locate_seam(curve: Curve[P], known: Sequence[P], a: P, b: P) -> Seam[P]:
    """Return where the piece of a point ends on the way to one of another piece.

    The two may have nothing in common. The next one may go on in the parameter, but back along
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
    """Halve a chord, or its shadow along a row, until two neighbours of different pieces are left.

    The place on it belongs to a point alone, while errors of arclengths, which are summed from
    guess to guess, would grow with every halving.
    """
    chord = _ChordAhead(curve, [point for point in known if point.piece == a.piece], a, b, row)
    low, high = 0.0, chord.length
    for _ in range(HALVINGS):
        if high - low <= CLOSE:
            break
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

    None if it goes on where it was not found at first.
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
    """Return where a piece ends whose next one goes on in the parameter, but back in the states.

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
