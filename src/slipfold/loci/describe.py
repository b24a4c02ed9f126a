"""From what was located on a locus to what is reported."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipfold.branches.seams import NAMES as SEAMS
from slipfold.continuation.search import Found
from slipfold.errors import BREAKDOWNS
from slipfold.loci.locus import CODIMENSION_TWO, COEFFICIENT, LocusPoint
from slipfold.loci.locus_equations import LocusEquations
from slipfold.loci.special_points import TWO_PAIRS, tests_of
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
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
        type=kind,
        name=name,
        kind=orbits.kind,
        model=orbits.model_at(point.z),
        vary=plane_of(orbits),
        values=pair_of(curve, point),
        uncertainty=(np.nan, np.nan),
        period=orbits.period,
        nodes=orbits.evenly(point.z),
        multipliers=orbits.multipliers(point),
        residual=point.residual,
        arclength=point.arclength,
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
    if found.type in CODIMENSION_TWO:
        return found.type, CODIMENSION_TWO[found.type]
    if found.type in SEAMS:
        return found.type, SEAMS[found.type]
    name = plane_of(orbits)[0 if found.type == "first" else 1]
    # The test function is the rate of the parameter along the locus: where it rises through zero
    # the parameter is smallest.
    return ("MIN", f"smallest {name}") if found.slope > 0 else ("MAX", f"largest {name}")


def _coefficients(curve: LocusEquations, point: OrbitPoint, kind: str) -> dict[str, float]:
    if kind in CODIMENSION_TWO:
        try:
            return curve.forms.codimension_two(curve, point, kind)
        except BREAKDOWNS:
            return {}
    value = coefficient_at(curve, point)
    name = COEFFICIENT.get(curve.condition)
    return {name: value} if name is not None and np.isfinite(value) else {}


def _uncertainty(curve: LocusEquations, found: Found) -> tuple[float, float]:
    """How far the point moves when orbit and derivatives are integrated anew with other steps."""
    point = found.point
    if found.type in TWO_PAIRS:  # the equations may mean either pair: neither may be parallel
        first, second = curve.pair_tangents(point.z)
        both = first + (1 if first @ second > 0 else -1) * second
        point = replace(point, tangent=both / np.linalg.norm(both))
    again, _ = recomputed(curve, point)
    if again is None:
        return np.inf, np.inf
    change = max(
        abs(again.tests[test] - point.tests[test]) + abs(point.tests[test])
        for test in tests_of(found.type, point.tests)
    )
    along = change / max(abs(found.slope), 1e-300) * np.abs(point.tangent[-2:])
    moved = (np.abs(again.z[-2:] - point.z[-2:]) + along) * curve.orbits.widths
    moved = np.where(np.isnan(moved), np.inf, moved)
    first, second = moved + np.spacing(np.abs(curve.place(point.z)))
    return float(first), float(second)
