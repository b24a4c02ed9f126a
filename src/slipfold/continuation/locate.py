"""The zero of a function of the points of a curve between two of them."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.curve import Curve, P
from slipfold.continuation.interpolation import (
    POINTS,
    SPACING,
    arc_between,
    derivatives,
    hermite,
    well_spaced,
)
from slipfold.continuation.newton import correct


class ZERO:
    """Rules for finding and locating zeros between two points."""

    # Arclength to which a zero is located; the parameter then is right to 1e-12 of the span
    close: float = 1e-12
    # Distance of the points of a secant, and the least multiple of the arclength to which a zero is
    # located: of nearer points errors of the values decide
    apart: float = 1e-7
    many: float = 1e3
    # Maximum number of points; 8 are seldom needed
    evaluations: int = 40
    # Where Newton's method fails at a zero, a point at this fraction of `close` from it is taken
    aside: float = 0.5
    # Arclength within which rounding, magnified by large multipliers, may hide a zero. The point's
    # uncertainty, computed separately, says how much it does
    blurred: float = 1e-6
    # If the cosine between tangent and chord is smaller, the interval is bisected first
    along: float = 0.3
    # Evaluations after which every other one bisects, whatever the interpolation returns
    interpolations: int = 8
    # Points outside a bracket that are interpolated as well: they save one of four evaluations
    neighbors: int = 2
    # Values that a polynomial goes through
    values: int = 6
    # Newton steps to its zero, from the value nearest to zero
    corrections: int = 5
    # Maximum number of halvings of an interval, to 1/128 of a step
    depth: int = 7
    # The same of further divisions between two zeros near each other
    deeper: int = 2
    # Where else an interval is divided, in its length, if Newton's method left the curve there
    elsewhere: tuple[float, ...] = (0.5, 0.3, 0.7, 0.15, 0.85)
    # Points that test functions are interpolated through
    knots: int = 4
    # Arclengths between two points at which functions are interpolated
    grid: int = 16
    # Fraction of its interpolation error below which a test function may have changed its sign
    # twice: twice what a parabola with that error in its slope falls by, for one that grows fast
    unsure: float = 0.5
    # A test function that falls between two points to this fraction of its values is examined
    dip: float = 0.15
    # The same of one that has a minimum there: where its third derivative changes its sign, errors
    # are larger than interpolation says. Zeros in steps of cosines are found with more than 0.2
    bottom: float = 0.5
    # Fraction of its distance from zero by which the bound of the multipliers may change in a step
    change: float = 0.5


class LostCurveError(ArithmeticError):
    """Newton's method failed between two points of a curve."""


@dataclass(frozen=True, eq=False)
class Guess:
    """An unknown that is to be corrected in the hyperplane through it."""

    z: Array
    row: Array  # normal of the hyperplane
    near: Sequence[Any]  # points from which it was interpolated
    arclength: float  # where, in their arclengths


G = TypeVar("G")
T = TypeVar("T")

Guesses = Generator[Guess, Any, T]
"""A search: it yields guesses, receives the point nearest to each, and returns its result.

Where there is no point, `LostCurveError` is thrown into it.
"""


def corrected(curve: Curve[P], search: Guesses[T]) -> T:
    """Correct the guesses of a search on a curve, one after the other; return its result."""

    def correct(guesses: dict[int, Guess]) -> dict[int, P | LostCurveError]:
        try:
            return {0: _corrected(curve, guesses[0])}
        except LostCurveError as error:
            return {0: error}

    (result,) = corrected_together([search], correct)
    if isinstance(result, LostCurveError):
        raise result
    return result


def corrected_together(
    searches: Sequence[Generator[G, Any, T]],
    correct: Callable[[dict[int, G]], dict[int, Any]],
    errors: tuple[type[Exception], ...] = (LostCurveError,),
) -> list[T | Any]:
    """Correct the guesses of many searches at the same time; return what each finds, or an error.

    `correct` takes guesses by the number of their search, and returns points, or errors.
    """
    results: list[Any] = [None] * len(searches)
    answers: dict[int, Any] = dict.fromkeys(range(len(searches)))
    while answers:
        guesses = dict[int, G]()
        for number, answer in answers.items():
            search, lost = searches[number], isinstance(answer, errors)
            try:
                guesses[number] = search.throw(answer) if lost else search.send(answer)
            except StopIteration as done:
                results[number] = done.value
            except errors as error:
                results[number] = error
        answers = correct(guesses) if guesses else {}
    return results


def _corrected(curve: Curve[P], guess: Guess) -> P:
    """Return the point nearest a guess, with derivatives interpolated from points near it."""
    expected = derivatives(curve, guess.near, guess.arclength)
    correction = correct(curve, guess.z, guess.row, expected=expected)
    if not correction.converged:
        raise LostCurveError(correction.failure)
    return curve.point(correction, guess.arclength)


def point_at(curve: Curve[P], history: Sequence[P], arclength: float) -> P:
    """Return the point at an arclength between known points of a curve."""
    return corrected(curve, _guess_at(curve, history, arclength))


def _guess_at(curve: Curve[P], history: Sequence[P], arclength: float) -> Guesses[P]:
    near = well_spaced(history, arclength, arclength, POINTS)
    guess, row = hermite(near, arclength)
    point = yield Guess(curve.aligned(guess, near[0].z), row, near, arclength)
    # Where the guess was poor the correction moved it along the curve.
    after = bisect([item.arclength for item in history], point.arclength)
    if not 0 < after < len(history):
        return point
    return _between(history[after - 1], point, history[after])


def _between(a: P, point: P, b: P) -> P:
    """Give a point its arclength between two others, by its distances from them."""
    left, right = arc_between(a, point), arc_between(point, b)
    fraction = left / (left + right) if left + right > 0 else 0.5
    return replace(point, arclength=a.arclength + fraction * (b.arclength - a.arclength))


def insert(history: list[P], point: P) -> None:
    """Add a point to a list that is ordered by arclength."""
    history.insert(bisect([item.arclength for item in history], point.arclength), point)


def locate(
    curve: Curve[P],
    history: list[P],
    a: P,
    b: P,
    function: Callable[[P], float],
    close: float = ZERO.close,
) -> P:
    """Return the zero of a function that has different signs at two points."""
    return corrected(curve, locating(curve, history, a, b, function, close))


def locating(
    curve: Curve[P],
    history: list[P],
    a: P,
    b: P,
    function: Callable[[P], float],
    close: float = ZERO.close,
) -> Guesses[P]:
    """Search for the zero of a function that has different signs at two points.

    Each guess is the zero of the polynomial through all values, also of points outside the two.
    Where it has none in the bracket, this is bisected. Every point computed is added to `history`.
    """
    values = function(a), function(b)
    while not (chord := _Chord(a, b)).is_crossed_once:
        middle = yield from _guess_at(curve, history, 0.5 * (a.arclength + b.arclength))
        if not a.arclength < middle.arclength < b.arclength:
            raise LostCurveError("the curve turns too sharply between two points")
        insert(history, middle)
        value = function(middle)
        if (value > 0) == (values[0] > 0):
            a, values = middle, (value, values[1])
        else:
            b, values = middle, (values[0], value)
    outside = [(s, function(point)) for s, point in chord.use_neighbors(history)]
    zero = BracketedZero(chord.length, values, outside)
    for _ in range(ZERO.evaluations):
        s = zero.next_guess()
        try:
            point = yield from chord.point_at(s)
        except LostCurveError:  # Newton's method is singular exactly at a branch point
            s += ZERO.aside * close
            point = yield from chord.point_at(s)
        value = function(point)
        if value == 0.0 or zero.error(s, value) <= close or zero.width <= close:
            return point
        insert(history, point)
        zero.add(s, value)
    if zero.width > ZERO.blurred:
        raise LostCurveError(f"a zero was not located in {ZERO.evaluations} points")
    return point


class BracketedZero:
    """A zero of a function that has different signs at zero and at some length.

    Values outside the two may be known as well.
    """

    def __init__(
        self,
        length: float,
        values: tuple[float, float],
        outside: Sequence[tuple[float, float]] = (),
    ) -> None:
        self._tried = [(0.0, values[0]), (length, values[1])]
        self._outside = outside
        self._low, self._high, self._positive = 0.0, length, values[0] > 0

    @property
    def width(self) -> float:
        """Length of the bracket."""
        return self._high - self._low

    def next_guess(self) -> float:
        """Return where to evaluate the function next, inside the bracket."""
        start = min(self._tried, key=lambda item: abs(item[1]))[0]
        s, count = _polynomial_zero([*self._tried, *self._outside], start), len(self._tried) - 2
        if not self._low < s < self._high or (count > ZERO.interpolations and count % 2):
            return 0.5 * (self._low + self._high)
        return s

    def error(self, s: float, value: float) -> float:
        """Return the distance to the zero by the secant through the nearest value."""
        nearest, other = min(self._tried, key=lambda item: abs(item[0] - s))
        return abs(value * (s - nearest) / (value - other)) if value != other else np.inf

    def add(self, s: float, value: float) -> None:
        """Note a value of the function."""
        self._tried.append((s, value))
        if (value > 0) == self._positive:
            self._low = s
        else:
            self._high = s


class Projection(Generic[P]):
    """The part of a curve between two points, over its projection on the chord or another row.

    Unlike the arclength, which is summed from one guess to the next, the projection depends on the
    solution alone. So an interpolated zero does not move as more points are computed.
    """

    def __init__(self, a: P, b: P, row: Array | None = None) -> None:
        self._a, self._b = a, b
        difference = b.z - a.z
        chord = float(np.linalg.norm(difference)) or 1.0
        self._row = difference / chord if row is None else row
        self.length = chord if row is None else float(difference @ row) or 1.0
        self._points: list[P] = []  # the points from which guesses come

    def _runs_along(self, point: P) -> bool:
        """Whether the curve runs along the row at a point, not back or across."""
        return float(point.tangent @ self._row) > ZERO.along

    def _position(self, point: P) -> float:
        return float((point.z - self._a.z) @ self._row)

    def _projected(self, point: P, s: float) -> P:
        """Return a point over its projection, with the derivative with respect to it."""
        return replace(point, arclength=s, tangent=point.tangent / (point.tangent @ self._row))

    def _guess(self, s: float) -> tuple[list[P], Array]:
        """Return the interpolated point with a projection, and the points next to it."""
        near = well_spaced(self._points, s, s, POINTS)
        guess, _ = hermite(near, s)
        return near, guess + (s - float((guess - self._a.z) @ self._row)) * self._row


class _Chord(Projection[P]):
    """The part of a smooth curve between two points."""

    def __init__(self, a: P, b: P) -> None:
        super().__init__(a, b)
        if self.is_crossed_once:
            self._points = [self._projected(a, 0.0), self._projected(b, self.length)]

    @property
    def is_crossed_once(self) -> bool:
        """Whether the curve runs along the chord at both ends."""
        return self._runs_along(self._a) and self._runs_along(self._b)

    def use_neighbors(self, history: Sequence[P]) -> list[tuple[float, P]]:
        """Use points outside the bracket, too; return them with their positions."""
        apart, chosen = SPACING * self.length, list[tuple[float, P]]()
        for point in history:
            if point.piece != self._a.piece or not point.resembles(self._a):
                continue
            s = self._position(point)
            near = not -apart <= s <= self.length + apart
            alone = all(abs(s - other) > apart for other, _ in chosen)
            if near and alone and self._runs_along(point):
                chosen.append((s, point))
        chosen = sorted(chosen, key=lambda item: abs(item[0] - 0.5 * self.length))[: ZERO.neighbors]
        self._points += [self._projected(point, s) for s, point in chosen]
        return chosen

    def point_at(self, s: float) -> Guesses[P]:
        """Search for the point with a projection on the chord."""
        near, guess = self._guess(s)
        point = yield Guess(guess, self._row, near, s)
        # Beside a branch point Newton's method is singular and may lead to any other curve.
        away = np.linalg.norm(point.z - guess) > max(self.length, ZERO.blurred)
        if away or float(point.tangent @ self._row) <= 0:
            raise LostCurveError("the curve turns too sharply between two points")
        self._points.append(self._projected(point, s))
        return _between(self._a, point, self._b)


def _polynomial_zero(values: Sequence[tuple[float, float]], start: float) -> float:
    """Return the zero near a start of the polynomial through positions and their values; or NaN.

    In Newton's form and plain floats: there are few of them.
    """
    nearest = sorted(values, key=lambda item: abs(item[0] - start))[: ZERO.values]
    where, factors = [item[0] for item in nearest], [item[1] for item in nearest]
    if len(set(where)) < len(where):
        return np.nan
    for order in range(1, len(where)):
        for i in range(len(where) - 1, order - 1, -1):
            factors[i] = (factors[i] - factors[i - 1]) / (where[i] - where[i - order])
    s = start
    for _ in range(ZERO.corrections):
        value, slope = 0.0, 0.0
        for x, factor in zip(reversed(where), reversed(factors), strict=True):
            slope = slope * (s - x) + value
            value = value * (s - x) + factor
        if slope == 0.0:
            return np.nan
        s -= value / slope
    return s
