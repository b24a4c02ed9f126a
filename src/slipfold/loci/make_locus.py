"""Loci as data from what was followed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from slipfold.branches.make_branch import evenly, stuck_fractions
from slipfold.continuation.atlas import Chart
from slipfold.continuation.end import End
from slipfold.continuation.search import Found
from slipfold.continuation.trail import Trail
from slipfold.loci.describe import bare_point, coefficient_at, describe_point, pair_of, plane_of
from slipfold.loci.locus import CODIMENSION_TWO, Locus, LocusPoint
from slipfold.orbits.orbit_curve import OrbitPoint

Leads = Mapping[Found, Sequence[int]]

Tell = Callable[[Chart[OrbitPoint], OrbitPoint, int], None]
"""Called with what is described next, the locus that it is on, and how many are done."""


@dataclass
class Described:
    """Normal forms along a locus, as far as they are computed."""

    coefficients: list[float] = field(default_factory=list)
    special: dict[Found, LocusPoint] = field(default_factory=dict)


def as_loci(
    charts: Sequence[Chart[OrbitPoint]], leads: Leads, tell: Tell = lambda chart, point, done: None
) -> tuple[Locus, ...]:
    """Return loci as data; those that an interruption leaves say so, and lack normal forms."""
    known = describe_in_turn(charts, tell)
    return tuple(_as_locus(chart, leads, known.get(chart)) for chart in charts)


def describe_in_turn(
    charts: Sequence[Chart[OrbitPoint]], tell: Tell
) -> dict[Chart[OrbitPoint], Described]:
    """Compute the normal forms along loci in their order, until whoever watches stops it."""
    known: dict[Chart[OrbitPoint], Described] = {}
    done = 0
    try:
        for chart in charts:
            described = Described()
            for point in chart.trail.points:
                tell(chart, point, done)
                described.coefficients.append(coefficient_at(point.curve, point))
                done += 1
            for found in chart.trail.found:
                tell(chart, found.point, done)
                described.special[found] = describe_point(found.point.curve, found)
                done += 1
            known[chart] = described
    except KeyboardInterrupt:
        pass
    return known


def _as_locus(chart: Chart[OrbitPoint], leads: Leads, described: Described | None) -> Locus:
    trail = chart.trail
    curve, points = trail.curve, trail.points
    orbits = curve.orbits
    assert trail.end is not None
    stopped = trail.end
    if described is None:
        if stopped.kind != "interrupted":
            reason = f"{stopped.reason}; interrupted before its coefficients were computed"
            stopped = replace(stopped, kind="interrupted", reason=reason)
        bare = {found: bare_point(found.point.curve, found) for found in trail.found}
        described = Described([np.nan] * len(points), bare)
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
        values=np.array([pair_of(point.curve, point) for point in points]),
        nodes=evenly(points),
        multipliers=np.array([orbits.multipliers(point) for point in points]),
        coefficient=np.array(described.coefficients),
        residual=np.array([point.residual for point in points]),
        arclength=arclength - arclength[0],
        special=tuple(
            replace(
                described.special[found],
                arclength=found.point.arclength - arclength[0],
                leads_to=tuple(leads.get(found, ())),
            )
            for found in trail.found
        ),
        begun=chart.begun or _first_end(trail, chart.start.found),
        stopped=stopped,
        durations=durations,
        stuck_fraction=stuck_fractions(points),
    )


def _first_end(trace: Trail[OrbitPoint], found: Found | None) -> End:
    """Say why a locus that was followed in one direction only begins where it does."""
    assert trace.end is not None
    if trace.end.kind in ("closed", "interrupted"):
        return trace.end
    place = trace.curve.place(trace.points[0].z)
    at = "a point of codimension two"
    if found is not None and found.type in CODIMENSION_TWO:
        at = f"{found.type}, {CODIMENSION_TWO[found.type]}"
    return End("codimension-2", f"the locus begins at {at}", place)
