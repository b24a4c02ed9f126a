"""From what was located to what is reported: coefficients, criticality, uncertainties."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.crossing import find_crossing
from slipfold.branches.detection import TURNING
from slipfold.branches.equilibrium_form import equilibrium_form
from slipfold.branches.event import Event
from slipfold.branches.normal_form import normal_form
from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.locate import CLOSE
from slipfold.continuation.newton import correct
from slipfold.continuation.search import Found
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.equilibrium_problem import EquilibriumProblem
from slipfold.orbits.floquet import match_multipliers
from slipfold.orbits.orbit_point import OrbitPoint, make_point

__all__ = ["describe_bifurcation", "describe_event"]

Array = NDArray[np.float64]

NAMES = {
    "LP": "fold",
    "PD": "period doubling",
    "NS": "Neimark-Sacker (torus)",
    "BP": "branch point",
    "pitchfork": "pitchfork",
    "transcritical": "transcritical branch point",
    "HB": "Hopf",
}


def describe_bifurcation(problem: PeriodicProblem, found: Found) -> SpecialPoint:
    """Return a located bifurcation with its normal form and its uncertainties.

    Parameters
    ----------
    problem
        The boundary-value problem.
    found
        The bifurcation.
    """
    coefficient, criticality = None, None
    form = _form_of(found)
    if form is not None:
        if isinstance(problem, EquilibriumProblem):
            coefficient, criticality = equilibrium_form(problem, found.point, form)
        else:
            coefficient, criticality = normal_form(problem, found.point, form)
    kind = "HB" if (problem.kind, found.type) == ("equilibrium", "NS") else found.type
    name = NAMES[kind if kind == "HB" else form or kind]
    value_uncertainty, multiplier_uncertainty = _uncertainties(problem, found)
    return _special(
        problem,
        found.point,
        kind,
        name,
        value_uncertainty,
        multiplier_uncertainty,
        criticality,
        coefficient,
    )


def _form_of(found: Found) -> str | None:
    """Return which normal form a bifurcation has; None for a branch point that no branch crosses.

    Where one of the two branches turns, it bends back on both sides: a pitchfork.
    """
    if found.type != "BP":
        return found.type
    if found.other is None:
        return None
    slopes = abs(found.point.tangent[-1]), abs(found.other[-1])
    return "pitchfork" if min(slopes) < TURNING else "transcritical"


def describe_event(problem: PeriodicProblem, event: Event, point: OrbitPoint) -> SpecialPoint:
    """Return a located user's event.

    Parameters
    ----------
    problem
        The boundary-value problem.
    event
        What was looked for.
    point
        The orbit.
    """
    name = f"{event.measure} {event.name} = {event.value:g}"
    again = _anew(problem, point)
    moved, multiplier_uncertainty = np.inf, np.full(len(point.multipliers), np.inf)
    if again is not None:
        moved = abs(again.z[-1] - point.z[-1]) + CLOSE * abs(point.tangent[-1])
        matched = match_multipliers(point.multipliers, again.multipliers)
        multiplier_uncertainty = np.abs(matched - point.multipliers)
    width = problem.width
    return _special(
        problem, point, "EVENT", name, moved * width, multiplier_uncertainty, None, None
    )


def _special(
    problem: PeriodicProblem,
    point: OrbitPoint,
    kind: str,
    name: str,
    uncertainty: float,
    multiplier_uncertainty: Array,
    criticality: str | None,
    coefficient: float | None,
) -> SpecialPoint:
    value = problem.value(point.z)
    return SpecialPoint(
        type=kind,
        name=name,
        model=problem.model_at(point.z),
        vary=problem.vary,
        value=value,
        uncertainty=uncertainty,
        period=problem.period,
        nodes=problem.nodes(point.z),
        multipliers=problem.all_multipliers(point.multipliers),
        multiplier_uncertainty=_padded(multiplier_uncertainty, len(problem.scales)),
        residual=point.residual,
        arclength=point.arclength,
        criticality=criticality,
        coefficient=coefficient,
    )


def _padded(uncertainty: Array, count: int) -> Array:
    """Uncertainties of all multipliers: what is exactly one is certain."""
    return np.concatenate([uncertainty, np.zeros(count - len(uncertainty))])


def _anew(problem: PeriodicProblem, point: OrbitPoint) -> OrbitPoint | None:
    """Compute the same orbit with its nodes, and so every integration step, elsewhere.

    None if that fails: nothing is known of the uncertainty then.
    """
    other, guess, row = problem.shifted(point.z, point.tangent)
    correction = correct(other, guess, row)
    if not correction.converged:
        return None
    return other.point(correction, point.arclength)


def _crossing_anew(problem: PeriodicProblem, point: OrbitPoint) -> OrbitPoint | None:
    """Find the same branch point with its nodes elsewhere: along one branch it is singular."""
    other, guess, row = problem.shifted(point.z, point.tangent)
    start = make_point(guess, row, point.arclength, point.monodromy, point.residual)
    crossing = find_crossing(other, start, row)
    return None if crossing is None else crossing.point


def _uncertainties(problem: PeriodicProblem, found: Found) -> tuple[float, Array]:
    """Uncertainty of the parameter and of the multipliers.

    The parameter is uncertain by how far the orbit moves in it, and by how far along the branch
    the zero of the test function moves: its change over its slope. What the search left over of
    the test function counts as well. A branch point where two branches cross is found anew.
    """
    point = found.point
    again = _crossing_anew(problem, point) if found.other is not None else _anew(problem, point)
    if again is None:
        return np.inf, np.full(len(point.multipliers), np.inf)
    along = 0.0
    if found.other is None:
        test = "fold" if found.type == "BP" else found.type
        change = abs(again.tests[test] - point.tests[test]) + abs(point.tests[test])
        along = change / max(abs(found.slope), 1e-300)
    moved = abs(again.z[-1] - point.z[-1]) + along * abs(point.tangent[-1])
    matched = match_multipliers(point.multipliers, again.multipliers)
    return (
        float(moved) * problem.width + float(np.spacing(abs(problem.value(point.z)))),
        np.abs(matched - point.multipliers),
    )
