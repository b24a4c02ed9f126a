"""What ends a curve of orbits early: limits of the model, too little left to see, a family."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from slipfold.continuation.end import End
from slipfold.continuation.locate import locate
from slipfold.continuation.trail import Sight, Stop, Stretch
from slipfold.orbits.limits import limit_margins
from slipfold.orbits.orbit_curve import OrbitCurve, Orbits
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["STANDS_STILL", "Families", "Limits", "Unresolved"]

FAMILY = 200
"""Orbits with one value of the parameter after which a family is followed no farther."""

NEUTRAL = 1e-4
"""Test function of a fold below which a multiplier is one: all orbits of a family have one."""

STANDS_STILL = 1e-9
"""Change of the parameter, in spans, that is none: special points are located to less, so all that
could still be found would have one and the same value of it."""

LIMIT_CLOSE = 1e-9
"""Arclength to which the end of the model is found: it is a convention within 1e-4 anyway."""

RESOLVED = 1e7
"""Largest multiplier beside which those near the unit circle are still known to five digits."""


class Limits:
    """Ends a curve where the model ceases to be valid."""

    def __init__(self, curve: OrbitCurve) -> None:
        self._curve = curve

    def watch(self, stretch: Stretch[OrbitPoint]) -> Sight[OrbitPoint]:
        """Return where the first of the limits is broken."""
        curve, orbits, cuts = self._curve, self._curve.orbits, []
        for index in np.flatnonzero(~(limit_margins(orbits, stretch.point.z) > 0)):
            limit = orbits.model.limits[index]

            def margin(item: OrbitPoint, index: int = int(index)) -> float:
                return float(limit_margins(orbits, item.z)[index])

            ends = stretch.before, stretch.point
            at = locate(curve, stretch.known, *ends, margin, LIMIT_CLOSE)
            reason = limit.reason.format(value=margin(at) + limit.bound)
            cuts.append(Stop(at, End("limit", reason, curve.place(at.z))))
        return Sight(stop=min(cuts, key=lambda stop: stop.point.arclength, default=None))


class Unresolved:
    """Ends a curve before an orbit too unstable for its multipliers to be known.

    Parameters
    ----------
    curve
        The curve.
    clause
        Says of the points so far where the curve leads, if that is known: it is then the reason.
    """

    def __init__(
        self,
        curve: OrbitCurve,
        clause: Callable[[Sequence[OrbitPoint]], str] = lambda points: "",
    ) -> None:
        self._curve = curve
        self._clause = clause

    def watch(self, stretch: Stretch[OrbitPoint]) -> Sight[OrbitPoint]:
        """Return the last point, if the next one is too unstable."""
        largest = float(np.abs(stretch.point.multipliers).max())
        if largest <= RESOLVED or self._curve.orbits.by.growing:
            return Sight()
        reason = (
            f"a multiplier of {largest:.1e} leaves too few digits for the others, so bifurcations "
            "could be missed beyond; the orbit is as good as unobservable there"
        )
        clause = self._clause(stretch.trail.points)
        kind = "homoclinic" if clause else "unresolved"
        reason = f"{clause}; {reason}" if clause else reason
        end = End(kind, reason, self._curve.place(stretch.point.z))
        return Sight(stop=Stop(stretch.before, end))


class Families:
    """Ends a branch along which the parameter stands still.

    The cycles round a centre form such a family. It may be followed as far as one likes, and
    nothing new happens on it.
    """

    def __init__(self, orbits: Orbits) -> None:
        self._orbits = orbits

    def watch(self, stretch: Stretch[OrbitPoint]) -> Sight[OrbitPoint]:
        """Return the point up to which the parameter stood still for long."""
        orbits, points = self._orbits, [*stretch.trail.points, stretch.point][-FAMILY:]
        values = [point.z[-1] for point in points]
        if len(stretch.trail.points) < FAMILY or max(values) - min(values) > STANDS_STILL:
            return Sight()
        if not _in_family(points):  # through a canard explosion the parameter stands still as well
            return Sight()
        value = orbits.value(points[-1].z)
        shown = 0.0 if abs(value) < STANDS_STILL * orbits.width else value
        reason = (
            f"{FAMILY} orbits have the same {orbits.vary} = {shown:.9g}: they are a family, as "
            "round a centre, that goes on; stop it at an amplitude by an event"
        )
        return Sight(stop=Stop(stretch.point, End("family", reason, (value,))))


def _in_family(points: Sequence[OrbitPoint]) -> bool:
    return all(abs(point.tests["fold"]) < NEUTRAL for point in points)
