"""Tori from where they are born to their end."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from slipfold.continuation.end import End
from slipfold.continuation.follow import Endings, follow
from slipfold.continuation.monitor import Zeros
from slipfold.continuation.search import Found
from slipfold.continuation.settings import Stepping
from slipfold.continuation.trail import Sight, Stop, Stretch, Trail
from slipfold.continuation.walk import Failure
from slipfold.tori.circles import MOST, RESONANCES, STRONG, TAIL, CirclePoint
from slipfold.tori.harmonics import tail
from slipfold.tori.locked import locked_interval
from slipfold.tori.past_resonance import past_resonance
from slipfold.tori.torus_branch import Locked

BROKEN = 1e-8
"""Size of the last harmonics, of the largest, at which a circle is no longer resolved."""

LATELY, STANDS_STILL, SLOWER = 3, 1e-6, 0.95
"""Beside a homoclinic orbit the parameter, in spans, stands still along some circles, and they turn
this much more slowly."""

SLOWS = "turns ever more slowly at one value of the parameter, as beside a homoclinic orbit"

BESIDE = 1e-2
"""Distance of a rotation number from a strong resonance at which circles may break by it."""

POINT = 3e-5
"""Extent of a circle in scaled states below which it is an orbit: the parameter is off by its
square, and smaller circles are rounding."""

SHRINKS = "shrinks to a periodic orbit, at a Neimark-Sacker point of it"

FOLD = 1e-6
"""Part of the tangent along the parameter that is left where a fold is located."""


@dataclass(frozen=True, eq=False)
class Tori:
    """Tori as they were followed, and which resonances they passed."""

    trail: Trail[CirclePoint]
    locked: tuple[Locked, ...]


def follow_tori(
    start: CirclePoint,
    span: tuple[float, float],
    settings: Stepping | None = None,
    watch: Callable[[Trail[CirclePoint]], None] = lambda trail: None,
) -> Tori:
    """Follow tori from a circle on, until they end or the parameter leaves its span."""
    circles = start.curve
    trail = follow(
        circles,
        start,
        [(-1, min(span) / circles.width, max(span) / circles.width)],
        lambda curve: (_Special(curve), _Resolved()),
        settings=settings,
        endings=_Endings(),
        otherwise=past_resonance,
        watch=watch,
    )
    trail.end = _beside_strong(trail) or trail.end
    return Tori(trail, tuple(_passed(trail.points)))


def _beside_strong(trail: Trail[CirclePoint]) -> End | None:
    """Return the end of tori that could not be followed past a strong resonance; None of others."""
    end, turns = trail.end, [point.z[-2] for point in trail.points[-2:]]
    if end is None or end.kind not in ("broken", "failed"):
        return None
    strong = [ratio for ratio in RESONANCES if ratio.denominator <= STRONG]
    ratio = min(strong, key=lambda each: abs(turns[-1] - float(each)))
    first, last = (abs(turn - float(ratio)) for turn in (turns[0], turns[-1]))
    if last > min(first, BESIDE):
        return None
    point = trail.points[-1]
    size = tail(point.curve.states(point.z))
    reason = (
        f"not followed past the strong resonance {ratio}, {last:.1g} of a turn away, where circles "
        f"may break; the last harmonics are {size:.0e} of the largest"
    )
    return End("resonance", reason, end.values)


def _passed(points: Sequence[CirclePoint]) -> Iterator[Locked]:
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


class _Special(Zeros[CirclePoint]):
    """Folds of tori and resonances on the way, or at the end: a strong one, or an orbit."""

    def is_genuine(self, found: Found[CirclePoint]) -> bool:
        """Whether a fold is one, and not a turn of the curve's own direction."""
        return found.type != "LP" or abs(found.point.tangent[-1]) < FOLD

    def seen(
        self, found: Sequence[Found[CirclePoint]], stretch: Stretch[CirclePoint]
    ) -> Sight[CirclePoint]:
        """Return what lies between two circles, as far as tori go."""
        for place, item in enumerate(found):
            end = _end_at(item)
            if end is not None:
                return Sight(found[:place], Stop(item.point, end))
        return Sight(found)


def _end_at(found: Found[CirclePoint]) -> End | None:
    """Return why tori end at what was found, None if they go on."""
    place = found.point.curve.place(found.point.z)
    if found.type == "size":
        return End("birth", SHRINKS, place)
    if found.type != "LP" and Fraction(found.type).denominator <= STRONG:
        reason = f"comes to the strong resonance {found.type} and is not followed past it"
        return End("resonance", reason, place)
    return None


class _Resolved:
    """Ends tori whose circles are points, or have more harmonics than can be computed."""

    def watch(self, stretch: Stretch[CirclePoint]) -> Sight[CirclePoint]:
        """Look at how smooth the circle is that was come to."""
        point = stretch.point
        circles = point.curve
        states = circles.states(point.z)
        if np.ptp(states / circles.model.state_scales(), axis=0).max() < POINT:
            return Sight(stop=Stop(point, End("birth", SHRINKS, circles.place(point.z))))
        size = tail(states)
        if circles.count < MOST or size < BROKEN:
            return Sight()
        harmonics = circles.count // 2
        told = f"the last of {harmonics} harmonics are still {size:.0e} of the largest"
        kind, reason = "broken", f"not resolved: {told}; it may break up"
        if _slows([*stretch.trail.points, point]):
            kind, reason = "homoclinic", f"{SLOWS}: {told}"
        # The circle before is the last that is known well.
        last = stretch.before
        end = End(kind, reason, last.curve.place(last.z))
        return Sight(stop=Stop(last, end))


def _slows(points: Sequence[CirclePoint]) -> bool:
    """Whether circles turn ever more slowly while the parameter stands still."""
    recent = points[-LATELY:]
    values = [point.z[-1] for point in recent]
    turns = [point.z[-2] for point in recent]
    return max(values) - min(values) < STANDS_STILL and turns[-1] < SLOWER * turns[0]


class _Endings(Endings[CirclePoint]):
    """How tori end by following them itself."""

    def left(self, trail: Trail[CirclePoint]) -> End:
        """Return the end of tori that came to the end of the span."""
        last = trail.points[-1]
        at = f"{last.curve.vary} = {last.curve.value(last.z):g}"
        return self._end(trail, "span", f"reached the end of the span at {at}")

    def failed(self, trail: Trail[CirclePoint], failure: Failure) -> End:
        """Return the end of tori that could not be followed."""
        last = trail.points[-1]
        size = tail(last.curve.states(last.z))
        told = f"{failure.reason}; its last harmonics are {size:.0e} of the largest"
        return self._end(trail, "broken" if size > TAIL else failure.kind, told)
