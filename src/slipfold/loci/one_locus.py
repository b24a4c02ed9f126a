"""One locus in one direction, from a point of it to its end: what is watched along it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from slipfold.branches.change import Change, Growing
from slipfold.branches.closed_branches import Returns, has_copy, step_beside_parent
from slipfold.branches.ends import failure_reason
from slipfold.branches.seams import Seams
from slipfold.branches.settings import Settings
from slipfold.branches.stops import Limits, Unresolved
from slipfold.continuation.end import End
from slipfold.continuation.follow import Endings, follow
from slipfold.continuation.monitor import Monitor
from slipfold.continuation.trail import Trail
from slipfold.continuation.walk import Failure
from slipfold.loci.births import EndsAtParent, ends_beside_parent
from slipfold.loci.describe import pair_of, plane_of
from slipfold.loci.locus_equations import LocusEquations
from slipfold.loci.special_points import SpecialPoints
from slipfold.loci.start import FIRST
from slipfold.loci.window import Window
from slipfold.orbits.orbit_curve import OrbitPoint
from slipfold.orbits.test_functions import PAIRED

UNDAMPED = 1e-6
"""Distance from the unit circle within which multipliers beside the critical ones are on it."""


def trace_locus(
    curve: LocusEquations,
    start: OrbitPoint,
    window: Window,
    settings: Settings,
    *,
    born: bool = False,
    first_step: float = FIRST,
    watch: Callable[[Trail[OrbitPoint]], None] = lambda trail: None,
    through_stick: bool = False,
) -> Trail[OrbitPoint]:
    """Follow a locus in the direction of its tangent, to its end."""
    orbits, change = curve.orbits, Change(settings, through_stick=through_stick)
    return follow(
        curve,
        start,
        orbits.bounds(*window),
        lambda curve: [
            *_monitors(curve, settings),
            *([Growing(curve)] if change.may_come(curve) else []),
        ],
        settings=settings,
        departs=born,
        first_step=first_step,
        cap=step_beside_parent if has_copy(orbits) else None,
        endings=_LocusEndings(window, settings),
        otherwise=change.otherwise,
        watch=watch,
    )


def _monitors(curve: LocusEquations, settings: Settings) -> list[Monitor[OrbitPoint]]:
    """What is watched along a locus: what ends it early first, what takes longest last."""
    monitors: list[Monitor[OrbitPoint]] = [Seams(curve), Unresolved(curve)]
    if has_copy(curve.orbits):
        monitors.append(EndsAtParent(curve, settings))
    return [
        *monitors,
        Returns(curve, "the locus closed on itself"),
        Limits(curve),
        SpecialPoints(curve),
    ]


class _LocusEndings(Endings[OrbitPoint]):
    """The ends of loci in words."""

    def __init__(self, window: Window, settings: Settings) -> None:
        self._window = window
        self._settings = settings

    def left(self, trail: Trail[OrbitPoint]) -> End:
        """Return the end of a locus that left the window."""
        curve, last = trail.curve, trail.points[-1]
        gaps = [
            min(abs(last.z[place] - low), abs(high - last.z[place]))
            for place, low, high in curve.orbits.bounds(*self._window)
        ]
        nearest = gaps.index(min(gaps))
        edge = curve.place(last.z)[nearest]
        reason = f"left the window at {plane_of(curve.orbits)[nearest]} = {edge:g}"
        return End("window", reason, pair_of(curve, last))

    def failed(self, trail: Trail[OrbitPoint], failure: Failure) -> End:
        """Return the end of a locus that could not be followed."""
        curve, last = trail.curve, trail.points[-1]
        stop = ends_beside_parent(curve, last, self._settings)
        if stop is not None and stop.beyond is not None:
            trail.points.append(stop.beyond)
            trail.reached = (stop.reached,)
            return stop.end
        kind, reason = failure_reason(curve.orbits, last, failure)
        on_circle = int(np.count_nonzero(np.abs(np.abs(last.multipliers) - 1) < UNDAMPED))
        if on_circle > (2 if curve.condition in PAIRED else 1):
            reason = (
                f"{on_circle} multipliers lie on the unit circle there, as where nothing damps, "
                f"and which of them crosses it is not defined ({reason})"
            )
        return End(kind, reason, pair_of(curve, last))
