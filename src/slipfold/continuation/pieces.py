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
from slipfold.continuation.interpolation import POINTS, lagrange
from slipfold.continuation.locate import ZERO, LostCurveError, Projection, insert, point_at
from slipfold.continuation.newton import TOO_SHARP, correct
from slipfold.errors import BREAKDOWNS


class PIECE:
    """Rules for the ends of smooth pieces."""

    # Arclength to which the end of a piece is located, by bisection: nothing is smooth across it
    close: float = 1e-11
    # Bisections after which the end is estimated: before, many searches are given up
    estimated: int = 5
    # Distances from the estimate at which points are tried, over `close`: shorter intervals of a
    # mode than about 1e-11 of a period are not seen, so pieces may part next to the estimate
    beside: tuple[float, ...] = (0.4, 10.0, 1e3)
    # Arclength to which the end of a piece is located if there is no next piece
    lost: float = 1e-6
    # Steps onto the next piece, which show in which direction of its tangent it lies
    looks: tuple[float, ...] = (1e-6, 1e-5, 1e-4, 1e-3)
    across: tuple[float, ...] = (*looks, 1e-2)  # such steps where the next piece is straight ahead
    # Distance above which the end of a piece and the beginning of the next are not connected
    apart: float = 1e-4
    # Maximum distance of the next piece from the tangent of this one, over the step
    straight: float = 0.1
    # Arclength backward over which the first rate of the function is estimated
    probe: float = 1e-4
    # Maximum number of steps to the zero, the smallest fraction of the distance that each leaves,
    # and the ratio of the function after the last one to its target
    approaches: int = 16
    nearer: float = 0.2
    enough: float = 1.5
    # Maximum distance of two zeros that are one, over their estimated errors
    same: float = 10.0
    # Maximum distance of a point of the next piece from the zero, over that of the guess
    astray: float = 30.0
    # Distance from the zero, over the shortest one tried, down to which points of the next piece
    # must lead: another curve may pass by. A square root leaves the zero at a right angle
    doubtful: float = 3.0
    # Maximum distance of the point halfway to the zero from it, over that of the point
    halfway: float = 0.75


@dataclass(frozen=True, eq=False)
class PieceBoundary(Generic[P]):
    """Two neighboring points on either side of the end of a piece."""

    before: P
    after: P

    @property
    def apart(self) -> float:
        """Distance of the two points."""
        return float(np.linalg.norm(self.after.z - self.before.z))


def _solution(
    curve: Curve[P], guess: Array, row: Array, s: float, near: Array, distance: float
) -> P | None:
    """Return the point next to a guess, of any piece; None if it is too far from an unknown."""
    point = curve.nearest(guess, row, s)
    return None if point is None or np.linalg.norm(point.z - near) > distance else point


def _parameter_row(point: P, sign: float = 1.0) -> Array:
    """Return the direction in which the parameter alone grows or falls."""
    row = np.zeros(len(point.z))
    row[-1] = math.copysign(1.0, sign)
    return row


Estimate = Callable[[P, P], Array | None]
"""Estimates the unknown where the piece of a point ends, before a point of another piece."""


def locate_boundary(
    curve: Curve[P], history: Sequence[P], a: P, b: P, estimate: Estimate[P] | None = None
) -> PieceBoundary[P]:
    """Return where the piece of a point ends before one of another piece.

    The two may not be connected. The next piece may continue in the parameter, but backward along
    their chord.
    """
    boundary = _bisected(curve, history, a, b, estimate=estimate)
    if boundary.apart < PIECE.apart:
        return boundary
    with suppress(LostCurveError):
        again = _bisected(curve, history, a, b, _parameter_row(a, b.z[-1] - a.z[-1]))
        if again.apart < PIECE.apart:
            return again
    return boundary


def _bisected(
    curve: Curve[P],
    history: Sequence[P],
    a: P,
    b: P,
    row: Array | None = None,
    estimate: Estimate[P] | None = None,
) -> PieceBoundary[P]:
    """Bisect the projection on a chord or a row until two neighbors of different pieces are left.

    The projection depends on a point alone; errors of arclengths, which are summed from guess to
    guess, would grow with every bisection. Both sides of an estimated end are tried first.
    """
    chord = _ChordAhead(curve, [point for point in history if point.piece == a.piece], a, b, row)
    low, high, halved = 0.0, chord.length, 0
    aims: list[tuple[float, Array | None]] = []
    while high - low > max(PIECE.close, 2 * np.spacing(high)):
        if estimate is not None and halved == PIECE.estimated:
            aims, estimate = chord.beside(estimate(a, b)), None
        while aims and not low < aims[0][0] < high:
            aims.pop(0)
        s, guess = aims.pop(0) if aims else (0.5 * (low + high), None)
        halved += 1
        middle = chord.point_at(s, guess)
        if middle.piece == a.piece:
            low, a = s, middle
        else:
            high, b = s, middle
    return PieceBoundary(a, b)


class _ChordAhead(Projection[P]):
    """The chord from the last point of a piece to one of another; guesses come from the piece."""

    def __init__(
        self, curve: Curve[P], own: Sequence[P], a: P, b: P, row: Array | None = None
    ) -> None:
        super().__init__(a, b, row)
        self._curve = curve
        for point in reversed(own):
            s = self._position(point)
            if not self._runs_along(point) or s > 0:
                break
            self._points.insert(0, self._projected(point, s))

    def beside(self, z: Array | None) -> list[tuple[float, Array | None]]:
        """Return projections on either side of an estimated end, with guesses; none without one."""
        if z is None:
            return []
        s = float((z - self._a.z) @ self._row)
        steps = [sign * PIECE.close * part for part in PIECE.beside for sign in (-1.0, 1.0)]
        return [(s + step, z + step * self._row) for step in steps]

    def point_at(self, s: float, first: Array | None = None) -> P:
        """Return the point with a projection, whatever its piece; a first guess may be given."""
        fraction = s / self.length
        arclength = self._a.arclength + fraction * (self._b.arclength - self._a.arclength)
        # The piece is extrapolated first, then the chord itself is tried.
        guesses = [] if first is None else [first]
        guesses += [self._guess(s)[1]] if self._points else []
        # Where a change of contacts makes orbits neutral, Newton's method may lead to any other.
        reach = max(float(np.linalg.norm(self._b.z - self._a.z)), ZERO.blurred)
        for guess in [*guesses, self._a.z + s * self._row]:
            correction = correct(self._curve, guess, self._row)
            if correction.converged and np.linalg.norm(correction.z - guess) <= reach:
                point = self._curve.point(correction, arclength)
                if point.piece == self._a.piece and self._runs_along(point):
                    insert(self._points, self._projected(point, s))
                return point
        raise LostCurveError(correction.failure or TOO_SHARP)


def locate_loss(curve: Curve[P], history: list[P], a: P, b: P) -> P | None:
    """Return the last point of a piece that ends before one of another, not connected with it.

    None if the piece continues where no point was computed at first.
    """
    own, end = [point for point in history if point.piece == a.piece], b
    while end.arclength - a.arclength > PIECE.lost:
        try:
            middle = _halfway(curve, own, a, end)
        except LostCurveError:
            middle = replace(b, arclength=0.5 * (a.arclength + end.arclength))
        if middle.piece == a.piece:
            insert(own, middle)
            a = middle
        else:
            end = middle
    beyond = _solution(curve, a.z + 2 * PIECE.lost * a.tangent, a.tangent, 0.0, a.z, np.inf)
    return None if beyond is not None and beyond.piece == a.piece else a


def _halfway(curve: Curve[P], own: list[P], a: P, b: P) -> P:
    """Return the point halfway between two others, extrapolated from the piece of the first."""
    s = 0.5 * (a.arclength + b.arclength)
    try:
        return replace(point_at(curve, own, s), arclength=s)
    except LostCurveError:
        middle, row = 0.5 * (a.z + b.z), b.z - a.z  # along the chord
        point = _solution(curve, middle, row / np.linalg.norm(row), s, middle, np.inf)
        if point is None:
            raise
        return point


def ahead_of(curve: Curve[P], before: P, after: P) -> list[P]:
    """Return first points of the next piece, with tangents in the direction of that piece.

    The tangent jumps, and the parameter may turn. So near to the boundary rounding decides to
    which piece a tangent belongs: both are tried. A piece thinner than the first step is skipped.
    The nearest point comes first; none if there is no solution nearby.
    """
    own = after.tangent
    for step in PIECE.looks:
        for row in (own, -own, before.tangent, -before.tangent):
            s = after.arclength + step
            point = _solution(curve, after.z + step * row, row, s, after.z, 10 * step)
            if point is None:
                continue
            if point.piece == after.piece:
                turned = curve.turned(after) if row @ own < 0 else after
                return [replace(turned, arclength=after.arclength), point]
            if row is own and point.piece != before.piece:
                return [point]
    # A tangent of a thin piece, which rounding makes, leads nowhere.
    beyond = across_gap(curve, before, PIECE.looks[:1])
    return [] if beyond is None else [beyond]


def across_gap(curve: Curve[P], last: P, steps: Sequence[float] = PIECE.across) -> P | None:
    """Return a point of the next piece to which the tangent of this one leads, None without one.

    Next to where the piece begins the equations may be too stiff to be solved.
    """
    for step in steps:
        guess, s = last.z + step * last.tangent, last.arclength + step
        point = _solution(curve, guess, last.tangent, s, last.z, 2 * step)
        if point is None or point.piece == last.piece:
            continue
        if np.linalg.norm(point.z - guess) < PIECE.straight * step:
            return point
    return None


POWERS = np.array([0.0, 1.0, 1.5, 2.0])
"""Powers of the vanishing function in which unknowns are expanded."""

ROOTS = np.array([0.0, 0.5, 1.0, 1.5])
"""Those where unknowns are smooth in its root."""

AIMS = 2.0 ** np.array([3.0, 2.0, 1.0, 0.0])
"""Values of the function at the points from which the zero is extrapolated, over the smallest."""

DISTANCES = 4.0 ** np.arange(6)
"""Distances beyond the zero of guesses at the next piece, over that of the farthest point."""


@dataclass(frozen=True, eq=False)
class Vanishing(Generic[P]):
    """The point of a curve at which a positive function vanishes."""

    points: tuple[P, ...]  # computed points before it, the nearest one last
    weights: Array  # of values at these points: their sum is the value where it vanishes
    left: Array  # the function at these points, shape (4,)
    z: Array  # the unknown where it vanishes
    error: Array  # its uncertainty

    @property
    def nearest(self) -> P:
        """The nearest point before it."""
        return self.points[-1]

    @property
    def reach(self) -> float:
        """Distance of the farthest of the points."""
        return float(np.linalg.norm(self.z - self.points[0].z))

    def is_same(self, other: Vanishing[P]) -> bool:
        """Whether another place, reached from its other side, is this one within their errors."""
        apart, errors = self.z - other.z, (self.error, other.error)
        return bool(np.linalg.norm(apart) < PIECE.same * np.linalg.norm(errors))


def locate_vanishing(
    curve: Curve[P],
    start: P,
    left: Callable[[P], float | None],
    least: float,
    farthest: float,
    powers: Array = POWERS,
) -> Vanishing[P] | None:
    """Return the zero of a positive function of the points of a piece, beyond a point of it.

    Points are computed where the function is not below `least`. None if there is no zero within the
    arclength `farthest`. The unknowns are expanded in `powers` of the function, shape (4,).
    """
    row, passed = start.tangent, [(0.0, start.z)]

    def at(s: float) -> tuple[P, float] | None:
        """Return the point of the piece at a distance along the tangent, with its function."""
        point = curve.nearest(_extrapolated(passed[-POINTS:], s, row), row, start.arclength + s)
        value = left(point) if point is not None and point.piece == start.piece else None
        if point is None or value is None:
            return None
        passed.append((s, point.z))
        return point, value

    before, here, last = -PIECE.probe, 0.0, left(start)
    probed = at(before)
    if probed is None or last is None:
        return None
    earlier, aims = probed[1], least * AIMS
    for _ in range(PIECE.approaches):
        rate = (earlier - last) / (here - before)
        if not 0 < last < rate * (farthest - here):
            return None
        zero = here + last / rate
        if last <= PIECE.enough * aims[0]:
            break
        s = zero - max(PIECE.nearer, aims[0] / last) * (zero - here)
        nearer = at(s)
        if nearer is None:
            return None
        before, earlier, here, last = here, last, s, nearer[1]
    else:
        return None
    return _expanded([at(zero - aim / rate) for aim in aims], powers)


def _extrapolated(passed: Sequence[tuple[float, Array]], s: float, row: Array) -> Array:
    """Extrapolate unknowns at distances: a poor guess may lie beyond the end of the curve."""
    if len(passed) == 1:
        return passed[0][1] + (s - passed[0][0]) * row
    weights = lagrange([there for there, _ in passed], s)
    return np.asarray(weights @ np.array([z for _, z in passed]))


def _expanded(computed: Sequence[tuple[P, float] | None], powers: Array) -> Vanishing[P] | None:
    """Extrapolate the zero from points before it, with the function at each of them."""
    known = [item for item in computed if item is not None]
    values = np.array([value for _, value in known])
    if len(known) < len(computed) or not (np.diff(values) < 0).all():
        return None
    unknowns, scaled = np.array([point.z for point, _ in known]), values[:, None] / values[0]
    weights = np.linalg.inv(scaled**powers)[0]
    fewer = np.linalg.inv(scaled[1:] ** powers[:-1])[0]
    z = weights @ unknowns
    return Vanishing(
        tuple(point for point, _ in known), weights, values, z, np.abs(z - fewer @ unknowns[1:])
    )


def _is_connected(curve: Curve[P], point: P, z: Array, near: float) -> bool:
    """Whether the piece of a point leads near an unknown: it has points halfway there."""
    middle: P | None = point
    while middle is not None and middle.piece == point.piece:
        away = middle.z - z
        length = float(np.linalg.norm(away))
        if length <= near:
            return True
        middle = _solution(curve, z + away / 2, away / length, 0.0, z, PIECE.halfway * length)
    return False


def beyond_end(curve: Curve[P], last: P, z: Array, reach: float) -> P | None:
    """Return a first point of the next piece, with its tangent away from where one ends; or None.

    `z` is where the piece of a point ends, `reach` the scale of distances to try.
    """
    for distance in reach * DISTANCES:
        for step, row in _ways_beyond(curve, last, z, distance):
            point = _solution(curve, z + step, row, 0.0, z, PIECE.astray * distance)
            if point is None or point.piece == last.piece:
                continue
            away = point.z - z
            apart = float(np.linalg.norm(away))
            if not _is_connected(curve, point, z, PIECE.doubtful * reach):
                continue
            point = curve.turned(point) if float(point.tangent @ away) < 0 else point
            return replace(point, arclength=last.arclength + apart + reach)
    return None


def _ways_beyond(
    curve: Curve[P], last: P, z: Array, distance: float
) -> Iterator[tuple[Array, Array]]:
    """Yield steps from the end of a piece that may lead to the next one, and rows to correct along.

    The tangent of the next piece solves its equations across the end, next to which they hold
    beside the curve as well; it lies on one side or the other. Where unknowns go as a root, there
    is no such tangent: the next piece lies ahead, or the curve turns back in the parameter, or in
    the states alone.
    """
    ahead = distance * last.tangent
    for side in (ahead, -ahead):
        with suppress(*BREAKDOWNS):
            linearization = curve.linearize(z + side)
            if linearization.is_finite:
                tangent = linearization.bordered(last.tangent).tangent()
                yield distance * tangent, tangent
                yield -distance * tangent, -tangent
    across = _parameter_row(last)
    yield ahead, last.tangent
    yield np.append(ahead[:-1], -ahead[-1]), across
    yield ahead * across, across
