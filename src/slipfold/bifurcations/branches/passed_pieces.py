"""Changes of contacts, and limits, that orbits meet within a step and not at its ends."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.locate import ZERO, insert, point_at
from slipfold.continuation.search import arclengths_between
from slipfold.continuation.traced_curve import Monitor, MonitorResult, StepInterval
from slipfold.orbits.limits import limit_margins, margins_at
from slipfold.orbits.marginal import MarginalShooting
from slipfold.orbits.near_changes import Margins, margins_of
from slipfold.orbits.orbit_curve import OrbitCurve, OrbitPoint, Orbits
from slipfold.orbits.switched_shooting import SwitchedShooting

BESIDE = 1e-7
"""Arclength over which margins are differentiated."""

NONE = 1e-9
"""Margins that are none at both ends of a step, as where contacts change at once."""

LARGE = 0.5
"""Margins from which one that is known at one end only does not fall to zero in a step."""

BENDS = 4.0
"""Bend of a margin within a step, over that of the last steps, that is reckoned with."""


def with_passed(
    interval: StepInterval[OrbitPoint], ends: Monitor[OrbitPoint]
) -> MonitorResult[OrbitPoint]:
    """Return how the curve ends between its last two known points, or before that within the step.

    What begins and ends within the step is looked for on the way to the end.
    """
    while True:
        result = ends(interval)
        last = interval.point if result.stop is None else result.stop.point
        passed = _passed(interval.traced.curve, interval.history, interval.before, last)
        if passed is None:
            return result
        interval.cut(passed)


def _passed(
    curve: OrbitCurve, history: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint, depth: int = 0
) -> OrbitPoint | None:
    """Return the first point found between two that is of another piece, or breaks a limit.

    Margins are interpolated from values and slopes; where one may come near zero, the point there
    is computed and both halves are searched. Points that are neither join the history. None if
    none is found.
    """
    if isinstance(b.curve.orbits.by, MarginalShooting):  # which meets such a change everywhere
        return None
    known = [item for item in history if item.piece == a.piece and item.arclength < b.arclength]
    s = _doubtful_arclength(known, a, b) if depth < ZERO.depth else None
    if s is None:
        return None
    middle = point_at(curve, [*known, b], s)
    if middle.piece != a.piece or (a.piece is None and not (margins_at(middle) > 0).all()):
        return middle
    insert(history, middle)
    found = _passed(curve, history, a, middle, depth + 1)
    return found or _passed(curve, history, middle, b, depth + 1)


def _margins(orbits: Orbits, z: Array) -> Margins:
    """Return the margins of an orbit: of its contacts, or of the limits of a smooth model."""
    if isinstance(orbits.by, SwitchedShooting):
        return margins_of(orbits.by, orbits.nodes(z), orbits.constants(z))
    return _numbered(limit_margins(orbits, z)[0])


def _numbered(values: Array) -> Margins:
    return Margins(np.arange(float(len(values))), np.zeros(len(values)), values)


def _known(point: OrbitPoint) -> Margins:
    """Return the margins of an orbit, computed once."""
    known = vars(point)
    if point.curve.orbits.by.smooth:
        return _numbered(margins_at(point))
    if "changes" not in known:
        known["changes"] = _margins(point.curve.orbits, point.z)
    return Margins(*known["changes"])


def _rates(point: OrbitPoint, like: Margins, values: Array, beside: float) -> Array:
    """Return the derivatives of margins by arclength, taken from one side, computed once.

    From the other side if there the piece ends. Shapes: values (q,); returns (q,).
    """
    known, orbits = vars(point), point.curve.orbits
    if "changes beside" not in known:
        sides = [(step, point.z + step * point.tangent) for step in (beside, -beside)]
        step, z = next((side for side in sides if orbits.piece(side[1]) == point.piece), sides[0])
        known["changes beside"] = step, _margins(orbits, z)
    step, margins = known["changes beside"]
    return np.asarray((margins.like(like, orbits.period) - values) / step)


def _doubtful_arclength(known: Sequence[OrbitPoint], a: OrbitPoint, b: OrbitPoint) -> float | None:
    """Return where between two points of a piece a margin may be zero, None if none may."""
    period, length = a.curve.orbits.period, b.arclength - a.arclength
    if length < 2 * BESIDE:
        return None
    own, other = _known(a), _known(b)
    new = np.isnan(own.like(other, period))
    items = Margins(*(np.append(x, y[new]) for x, y in zip(own, other, strict=True)))
    first, last = own.like(items, period), other.like(items, period)
    earlier = [item for item in known if item.arclength < a.arclength]
    before, place = np.full(len(first), np.nan), -1.0
    if earlier:
        before = _known(earlier[-1]).like(items, period)
        place = (earlier[-1].arclength - a.arclength) / length
    # A parabola with a zero between both bends by the square of the sum of their roots
    bends = (last - first - (first - before) / -place) / (1 - place)
    zero = first + last + 2 * np.sqrt(np.maximum(first * last, 0.0))
    most = np.fmax(first, last)
    far = np.where(np.isnan(last - first), most > LARGE, zero > BENDS * np.abs(bends))
    near = ~far & (most > (NONE if isinstance(a.curve.orbits.by, SwitchedShooting) else 0.0))
    if not near.any():
        return None
    items = Margins(*(item[near] for item in items))
    first, last, before = first[near], last[near], before[near]
    rising, falling = (
        _rates(point, items, values, beside) * length
        for point, values, beside in ((a, first, BESIDE), (b, last, -BESIDE))
    )
    # Where slopes do not lead from one to the other, these are of two changes, each known alone
    two = np.abs(last - first - (rising + falling) / 2) > 2 * (np.abs(rising) + np.abs(falling))
    none, alone = np.full(np.count_nonzero(two), np.nan), np.where(two, np.nan, last)
    lowest = _lowest(
        np.append(first, none),
        np.append(rising, none),
        np.append(alone, last[two]),
        np.append(np.where(two, np.nan, falling), falling[two]),
        np.append(before, none),
        place,
    )
    return None if lowest is None else a.arclength + lowest * length


def _lowest(
    first: Array, rising: Array, last: Array, falling: Array, before: Array, s: float
) -> float | None:
    """Return where a margin is lowest that may be below zero between two points, None if none may.

    The arclength between both is the unit. Margins and their slopes are given at either, and
    margins at an earlier point s; NaN where they are not known. One that is known at one end only
    is taken to be straight: the middle of where it is below zero is returned. What cubics through
    values and slopes say comes first, then their errors. Shapes: (q,).
    """
    alone, chord = np.isnan(last - first), last - first
    rising, falling = (
        np.where(np.isnan(one), np.where(alone, other, chord), one)
        for one, other in ((rising, falling), (falling, rising))
    )
    dip = np.where(alone, 0.0, ZERO.dip * np.fmin(first, last))
    first, last = (
        np.where(np.isnan(first), last - falling, first),
        np.where(np.isnan(last), first + rising, last),
    )
    square, cubic = 3 * (last - first) - 2 * rising - falling, rising + falling
    cubic -= 2 * (last - first)
    with np.errstate(invalid="ignore", divide="ignore"):
        lowest = -rising / (square + np.sqrt(square**2 - 3 * cubic * rising))
    x = np.tile(arclengths_between(0.0, 1.0)[:, None], len(first))
    x = np.vstack([x, np.where((lowest > 0) & (lowest < 1), lowest, 0.5)])
    inside = first + x * (rising + x * (square + x * cubic))
    # The change that one slope less would make, or the earlier point as well
    beyond = before - (first + s * (rising + s * (square + s * cubic)))
    errors = np.fmin(
        np.abs(cubic) * x * (1 - x) * np.maximum(x, 1 - x),
        np.abs(beyond) * (x * (1 - x) / (s * (1 - s))) ** 2,
    )
    for values in (inside, inside - np.maximum(errors, dip)):
        which = np.where(np.isnan(values), np.inf, values).min(axis=0).argmin()
        below = values[:, which] < 0
        if below.any():
            lowest = x[values[:, which].argmin(), which]
            return float(x[below, which].mean() if alone[which] else lowest)
    return None
