"""Pieces of a branch that begin and end within a step, so that both its ends lie on one piece."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.locate import ZERO, insert, point_at
from slipfold.continuation.search import arclengths_between
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


def passed_piece(
    curve: OrbitCurve, history: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint, depth: int = 0
) -> OrbitPoint | None:
    """Return the first point of another piece that is found between two of one, None if none is.

    Margins are interpolated from values and slopes; where one may come near zero, the point there
    is computed and both halves are searched. Points of the piece join the history.
    """
    by = b.curve.orbits.by
    if not isinstance(curve, Orbits) or not isinstance(by, SwitchedShooting):
        return None
    if isinstance(by, MarginalShooting):  # which meets such a change everywhere
        return None
    known = [item for item in history if item.piece == a.piece and item.arclength < b.arclength]
    s = _doubtful_arclength(known, a, b) if depth < ZERO.depth else None
    if s is None:
        return None
    middle = point_at(curve, [*known, b], s)
    if middle.piece != a.piece:
        return middle
    insert(history, middle)
    found = passed_piece(curve, history, a, middle, depth + 1)
    return found or passed_piece(curve, history, middle, b, depth + 1)


def _margins(point: OrbitPoint, beside: float = 0.0) -> Margins:
    """Return the margins of an orbit, or of one beside it along the tangent."""
    orbits, z = point.curve.orbits, point.z + beside * point.tangent
    return margins_of(orbits.by, orbits.nodes(z), orbits.constants(z))


def _known(point: OrbitPoint) -> Margins:
    """Return the margins of an orbit, computed once."""
    known = vars(point)
    if "changes" not in known:
        known["changes"] = _margins(point)
    return Margins(*known["changes"])


def _rates(point: OrbitPoint, like: Margins, values: Array, beside: float) -> Array:
    """Return the derivatives of margins by arclength, taken from one side, computed once."""
    known = vars(point)
    if "changes beside" not in known:
        known["changes beside"] = beside, _margins(point, beside)
    step, margins = known["changes beside"]
    return np.asarray((margins.like(like, point.curve.orbits.period) - values) / step)


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
    # A parabola with a zero between both has changed by four times what is left
    change = (np.abs(last - first) + np.abs((first - before) / place)) / 2
    most = np.fmax(first, last)
    far = np.where(np.isnan(last - first), most > LARGE, np.fmin(first, last) > change)
    near = ~far & (most > NONE)
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
    zero = _Between(
        np.append(first, none),
        np.append(rising, none),
        np.append(alone, last[two]),
        np.append(np.where(two, np.nan, falling), falling[two]),
        np.append(before, none),
        place,
    ).zero()
    return None if zero is None else a.arclength + zero * length


class _Between(NamedTuple):
    """Margins at two points, with the arclength between them as unit; shapes (q,)."""

    first: Array  # NaN where only the other is known
    rising: Array  # slopes at the first
    last: Array
    falling: Array  # slopes at the last
    before: Array  # at an earlier point, NaN where they are not known
    place: float  # of that point

    def zero(self) -> float | None:
        """Return the middle of where one may be below zero, None if none may.

        What the cubic through values and slopes says comes first, then its errors.
        """
        alone, chord = np.isnan(self.last - self.first), self.last - self.first
        # A margin that is known at one end only is taken to be straight
        rising, falling = (
            np.where(np.isnan(one), np.where(alone, other, chord), one)
            for one, other in ((self.rising, self.falling), (self.falling, self.rising))
        )
        first = np.where(np.isnan(self.first), self.last - falling, self.first)
        last = np.where(np.isnan(self.last), first + rising, self.last)
        square, cubic = 3 * (last - first) - 2 * rising - falling, rising + falling
        cubic -= 2 * (last - first)
        with np.errstate(invalid="ignore", divide="ignore"):
            lowest = -rising / (square + np.sqrt(square**2 - 3 * cubic * rising))
        x = np.tile(arclengths_between(0.0, 1.0)[:, None], len(first))
        x = np.vstack([x, np.where((lowest > 0) & (lowest < 1), lowest, 0.5)])
        inside = first + x * (rising + x * (square + x * cubic))
        # The change that one slope less would make, or the earlier point as well
        s = self.place
        beyond = self.before - (first + s * (rising + s * (square + s * cubic)))
        errors = np.fmin(
            np.abs(cubic) * x * (1 - x) * np.maximum(x, 1 - x),
            np.abs(beyond) * (x * (1 - x) / (s * (1 - s))) ** 2,
        )
        dip = np.where(alone, 0.0, ZERO.dip * np.fmin(self.first, self.last))
        for values in (inside, inside - np.maximum(errors, dip)):
            which = np.where(np.isnan(values), np.inf, values).min(axis=0).argmin()
            below = values[:, which] < 0
            if below.any():
                return float(x[below, which].mean())
        return None
