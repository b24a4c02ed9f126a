"""Loci as data from traced curves, with their points of codimension two described."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from slipfold.bifurcations.branches.events import Happened
from slipfold.bifurcations.branches.make_branch import curve_fields, evenly, point_fields
from slipfold.bifurcations.loci.locus import Locus, LocusPoint
from slipfold.bifurcations.loci.locus_equations import LOCUS, LocusEquations
from slipfold.bifurcations.loci.special_points import STANDING_STILL, on_branch_points, tests_of
from slipfold.continuation.curve_set import FollowedCurve
from slipfold.continuation.end import End
from slipfold.continuation.traced_curve import Found, TracedCurve
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.bifurcation_types import CODIMENSION_TWO, CONTACT_TYPES, POINT_TYPES, TWO_PAIRS
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.periodic_orbit import measured_of
from slipfold.orbits.uncertainty import recomputed


def coefficient_at(curve: LocusEquations, point: OrbitPoint) -> float:
    """Return the coefficient of the bifurcation's normal form, NaN where it is not defined."""
    raw = curve.coefficient(point.tests)
    if not np.isfinite(raw):
        return np.nan
    # It goes with the inverse square of the critical vector's length, in the orbit's own scales.
    try:
        return float(raw / curve.forms.length(curve, point) ** 2)
    except BREAKDOWNS:
        return np.nan


def describe_point(curve: LocusEquations, found: Found) -> LocusPoint:
    """Return a located point with its coefficients and its uncertainty."""
    return replace(
        bare_point(curve, found),
        uncertainty=_uncertainty(curve, found),
        coefficients=_coefficients(curve, found.point, found.type),
    )


def bare_point(curve: LocusEquations, found: Found) -> LocusPoint:
    """Return a located point as it is: its coefficients and its uncertainty take longer."""
    point, orbits = found.point, curve.orbits
    kind, name = _named(orbits, found)
    return LocusPoint(
        **point_fields(found, orbits),
        type=kind,
        name=name,
        kind=orbits.kind,
        vary=plane_of(orbits),
        values=pair_of(curve, point),
        uncertainty=(np.nan, np.nan),
        nodes=orbits.evenly(point.z),
        coefficients={},
        stuck_fraction=orbits.stuck_fraction(point.z),
    )


def plane_of(orbits: Orbits) -> tuple[str, str]:
    """Return the names of the two parameters that vary."""
    first, second = orbits.varied
    return first, second


def pair_of(curve: LocusEquations, point: OrbitPoint) -> tuple[float, float]:
    """Return the values of both."""
    first, second = curve.place(curve.landed(point))
    return first, second


def _named(orbits: Orbits, found: Found) -> tuple[str, str]:
    if isinstance(found, Happened):
        return found.type, found.name
    if found.type in CODIMENSION_TWO:
        return found.type, CODIMENSION_TWO[found.type].title
    if found.type in CONTACT_TYPES:
        return found.type, CONTACT_TYPES[found.type].title
    own = found.point.curve.quantity
    first, second = plane_of(orbits)
    name = {"first": first, "second": second, "measure": own}[found.type]
    # The test function is the rate of a parameter or of the measure along the locus: where it rises
    # through zero that is smallest.
    return ("MIN", f"smallest {name}") if found.slope > 0 else ("MAX", f"largest {name}")


def _coefficients(curve: LocusEquations, point: OrbitPoint, kind: str) -> dict[str, float]:
    if kind in CODIMENSION_TWO:
        try:
            return curve.forms.codimension_two(curve, point, kind)
        except BREAKDOWNS:
            return {}
    value = coefficient_at(curve, point)
    name = POINT_TYPES[curve.condition].coefficient
    return {name: value} if name and np.isfinite(value) else {}


def _uncertainty(curve: LocusEquations, found: Found) -> tuple[float, float]:
    """How far the point moves when orbit and derivatives are integrated again with other steps."""
    point = found.point
    if curve.condition == "LP" and found.type == "LPBP":
        test = "BT" if curve.orbits.kind == "equilibrium" else "R1"
        if regular := on_branch_points(found, curve, test):
            own, there = _uncertainty(*regular), pair_of(regular[0], regular[1].point)
            first, second = np.add(own, np.abs(np.subtract(there, pair_of(curve, point))))
            return float(first), float(second)
    if found.type in TWO_PAIRS:  # the equations may mean either pair: neither may be parallel
        first, second = curve.pair_tangents(point.z)
        both = first + (1 if first @ second > 0 else -1) * second
        point = replace(point, tangent=both / np.linalg.norm(both))
    again, _ = recomputed(curve, point)
    if again is None:
        return np.inf, np.inf
    if isinstance(found, Happened):
        along = found.distance_from(again)
    else:
        tests = tests_of(found.type, point.tests)
        change = max(
            abs(again.tests[test] - point.tests[test]) + abs(point.tests[test]) for test in tests
        )
        if set(tests) <= set(STANDING_STILL):  # less of a slope counts as none
            change = max(change, LOCUS.no_slope)
        along = change / abs(found.slope) if found.slope else np.inf
    with np.errstate(invalid="ignore"):  # an infinite way along a component that is none
        moved = np.abs(again.z[-2:] - point.z[-2:]) + along * np.abs(point.tangent[-2:])
    moved = moved * curve.orbits.widths
    moved = np.where(np.isnan(moved), np.inf, moved)
    first, second = moved + np.spacing(np.abs(curve.place(point.z)))
    return float(first), float(second)


Leads = Mapping[Found, Sequence[int]]

Report = Callable[[FollowedCurve[OrbitPoint], OrbitPoint, int], None]
"""Called with the locus and the point on it that is described next, and how many are done."""


def as_loci(
    curves: Sequence[FollowedCurve[OrbitPoint]],
    leads: Leads,
    report: Report = lambda followed, point, done: None,
) -> tuple[Locus, ...]:
    """Return loci as data; those that an interruption leaves say so, and lack normal forms."""
    coefficients: dict[OrbitPoint, float] = {}
    special: dict[Found, LocusPoint] = {}
    with suppress(KeyboardInterrupt):
        for followed in curves:
            for point in followed.traced.points:
                report(followed, point, len(coefficients) + len(special))
                coefficients[point] = coefficient_at(point.curve, point)
            for result in followed.traced.found:
                report(followed, result.point, len(coefficients) + len(special))
                special[result] = describe_point(result.point.curve, result)
    return tuple(_as_locus(followed, leads, coefficients, special) for followed in curves)


def _as_locus(
    followed: FollowedCurve[OrbitPoint],
    leads: Leads,
    coefficients: Mapping[OrbitPoint, float],
    special: Mapping[Found, LocusPoint],
) -> Locus:
    traced = followed.traced
    curve, points = traced.curve, traced.points
    orbits = curve.orbits
    assert traced.end is not None
    stopped = traced.end
    described = all(point in coefficients for point in points)
    described &= all(result in special for result in traced.found)
    if not described and stopped.kind != "interrupted":
        reason = f"{stopped.reason}; interrupted before its coefficients were computed"
        stopped = replace(stopped, kind="interrupted", reason=reason)
    own = {
        result: special[result] if described else bare_point(result.point.curve, result)
        for result in traced.found
    }
    fields = curve_fields(followed, orbits, points)
    start = fields["arclength"][0]
    locus = Locus(
        **fields | {"arclength": fields["arclength"] - start},
        type=curve.condition,
        quantity=curve.quantity,
        vary=plane_of(orbits),
        values=np.array([pair_of(point.curve, point) for point in points]),
        nodes=evenly(points),
        coefficient=np.array([coefficients[point] if described else np.nan for point in points]),
        special=tuple(
            replace(
                own[result],
                arclength=result.point.arclength - start,
                leads_to=tuple(leads.get(result, ())),
            )
            for result in traced.found
        ),
        started=followed.started or _first_end(traced, followed.start.found),
        stopped=stopped,
    )
    if locus.quantity:
        measure, output = locus.quantity.split(" ", 1)
        heights = (
            replace(each, measured=float(measured_of(each.orbit, measure, output)[0]))
            for each in locus.special
        )
        measured = measured_of(locus, measure, output)
        return replace(locus, special=tuple(heights), measured=measured)
    judged = (replace(each, criticality=locus.criticality_at(each)) for each in locus.special)
    return replace(locus, special=tuple(judged))


def _first_end(trace: TracedCurve[OrbitPoint], found: Found | None) -> End:
    """Say why a locus that was followed in one direction only begins where it does."""
    assert trace.end is not None
    if trace.end.kind in ("closed", "interrupted"):
        return trace.end
    place = trace.curve.place(trace.points[0].z)
    at = "a point of codimension two"
    if found is not None and found.type in CODIMENSION_TWO:
        at = f"{found.type}, {CODIMENSION_TWO[found.type].title}"
    return End("codimension-2", f"the locus begins at {at}", place)
