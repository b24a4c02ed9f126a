"""One curve from its first point to its end, with its special points."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic

import numpy as np

from slipfold.continuation.curve import Curve, P
from slipfold.continuation.end import End
from slipfold.continuation.locate import LostCurveError
from slipfold.continuation.settings import Stepping
from slipfold.continuation.step_length import STEP
from slipfold.continuation.traced_curve import Found, Monitor, StepInterval, Stop, TracedCurve
from slipfold.continuation.walk import Bound, CurveSteps, Failure, first_point, reaches
from slipfold.errors import BREAKDOWNS, breakdown


class Endings(Generic[P]):
    """Sentences for the ends that continuation itself gives a curve."""

    def left(self, traced: TracedCurve[P]) -> End:
        """Return the end of a curve that reached a bound."""
        return self._end(traced, "window", "reached the end of the window")

    def failed(self, traced: TracedCurve[P], failure: Failure) -> End:
        """Return the end of a curve that could not be followed; it may amend the traced curve."""
        return self._end(traced, failure.kind, failure.reason)

    def interrupted(self, traced: TracedCurve[P]) -> End:
        """Return the end of a curve that was interrupted."""
        return self._end(traced, "interrupted", "interrupted; results up to there are kept")

    def contradiction(self, traced: TracedCurve[P]) -> tuple[P, str] | None:
        """Return where a curve does what takes a special point, without one, and what it does."""
        extremum = unexplained_reversal(traced)
        return None if extremum is None else (extremum, "the direction of a parameter changes")

    def contradicted(self, traced: TracedCurve[P], at: P, change: str) -> End:
        """Return the end of a curve that does so."""
        assert traced.end is not None
        values = ", ".join(f"{value:.9g}" for value in traced.curve.place(at.z))
        reason = (
            f"{traced.end.reason}; but at {values} {change} and nothing was located that explains "
            "it, so other special points may be missing as well; limit the step"
        )
        return End("contradiction", reason, traced.end.values)

    def _end(self, traced: TracedCurve[P], kind: str, reason: str) -> End:
        return End(kind, reason, traced.curve.place(traced.points[-1].z))


def follow(
    curve: Curve[P],
    start: P,
    bounds: Sequence[Bound],
    monitors: Sequence[Monitor[P]] | Callable[[Any], Sequence[Monitor[P]]] = (),
    *,
    settings: Stepping | None = None,
    departs: bool = False,
    first_step: float | Callable[[], float] | None = None,
    cap: Callable[[P], float] | None = None,
    endings: Endings[P] | None = None,
    otherwise: Callable[[TracedCurve[P]], tuple[Any, P] | None] = lambda traced: None,
    on_step: Callable[[TracedCurve[P]], None] = lambda traced: None,
) -> TracedCurve[P]:
    """Follow a curve to its end.

    `monitors` may be a function of the curve, whose description may change on the way. `otherwise`
    may return another curve with which an ended one continues, and its first point.
    """
    settings, endings, within = settings or Stepping(), endings or Endings(), None
    traced = TracedCurve(curve, [start], departs)
    try:
        given = first_step() if callable(first_step) else first_step
        step: float | None = given or (STEP.emanating if departs else STEP.first)
        within = _bounds_ahead(traced, step or 0.0, bounds, settings)
        if within is None:
            traced.end, step = endings.left(traced), None
        follower = _Follower(traced, within or bounds, monitors, settings, cap, endings, on_step)
        while step is not None:
            step = follower.advance(step)
            other = otherwise(traced) if step is None else None
            if other is not None:
                traced.curve, traced.points[-1] = other
                traced.end = None
                step = STEP.emanating if departs and len(traced.points) == 1 else STEP.first
    except KeyboardInterrupt:
        traced.end, monitors = endings.interrupted(traced), ()
    _put_back(traced, bounds)
    found = endings.contradiction(traced) if monitors else None
    if found is not None:
        traced.end = endings.contradicted(traced, *found)
    return traced


@dataclass(frozen=True, eq=False)
class _Follower(Generic[P]):
    """A curve while it is followed."""

    traced: TracedCurve[P]
    bounds: Sequence[Bound]
    monitors: Sequence[Monitor[P]] | Callable[[Any], Sequence[Monitor[P]]]
    settings: Stepping
    cap: Callable[[P], float] | None
    endings: Endings[P]
    on_step: Callable[[TracedCurve[P]], None]

    def advance(self, first_step: float) -> float | None:
        """Follow the curve until it ends; return None then.

        If a point between two others cannot be computed, the last step is undone and a shorter one
        is returned. It is shorter than the step that was tried first: a longer one led onto another
        curve. If the description of the curve changes, the next step is returned.
        """
        traced = self.traced
        recent, taken = traced.recent(STEP.memory), len(traced.points) - 1
        monitors = self.monitors(traced.curve) if callable(self.monitors) else self.monitors
        steps = CurveSteps(traced.curve, recent, first_step, self.bounds, self.settings)
        first, ahead, traced.ahead = traced.points[-1], traced.ahead, None
        items: Iterable[P | Failure] = steps.points(self.cap, taken)
        if ahead and ahead.resembles(first) and ahead.arclength - first.arclength > first_step:
            items = [ahead]
        for item in items:
            if isinstance(item, Failure):
                traced.end = self.endings.failed(traced, item)
                return None
            before = traced.points[-1]
            try:
                _extend(traced, item, monitors)
            except BREAKDOWNS as error:
                length = item.arclength - before.arclength
                step = STEP.retreat * (min(length, first_step) if before is first else length)
                if step >= self.settings.steps.smallest:
                    return step
                lost = isinstance(error, LostCurveError)
                reason = str(error) if lost else breakdown(error)
                traced.end = self.endings.failed(traced, Failure("failed", reason))
                return None
            self.on_step(traced)
            if traced.end is None and reaches(item, self.bounds):
                break
            if traced.end is not None:
                predicted = item is ahead or steps.predicted
                traced.ahead = item if predicted and item.piece != before.piece else None
                return None
            try:
                renewed = self._renew()
            except BREAKDOWNS as error:
                traced.end = self.endings.failed(traced, Failure("failed", breakdown(error)))
                return None
            if renewed:
                same = traced.points[-1].resembles(before)  # nothing was computed again
                return float(steps.front.step[0]) if same else item.arclength - before.arclength
            if item is ahead:
                return item.arclength - before.arclength
        traced.end = self.endings.left(traced)
        return None

    def _renew(self) -> bool:
        """Describe the curve in another way if that is better from here on."""
        traced = self.traced
        # Where a curve departs from another one, equations are singular.
        points = traced.points[1:] if traced.departs else traced.points
        renewed = traced.curve.renewed(points) if points else None
        if renewed is None:
            return False
        traced.curve, points = renewed
        # Their distances are other numbers now; the first of them stays where it is.
        known = [item.arclength for item in traced.points[-len(points) :]]
        own = [item.arclength - points[0].arclength + known[0] for item in points]
        traced.points[-len(points) :] = map(_moved, points, own)
        traced.found = [
            replace(item, point=_moved(item.point, np.interp(item.point.arclength, known, own)))
            if item.point.arclength > known[0]
            else item
            for item in traced.found
        ]
        return True


def _moved(point: P, arclength: Any) -> P:
    """Return a point at another place of its curve."""
    return replace(point, arclength=float(arclength))


def _bounds_ahead(
    traced: TracedCurve[P], step: float, bounds: Sequence[Bound], settings: Stepping
) -> Sequence[Bound] | None:
    """Return the bounds of a curve, None if it begins on one and lies beyond it.

    On which side of a bound a curve lies that runs along it is rounding: that bound is moved out.
    """
    start, ahead = traced.points[0], traced.points[0].tangent
    on_one = any(abs(start.z[i] - end) <= STEP.edge for i, *ends in bounds for end in ends)
    if traced.departs and on_one:  # it may run along the bound at first
        first = first_point(traced.curve, start, step, settings)
        if isinstance(first, Failure):
            return None
        ahead = first.z - start.z
    within = []
    for i, low, high in bounds:
        below, above = (abs(start.z[i] - end) <= STEP.edge for end in (low, high))
        if (below and ahead[i] < -STEP.edge) or (above and ahead[i] > STEP.edge):
            return None
        out = 2 * STEP.edge if abs(ahead[i]) <= STEP.edge else 0.0
        within.append((i, low - below * out, high + above * out))
    return within


def _put_back(traced: TracedCurve[P], bounds: Sequence[Bound]) -> None:
    """Put points that lie beyond a bound by a hair back on it: the model may end there as well."""

    def inside(point: P) -> P:
        z = point.z.copy()
        for i, low, high in bounds:
            if low - 3 * STEP.edge < z[i] < high + 3 * STEP.edge:  # moved out by two
                z[i] = min(max(z[i], low), high)
        return point if (z == point.z).all() else replace(point, z=z)

    last = traced.points[-1]
    traced.points = [inside(point) for point in traced.points]
    if traced.end is not None and traced.points[-1] is not last:
        traced.end = replace(traced.end, values=traced.curve.place(traced.points[-1].z))
    traced.found = [replace(item, point=inside(item.point)) for item in traced.found]


def _extend(traced: TracedCurve[P], point: P, monitors: Sequence[Monitor[P]]) -> None:
    """Add a point and all that lies between it and the one before."""
    interval = StepInterval(traced, point, STEP.memory)
    found: list[Found[P]] = []
    stop: Stop[P] | None = None
    for monitor in monitors:
        if interval.empty:
            break
        result = monitor(interval)
        found += result.found
        last = interval.point.arclength
        if result.stop and (stop is None or result.stop.point.arclength < last):
            stop = result.stop
            interval.cut(stop.point)
    # Nothing is stored if an error was raised before.
    last = interval.point.arclength
    within = [item for item in found if item.point.arclength <= last]
    directions = 0 if interval.leaves or not monitors else traced.curve.directions
    if reverses(interval.before, interval.point, within, directions):
        raise LostCurveError("the curve goes back from one point to the next")
    traced.found += sorted(within, key=lambda item: item.point.arclength)
    if not interval.empty:
        traced.points.append(interval.point)
    if stop is not None:
        traced.end, traced.closes = stop.end, stop.closes
        traced.reached = () if stop.reached is None else (stop.reached,)
        traced.points += [] if stop.beyond is None else [stop.beyond]


def reverses(before: P, after: P, found: Sequence[Found[P]], components: int) -> bool:
    """Whether a parameter moves against both tangents of a step without special points."""
    if found or components == 0 or before.piece != after.piece:
        return False
    own = slice(-components, None)
    moved = (after.z - before.z)[own]
    against = (before.tangent[own] * moved < 0) & (after.tangent[own] * moved < 0)
    return bool((against & (abs(moved) > STEP.flat)).any())


def unexplained_reversal(traced: TracedCurve[P]) -> P | None:
    """Return the first point at which a parameter has an extremum that is no special point.

    None where there is none.
    """
    points = list(traced.points)
    if traced.end is not None and traced.end.kind == "closed" and not traced.closes:
        points.pop()  # where another curve begins: it is not computed along this one
    for component in range(-traced.curve.directions, 0):
        for before, extremum, after, rises in _reversals(points, component):
            if traced.departs and before is points[0]:  # its first step is not searched
                continue
            found = (item.point for item in traced.found)
            if not any(
                before.arclength <= item.arclength <= after.arclength
                and rises * (item.z[component] - extremum.z[component]) > -STEP.flat
                for item in found
            ):
                return extremum
    return None


def _reversals(points: Sequence[P], component: int) -> Iterator[tuple[P, P, P, int]]:
    """Yield three points about each extremum of a component, and 1 at a maximum, else -1."""
    direction, last = 0, 0
    for index in range(1, len(points)):
        step: Any = points[index].z[component] - points[index - 1].z[component]
        if points[index].piece != points[index - 1].piece:
            direction = 0  # where pieces meet there may be a corner
        elif abs(step) > STEP.flat:
            if step * direction < 0:
                between = points[last : index + 1]
                heights = [direction * point.z[component] for point in between]
                yield between[0], between[heights.index(max(heights))], between[-1], direction
            direction, last = (1 if step > 0 else -1), index - 1
