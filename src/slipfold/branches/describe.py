"""Description of located points: coefficients, criticality, uncertainties."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.bifurcations import TURNING
from slipfold.branches.branch_point import Crossing, find_crossing
from slipfold.branches.events import Happened
from slipfold.branches.seams import NAMES as SEAMS
from slipfold.branches.seams import FoundTouch
from slipfold.branches.settings import Event
from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.locate import CLOSE
from slipfold.continuation.pieces import CLOSE as SEAM_CLOSE
from slipfold.continuation.traced_curve import Found
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.continued import locate_marginal_stops
from slipfold.orbits.normal_forms.forms import forms_of
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.reversal import ReversalShooting
from slipfold.orbits.test_functions import evaluate_tests, floquet_multipliers, match_multipliers
from slipfold.orbits.uncertainty import SPREAD, multiplier_change, recomputed

DIFFERENCED = 1e-6
"""Arclength over which multipliers are differenced: six digits of their rates are left."""

NAMES = {
    "LP": "fold",
    "PD": "period doubling",
    "NS": "Neimark-Sacker (torus)",
    "BP": "branch point",
    "pitchfork": "pitchfork",
    "transcritical": "transcritical branch point",
    "HB": "Hopf",
}

AT_ONCE = 1e-9
"""Arclength beside a place where changes meet, or stick begins, within which they are at once: an
interval between them shorter than 1e-11 of a period is not distinguished from none."""


def describe(found: Found) -> SpecialPoint:
    """Return what was located with its normal form and its uncertainties."""
    orbits = found.point.curve
    if isinstance(found, Happened) and found.event is not None:
        return _describe_event(orbits, found)
    return describe_bifurcation(orbits, found)


def describe_bifurcation(orbits: Orbits, found: Found) -> SpecialPoint:
    """Return a located bifurcation with its normal form and its uncertainties."""
    if found.type in SEAMS:
        return _describe_seam(orbits, found)
    coefficient, criticality = _coefficient(orbits, found.point, _form_of(found))
    special = replace(
        _uncertain(found, *_uncertainties(orbits, found)),
        criticality=criticality,
        coefficient=coefficient,
    )
    # The normal form is that of one direction; what holds in a plane of them is not known.
    return replace(special, criticality=None, coefficient=None) if special.several else special


def _describe_seam(orbits: Orbits, found: Found) -> SpecialPoint:
    """Return a place where contacts begin or cease to do something; nothing is critical there."""
    point = found.place.nearest if isinstance(found, FoundTouch) else found.point
    solved = isinstance(orbits.orbits.by, ReversalShooting)
    again, rounding = _solved_again(orbits, point) if solved else recomputed(orbits, point)
    moved, uncertain = np.inf, np.full(len(point.multipliers), np.inf)
    if again is not None:
        moved = SPREAD * abs(again.z[-1] - point.z[-1]) + rounding
        if not solved:
            moved += SEAM_CLOSE + (AT_ONCE if found.type in ("MEET", "STICK") else 0.0)
        if isinstance(found, FoundTouch):
            moved += float(found.place.error[-1])
        uncertain = multiplier_change(point.multipliers, again.multipliers, point.monodromy)
    return _uncertain(found, moved * orbits.width, uncertain)


def _solved_again(orbits: Orbits, point: OrbitPoint) -> tuple[OrbitPoint | None, float]:
    """Return marginal stops found again with other steps, and what is left of the equations."""
    other, moved, row = orbits.shifted(point.z, point.tangent)
    beside = other.derived_point(moved, row, point.arclength, point.monodromy, point.residual)
    again = locate_marginal_stops(other, beside)
    left = point.residual + (np.inf if again is None else again.residual)
    return again, left + float(np.spacing(abs(point.z[-1])))


def _coefficient(
    orbits: Orbits, point: OrbitPoint, form: str | None
) -> tuple[float | None, str | None]:
    """Return coefficient and criticality; None where the higher derivatives do not exist."""
    if form is None or not orbits.by.smooth:
        return None, None
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # along a canard all numbers are left
            coefficient, criticality = forms_of(orbits).special(orbits, point, form)
    except BREAKDOWNS:
        return None, None
    return (coefficient, criticality) if np.isfinite(coefficient) else (None, None)


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


def _describe_event(orbits: Orbits, found: Found) -> SpecialPoint:
    """Return a located user's event."""
    point = found.point
    again, rounding = recomputed(orbits, point)
    moved, multiplier_uncertainty = np.inf, np.full(len(point.multipliers), np.inf)
    if again is not None:
        moved = abs(again.z[-1] - point.z[-1]) + CLOSE * abs(point.tangent[-1]) + rounding
        multiplier_uncertainty = multiplier_change(
            point.multipliers, again.multipliers, point.monodromy
        )
    return _uncertain(found, moved * orbits.width, multiplier_uncertainty)


def bare(found: Found) -> SpecialPoint:
    """Return what was located as it is: its normal form and its uncertainties take longer."""
    orbits, point = found.point.curve, found.point
    everything = orbits.multipliers(point)
    kind, name = _named(found)
    return SpecialPoint(
        type=kind,
        name=name,
        model=orbits.model_at(point.z),
        vary=orbits.vary,
        value=orbits.value(point.z),
        uncertainty=np.nan,
        period=orbits.period,
        nodes=_nodes(found),
        multipliers=everything,
        multiplier_uncertainty=np.full(len(everything), np.nan),
        residual=point.residual,
        arclength=point.arclength,
        stuck_fraction=_stuck_fraction(found),
    )


def _nodes(found: Found) -> Array:
    """Return the states of what was located at equidistant phases, shape (M, n)."""
    point = found.point
    if not isinstance(found, FoundTouch):
        return np.asarray(point.curve.orbits.evenly(point.z))
    nodes = [item.curve.orbits.evenly(item.z) for item in found.place.points]
    return np.tensordot(found.place.weights, nodes, 1)


def _stuck_fraction(found: Found) -> float:
    """Return the share of the period in which a contact sticks: what vanishes there has none."""
    point = found.point
    if not isinstance(found, FoundTouch):
        return point.curve.orbits.stuck_fraction(point.z)
    place = found.place
    known = [item.curve.orbits.stuck_fraction(item.z) for item in place.points]
    return float(np.polynomial.polynomial.polyfit(np.sqrt(place.left), known, 1)[0])


def _named(found: Found) -> tuple[str, str]:
    if isinstance(found, Happened) and found.event is not None:
        event: Event = found.event
        return "EVENT", f"{event.measure} {event.name} = {event.value:g}"
    if found.type in SEAMS:
        return found.type, SEAMS[found.type]
    return found.type, NAMES[_form_of(found) or found.type]


def _uncertain(found: Found, uncertainty: float, multiplier_uncertainty: Array) -> SpecialPoint:
    """Return what was located with its uncertainties; what is not a number is not known."""
    return replace(
        bare(found),
        uncertainty=np.inf if np.isnan(uncertainty) else uncertainty,
        multiplier_uncertainty=_padded(found.point, multiplier_uncertainty),
    )


def _padded(point: OrbitPoint, uncertainty: Array) -> Array:
    """Uncertainties of all multipliers, in their order: what is exactly one is certain."""
    everything = point.curve.orbits.multipliers(point)
    missing = len(everything) - len(uncertainty)
    certain = int(np.count_nonzero(np.abs(point.multipliers) > 1))
    return np.insert(uncertainty, [certain] * missing, 0.0)


def _crossing_again(orbits: Orbits, point: OrbitPoint) -> Crossing | None:
    """Find the same branch point with its nodes elsewhere: along one branch it is singular."""
    other, guess, row = orbits.shifted(point.z, point.tangent)
    start = other.derived_point(guess, row, point.arclength, point.monodromy, point.residual)
    return find_crossing(other, start, row)


def _uncertainties(orbits: Orbits, found: Found) -> tuple[float, Array]:
    """Uncertainty of the parameter and of the multipliers, infinite where nothing is known."""
    try:
        return _recomputed(orbits, found)
    except BREAKDOWNS:
        return np.inf, np.full(len(found.point.multipliers), np.inf)


def _recomputed(orbits: Orbits, found: Found) -> tuple[float, Array]:
    """Uncertainty of the parameter and of the multipliers, from computing all of it again.

    The parameter is uncertain by how far the orbit moves in it, and by how far along the branch
    the zero of the test function moves: its change over its slope. What the search left over of
    the test function counts as well. A branch point where two branches cross is computed again; how
    far rounding may move it along them moves the multipliers too.
    """
    point, other = found.point, found.other
    if other is None:
        again, rounding = recomputed(orbits, point)
    else:
        crossing = _crossing_again(orbits, point)
        again = None if crossing is None else crossing.point
    if again is None:
        return np.inf, np.full(len(point.multipliers), np.inf)
    uncertain = multiplier_change(point.multipliers, again.multipliers, point.monodromy)
    if not np.isfinite(uncertain).all():
        return np.inf, np.full(len(uncertain), np.inf)
    if other is None:
        test = "fold" if found.type == "BP" else found.type
        change = abs(again.tests[test] - point.tests[test]) + abs(point.tests[test])
        change = max(change, _blurred(test, point, uncertain))
        along = change / max(abs(found.slope), 1e-300)
        rounding += along * abs(point.tangent[-1])
        uncertain = uncertain + along * _multiplier_rates(orbits, point, point.tangent)
    else:
        assert crossing is not None
        rounding = crossing.rounding
        for direction in (point.tangent, other):
            uncertain = uncertain + crossing.blurred * _multiplier_rates(orbits, point, direction)
    moved = SPREAD * abs(again.z[-1] - point.z[-1]) + rounding
    value = orbits.value(point.z)
    largest = max(abs(value), orbits.width)
    return float(moved) * orbits.width + float(np.spacing(largest)), uncertain


def _multiplier_rates(orbits: Orbits, point: OrbitPoint, direction: Array) -> Array:
    """Return by how much each multiplier changes along a branch, a unit of arclength."""
    beside = orbits.linearize(point.z + DIFFERENCED * direction)
    others = match_multipliers(point.multipliers, floquet_multipliers(beside.monodromy))
    return np.asarray(np.abs(others - point.multipliers) / DIFFERENCED, dtype=float)


def _blurred(test: str, point: OrbitPoint, uncertain: Array) -> float:
    """Return how much a test function changes while its multipliers move by what is uncertain."""
    if test == "LP":  # it is not a function of the multipliers
        return 0.0
    values = point.multipliers
    outward = values + uncertain * values / np.maximum(np.abs(values), 1e-300)
    there, here = (evaluate_tests(each, (test,))[test] for each in (outward, values))
    return abs(there - here)
