"""Loci as data from what was followed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from slipfold.branches.make_branch import evenly
from slipfold.continuation.atlas import Chart
from slipfold.continuation.end import End
from slipfold.continuation.search import Found
from slipfold.continuation.trail import Trail
from slipfold.loci.describe import coefficient_at, describe_point, plane_of
from slipfold.loci.locus import Locus
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["as_locus"]


def as_locus(chart: Chart[OrbitPoint], leads: Mapping[Found, Sequence[int]]) -> Locus:
    """Return a locus as data."""
    trail = chart.trail
    curve, points = trail.curve, trail.points
    orbits = curve.orbits
    assert trail.end is not None
    arclength = np.array([point.arclength for point in points])
    durations = orbits.durations(points)
    return Locus(
        id=chart.number,
        type=curve.condition,
        kind=orbits.kind,
        period=orbits.period,
        parent=chart.start.parent,
        model=orbits.model if durations is None else orbits.model.replace(duration=durations[0]),
        vary=plane_of(orbits),
        values=np.array([orbits.values(point.z) for point in points]),
        nodes=evenly(points),
        multipliers=np.array([orbits.multipliers(point) for point in points]),
        coefficient=np.array([coefficient_at(point.curve, point) for point in points]),
        residual=np.array([point.residual for point in points]),
        arclength=arclength - arclength[0],
        special=tuple(
            replace(
                describe_point(found.point.curve, found),
                arclength=found.point.arclength - arclength[0],
                leads_to=tuple(leads.get(found, ())),
            )
            for found in trail.found
        ),
        begun=chart.begun or _first_end(trail),
        stopped=trail.end,
        durations=durations,
    )


def _first_end(trace: Trail[OrbitPoint]) -> End:
    """Say why a locus that was followed in one direction only begins where it does."""
    assert trace.end is not None
    if trace.end.kind in ("closed", "interrupted"):
        return trace.end
    place = trace.curve.place(trace.points[0].z)
    return End("codimension-2", "born at a point of codimension two", place)
