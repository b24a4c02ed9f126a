"""From what was located on a locus to what is reported."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.continuation.newton import correct
from slipfold.continuation.search import Found
from slipfold.errors import BREAKDOWNS
from slipfold.loci.locus import CODIMENSION_TWO, COEFFICIENT, LocusPoint
from slipfold.loci.locus_problem import LocusProblem
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["coefficient_at", "describe_point"]

Array = NDArray[np.float64]


def coefficient_at(problem: LocusProblem, point: OrbitPoint) -> float:
    """Return the coefficient of the bifurcation's normal form, NaN where it is not defined."""
    raw = problem.coefficient(point.tests)
    if not np.isfinite(raw):
        return np.nan
    # It goes with the inverse square of the critical vector's length, in the orbit's own scales.
    try:
        return float(raw / problem.own_length(point) ** 2)
    except BREAKDOWNS:
        return np.nan


def describe_point(problem: LocusProblem, found: Found) -> LocusPoint:
    """Return a located point with its coefficients and its uncertainty."""
    point = found.point
    first, second = map(float, problem.values(point.z))
    values = (first, second)
    kind, name = _named(problem, found)
    return LocusPoint(
        type=kind,
        name=name,
        kind=problem.orbits,
        model=problem.model_at(point.z),
        vary=problem.vary,
        values=values,
        uncertainty=_uncertainty(problem, found),
        period=problem.period,
        nodes=problem.nodes(point.z),
        multipliers=problem.reported_multipliers(point),
        residual=point.residual,
        arclength=point.arclength,
        coefficients=_coefficients(problem, point, found.type),
    )


def _named(problem: LocusProblem, found: Found) -> tuple[str, str]:
    kind = problem.named(found.type)
    if kind in CODIMENSION_TWO:
        return kind, CODIMENSION_TWO[kind]
    name = problem.vary[0 if found.type == "first" else 1]
    # The test function is the rate of the parameter along the locus: where it rises through zero
    # the parameter is smallest.
    return ("MIN", f"smallest {name}") if found.slope > 0 else ("MAX", f"largest {name}")


def _coefficients(problem: LocusProblem, point: OrbitPoint, kind: str) -> dict[str, float]:
    if kind in CODIMENSION_TWO:
        try:
            return problem.codimension_two(point, kind)
        except BREAKDOWNS:
            return {}
    value = coefficient_at(problem, point)
    name = COEFFICIENT.get(problem.type)
    return {name: value} if name is not None and np.isfinite(value) else {}


def _uncertainty(problem: LocusProblem, found: Found) -> tuple[float, float]:
    """How far the point moves when orbit and derivatives are integrated anew with other steps."""
    point = found.point
    other, guess, row = problem.shifted(point.z, point.tangent)
    try:
        correction = correct(other, guess, row)
        if not correction.converged:
            return np.inf, np.inf
        again = other.point(correction, point.arclength)
    except BREAKDOWNS:
        return np.inf, np.inf
    tests = ("first", "second") if found.type == "CPC" else (found.type,)
    change = max(
        abs(again.tests[test] - point.tests[test]) + abs(point.tests[test]) for test in tests
    )
    along = change / max(abs(found.slope), 1e-300) * np.abs(point.tangent[-2:])
    moved = (np.abs(again.z[-2:] - point.z[-2:]) + along) * problem.widths
    first, second = moved + np.spacing(np.abs(problem.values(point.z)))
    return float(first), float(second)
