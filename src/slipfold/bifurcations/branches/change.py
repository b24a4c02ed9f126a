"""Replace shooting where a branch cannot continue with it: by collocation or by stick-slip."""

from __future__ import annotations

from dataclasses import replace

from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.switching_boundaries import beyond_boundary
from slipfold.continuation.traced_curve import TracedCurve
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.continued import by_collocation, by_mesh_shooting, through_stick
from slipfold.orbits.orbit_curve import OrbitCurve, OrbitPoint
from slipfold.orbits.shooting import Shooting

FARTHER = 1.02
"""Minimum ratio of branch lengths for collocation to count as having reached farther."""


class Change:
    """Continues a branch where shooting ends: over a mesh, by collocation, or through stick."""

    def __init__(self, settings: Settings, *, through_stick: bool = False) -> None:
        self._through_stick = through_stick and settings.discretization == "automatic"
        self._automatic = settings.discretization == "automatic"
        # What was followed by shooting, and in slip
        self._before: TracedCurve[OrbitPoint] | None = None
        self._slipped: TracedCurve[OrbitPoint] | None = None

    def otherwise(self, traced: TracedCurve[OrbitPoint]) -> tuple[OrbitCurve, OrbitPoint] | None:
        """Return the curve with which an ended branch continues, and its first point; or None."""
        end, last = traced.end, traced.points[-1]
        if not last.curve.orbits.by.smooth:
            beyond = beyond_boundary(traced)
            if beyond is None:
                self._restore_slip(traced)
            return beyond
        if end is not None and end.kind == "limit" and self._through_stick:
            self._slipped = _copy(traced)
            before = traced.points[-2] if len(traced.points) > 1 else None
            found = through_stick(last.curve, last, before)
            if found is not None and found[1].arclength < last.arclength:  # once more from there
                traced.points.pop()
                at = found[1].arclength
                traced.found = [item for item in traced.found if item.point.arclength <= at]
            return found
        if end is None or end.kind not in ("failed", "unresolved"):
            return None
        if not (self._automatic and isinstance(last.curve.orbits.by, Shooting)):
            self._restore(traced)
            return None
        self._before = self._before or _copy(traced)
        for method in (by_mesh_shooting, by_collocation):
            try:
                found = method(last.curve, last)
            except BREAKDOWNS:
                continue
            if found is not None:
                return found
        return None

    def _restore_slip(self, traced: TracedCurve[OrbitPoint]) -> None:
        """Return to the limit of slip if no orbit that sticks was found beyond it."""
        before, end = self._slipped, traced.end
        if before is None or before.end is None or end is None or end.kind != "failed":
            return
        if len(traced.found) > len(before.found):
            return
        reason = f"{before.end.reason}; no orbit was found that continues into stick"
        _return(traced, replace(before, end=replace(before.end, reason=reason)))

    def _restore(self, traced: TracedCurve[OrbitPoint]) -> None:
        """Return to the result of shooting if collocation reached no farther."""
        before = self._before
        if before and traced.points[-1].arclength < FARTHER * before.points[-1].arclength:
            _return(traced, before)


def _copy(traced: TracedCurve[OrbitPoint]) -> TracedCurve[OrbitPoint]:
    return replace(traced, points=list(traced.points), found=list(traced.found))


def _return(traced: TracedCurve[OrbitPoint], before: TracedCurve[OrbitPoint]) -> None:
    """Return to what was followed before."""
    traced.end, traced.points, traced.found = before.end, before.points, before.found
    traced.curve = before.points[-1].curve
