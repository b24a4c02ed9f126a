"""Branches of tori, from where they emanate or a trajectory converges to one, to their ends."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.progress import branch_progress
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.tori.circles import MAX_ANGLES, RESONANCES, TORUS, tail
from slipfold.bifurcations.tori.resonances import locked_interval, past_resonance
from slipfold.bifurcations.tori.start import circle_from_trajectory, first_circle
from slipfold.bifurcations.tori.surface import growth_across, surface_of
from slipfold.bifurcations.tori.torus_branch import Locked, TorusBranch
from slipfold.continuation.curve import Point
from slipfold.continuation.end import End
from slipfold.continuation.follow import Endings, follow
from slipfold.continuation.locate import LostCurveError
from slipfold.continuation.search import Zeros
from slipfold.continuation.settings import Stepping
from slipfold.continuation.traced_curve import Found, MonitorResult, StepInterval, Stop, TracedCurve
from slipfold.continuation.walk import Failure
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION
from slipfold.orbits.extrema import Extrema
from slipfold.progress import Observer

RECENT, STANDSTILL, SLOWER = 3, 1e-6, 0.95
"""Beside a homoclinic orbit the parameter, in spans, stands still along some circles, and they turn
this much more slowly."""

SLOWS = "turns ever more slowly at one value of the parameter, as near a homoclinic orbit"

SHRINKS = "shrinks to a periodic orbit, at a Neimark-Sacker point of it"


def follow_tori(
    start: Point,
    span: tuple[float, float],
    settings: Stepping | None = None,
    watch: Callable[[TracedCurve[Point]], None] = lambda traced: None,
) -> TracedCurve[Point]:
    """Follow tori from a circle on, until they end or the parameter leaves its span."""
    circles = start.curve
    traced = follow(
        circles,
        start,
        [(-1, min(span) / circles.width, max(span) / circles.width)],
        lambda curve: (resolved, _Special(curve)),
        settings=settings,
        endings=_Endings(),
        otherwise=past_resonance,
        on_step=watch,
    )
    traced.end = _beside_strong(traced) or traced.end
    return traced


def _beside_strong(traced: TracedCurve[Point]) -> End | None:
    """Return the end of tori that could not be followed past a strong resonance; None of others."""
    end, turns = traced.end, [point.z[-2] for point in traced.points[-2:]]
    if end is None or end.kind not in ("broken", "failed"):
        return None
    strong = [ratio for ratio in RESONANCES if ratio.denominator <= TORUS.strong]
    ratio = min(strong, key=lambda each: abs(turns[-1] - float(each)))
    first, last = (abs(turn - float(ratio)) for turn in (turns[0], turns[-1]))
    if last > min(first, TORUS.near_strong):
        return None
    point = traced.points[-1]
    size = tail(point.curve.states(point.z))
    reason = (
        f"not followed past the strong resonance {ratio}, {last:.1g} of a turn away, where circles "
        f"may break; the last harmonics are {size:.0e} of the largest"
    )
    return End("resonance", reason, end.values)


def resonances_passed(points: Sequence[Point]) -> Iterator[Locked]:
    """Yield the resonances between circles, whether or not they were noticed there."""
    for one, other in pairwise(points):
        (before, first), (after, last) = (
            (point.curve.rotation(point.z), point.curve.value(point.z)) for point in (one, other)
        )
        low, high = min(before, after), max(before, after)
        between = [ratio for ratio in RESONANCES if low < ratio < high]
        for ratio in between if before < after else between[::-1]:
            ends = locked_interval(one, other, ratio) or (np.nan, np.nan)
            yield Locked(ratio, first, last, *ends)


class _Special(Zeros[Point]):
    """Folds of tori and resonances on the way, or at the end: a strong one, or an orbit."""

    def is_genuine(self, found: Found[Point]) -> bool:
        """Whether a fold is one, and not a turn of the curve's own direction."""
        return found.type != "LP" or abs(found.point.tangent[-1]) < TORUS.fold

    def seen(
        self, found: Sequence[Found[Point]], interval: StepInterval[Point]
    ) -> MonitorResult[Point]:
        """Return what lies between two circles, as far as tori go."""
        for index, item in enumerate(found):
            end = _end_at(item)
            if end is not None:
                return MonitorResult(found[:index], Stop(item.point, end))
        return MonitorResult(found)


def _end_at(found: Found[Point]) -> End | None:
    """Return why tori end at a located point; None if they continue."""
    place = found.point.curve.place(found.point.z)
    if found.type == "size":
        return End("bifurcation", SHRINKS, place)
    if found.type != "LP" and Fraction(found.type).denominator <= TORUS.strong:
        reason = f"reaches the strong resonance {found.type} and is not followed past it"
        return End("resonance", reason, place)
    return None


def resolved(interval: StepInterval[Point]) -> MonitorResult[Point]:
    """End tori whose circles are points, or have more harmonics than can be computed.

    The orbit itself is a solution, at any rotation number: a step that leads from a circle to
    it at once has left the tori.
    """
    point = interval.point
    circles = point.curve
    states = circles.states(point.z)
    if _extent(point) < TORUS.point:
        if _extent(interval.before) > TORUS.collapse:
            raise LostCurveError("the circle shrinks to a periodic orbit within a step")
        return MonitorResult(stop=Stop(point, End("bifurcation", SHRINKS, circles.place(point.z))))
    size = tail(states)
    if circles.count < MAX_ANGLES or size < TORUS.broken:
        return MonitorResult()
    harmonics = circles.count // 2
    state_text = f"the last of {harmonics} harmonics are still {size:.0e} of the largest"
    kind, reason = "broken", f"not resolved: {state_text}; it may break up"
    if _slows([*interval.traced.points, point]):
        kind, reason = "homoclinic", f"{SLOWS}: {state_text}"
    # The circle before is the last that is known well.
    last = interval.before
    end = End(kind, reason, last.curve.place(last.z))
    return MonitorResult(stop=Stop(last, end))


def _extent(point: Point) -> float:
    """Return the extent of a circle, in scaled states."""
    states = point.curve.states(point.z) / point.curve.model.state_scales()
    return float(np.ptp(states, axis=0).max())


def _slows(points: Sequence[Point]) -> bool:
    """Whether circles turn ever more slowly while the parameter stands still."""
    recent = points[-RECENT:]
    values = [point.z[-1] for point in recent]
    turns = [point.z[-2] for point in recent]
    return max(values) - min(values) < STANDSTILL and turns[-1] < SLOWER * turns[0]


class _Endings(Endings[Point]):
    """How tori end by following them itself."""

    def left(self, traced: TracedCurve[Point]) -> End:
        """Return the end of tori that reached the end of the span."""
        last = traced.points[-1]
        at = f"{last.curve.vary} = {last.curve.value(last.z):g}"
        return self._end(traced, "span", f"reached the end of the span at {at}")

    def failed(self, traced: TracedCurve[Point], failure: Failure) -> End:
        """Return the end of tori that could not be followed."""
        last = traced.points[-1]
        size = tail(last.curve.states(last.z))
        state_text = f"{failure.reason}; its last harmonics are {size:.0e} of the largest"
        return self._end(traced, "broken" if size > TORUS.tail else failure.kind, state_text)


INVARIANT = 1e-8
"""How far a circle may fail to be invariant; what is known less well is left out."""

CHANGES = "contacts stick, turn or open on the orbit, and tori of such orbits are not followed"


def tori_of(
    branches: Sequence[Branch],
    span: tuple[float, float],
    settings: Settings,
    observer: Observer | None = None,
) -> tuple[TorusBranch, ...]:
    """Follow the tori from every Neimark-Sacker point of responses, or of cycles.

    Where contacts change, only the emanating tori are known. Tori that end at another
    Neimark-Sacker point are not followed again from there.
    """
    starts = [
        (branch, point)
        for branch in branches
        for point in branch.special
        if point.type == "NS" and not point.interrupted
    ]
    result: list[TorusBranch] = []
    for done, (branch, point) in enumerate(starts):
        near = TORUS.same * abs(span[1] - span[0])
        if any(
            (tori.stopped.kind, tori.period) == ("bifurcation", point.period)
            and abs(tori.stopped.value - point.value) < near
            for tori in result
        ):
            continue
        number = len(branches) + len(result) + 1
        own = branch.model, point.vary, point.period, branch.id, number
        tori = _Tori(*own, span, settings, observer, done, len(starts))
        result.append(tori.from_point(point))
        if result[-1].interrupted:
            break
    return tuple(result)


def tori_from(
    model: Model,
    vary: str,
    state: ArrayLike | Mapping[str, float],
    span: tuple[float, float],
    settings: Settings,
    observer: Observer | None = None,
) -> tuple[TorusBranch, ...]:
    """Follow the torus to which a trajectory converges, if there is one, in both directions."""
    start = circle_from_trajectory(model, vary, abs(span[1] - span[0]), state)
    if start is None:
        return ()
    backward = replace(start, tangent=-start.tangent, orientation=-start.orientation)
    result: list[TorusBranch] = []
    for circle in (start, backward):
        own = model, vary, start.curve.period, 0, len(result) + 1
        result.append(_Tori(*own, span, settings, observer).from_circle(circle))
        if result[-1].interrupted:
            break
    return tuple(result)


class _Row(NamedTuple):
    """One torus with its measures."""

    arclength: float
    parameter: float
    rotation: float
    circle: Array
    low: Array
    high: Array
    growth: float
    growth_error: float
    truncation: float
    duration: float  # of a revolution of an autonomous model; NaN of a forced one
    omitted: int = 0


@dataclass(eq=False)
class _Tori:
    """A branch of tori while it is followed and described."""

    model: Model
    vary: str
    period: int
    parent: int
    number: int
    span: tuple[float, float]
    settings: Settings
    observer: Observer | None
    # How many of the Neimark-Sacker points are done
    done: int = 0
    total: int = 1
    rows: list[_Row] = field(default_factory=list)

    def from_point(self, point: SpecialPoint) -> TorusBranch:
        """Follow tori from a Neimark-Sacker point, where they have no thickness."""
        extrema, critical = point.orbit.extrema, point.critical_multiplier
        assert critical is not None
        turns = float(np.angle(critical)) / (2 * np.pi)
        ends = extrema.minimum[0], extrema.maximum[0]
        known = point.residual, _duration(point.model)
        self.rows = [_Row(-np.inf, point.value, turns, point.state[None], *ends, 0.0, 0.0, *known)]
        if not np.isnan(point.stuck_fraction):
            return self._as_branch(End("contacts", CHANGES, point.value))
        width = abs(self.span[1] - self.span[0])
        start = first_circle(point.model, point.vary, width, point.state, point.period)
        if start is not None:
            return self.from_circle(start)
        reason = (
            f"no circle was found near the Neimark-Sacker point, which turns by {turns:.6g} of a "
            "turn; look whether it is at a strong resonance"
        )
        return self._as_branch(End("failed", reason, point.value))

    def from_circle(self, start: Point) -> TorusBranch:
        """Follow tori from a circle, and describe them."""
        traced, rows = follow_tori(start, self.span, self.settings, self._report), self.rows
        end = traced.end
        assert end is not None
        try:
            for point in traced.points:
                row, broken = _described(point)
                if broken and rows:
                    end = End("limit", broken, rows[-1].parameter)
                    break
                if row.truncation <= INVARIANT or not rows:
                    rows.append(row)
                else:
                    rows[-1] = rows[-1]._replace(omitted=rows[-1].omitted + 1)
                if end.kind != "interrupted":  # the observer would interrupt again
                    self._report(traced)
            if end.kind == "bifurcation":
                _add_orbit(rows, self.model.state_scales())
            if end.kind in ("bifurcation", "broken", "homoclinic"):  # where they are last known
                end = End(end.kind, end.reason, rows[-1].parameter)
        except KeyboardInterrupt:
            reason = "interrupted; results up to there are kept"
            end = End("interrupted", reason, rows[-1].parameter)
        return self._as_branch(end, traced)

    def _report(self, traced: TracedCurve[Point]) -> None:
        """Report to the observer how far tori have been followed."""
        if self.observer is None:
            return
        last = traced.points[-1]
        value, names = last.curve.value(last.z), tuple(item.type for item in traced.found)
        at = self.number, self.period, len(traced.points), value, names
        parameter = self.model.parameter(self.vary)
        self.observer(branch_progress(parameter, *at, "tori", self.done, self.total))

    def _as_branch(self, end: End, traced: TracedCurve[Point] | None = None) -> TorusBranch:
        rows, folds, locked = self.rows, list[float](), list[Locked]()
        if traced is not None:
            last = rows[-1].arclength
            items = [item.point for item in traced.found if item.type == "LP"]
            folds = [item.curve.value(item.z) for item in items if item.arclength <= last]
            ends = {each.curve.value(each.z): each.arclength for each in traced.points[::-1]}
            passed = resonances_passed(traced.points)
            locked = [item for item in passed if ends[item.last] <= last]
        angles, states = max(len(row.circle) for row in rows), rows[-1].circle.shape[1]
        circles = np.full((len(rows), angles, states), np.nan)
        for own, row in zip(circles, rows, strict=True):
            own[: len(row.circle)] = row.circle

        def column(name: str) -> Array:
            return np.array([getattr(row, name) for row in rows])

        same = ("parameter", "rotation", "growth", "growth_error", "truncation")
        names = flow_of(self.model).output_names
        return TorusBranch(
            **{name: column(name) for name in same},
            id=self.number,
            period=self.period,
            parent=self.parent,
            model=self.model,
            vary=self.vary,
            circles=circles,
            extrema=Extrema(names, column("low"), column("high")),
            omitted=np.array([row.omitted for row in rows]),
            folds=tuple(folds),
            locked=tuple(locked),
            stopped=end,
            durations=None if self.model.forced else column("duration"),
        )


def _add_orbit(rows: list[_Row], scales: Array) -> None:
    """Add the orbit to which tori shrink at their end.

    Parameter and rotation number are linear in the square of their size; of a circle without size
    these are free, and rounding decides.
    """
    squares = [float(np.ptp(row.circle / scales, axis=0).max()) ** 2 for row in rows]
    sized = [place for place, square in enumerate(squares) if square > TORUS.point**2][-2:]
    if len(sized) < 2:
        return
    one, other = sized
    fraction = squares[other] / (squares[one] - squares[other])
    parameter, rotation = (
        (1 + fraction) * getattr(rows[other], name) - fraction * getattr(rows[one], name)
        for name in ("parameter", "rotation")
    )
    last = rows[min(other + 1, len(rows) - 1)]
    del rows[other + 1 :]
    rows.append(last._replace(parameter=parameter, rotation=rotation))


def _duration(model: Model) -> float:
    """Return how long a revolution of an autonomous model lasts, NaN of a forced one."""
    return np.nan if model.forced else model.values[DURATION.name]


def _described(point: Point) -> tuple[_Row, str]:
    """Return a torus with its measures, and the sentence of a limit if it breaks one."""
    circles = point.curve
    parameter, rotation = circles.value(point.z), circles.rotation(point.z)
    states, at = circles.states(point.z), circles.model_at(point.z)
    flow = flow_of(at)
    low, high = surface_of(at, states, rotation, circles.period).extremes()
    lowest = dict(zip(flow.output_names, low, strict=True))
    broken = [
        limit.reason.format(value=lowest[limit.output])
        for limit in at.limits
        if lowest[limit.output] <= limit.bound
    ]
    rates = None
    if not at.forced:
        rates = flow.rates(states, np.zeros(len(states)), flow.constants_of(at))
    across = growth_across(point.linearization.matrices, states, rotation, at.state_scales(), rates)
    growth = float(across.values[0]), float(across.errors[0])
    known = circles.truncation(point.z), _duration(at)
    row = _Row(point.arclength, parameter, rotation, states, low, high, *growth, *known)
    return row, broken[0] if broken else ""
