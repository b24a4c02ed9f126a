"""Branches as data from traced curves, with their special points described."""

from __future__ import annotations

from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import groupby, islice
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.bifurcations.branches.bifurcations import BIFURCATION, SeveralCritical
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.branch_point import find_crossing
from slipfold.bifurcations.branches.events import Happened
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.branches.standing import Collision
from slipfold.bifurcations.branches.switching_boundaries import (
    FoundGrazing,
    FoundMeeting,
    left_to_change,
)
from slipfold.continuation.curve_set import FollowedCurve
from slipfold.continuation.end import End
from slipfold.continuation.locate import ZERO, corrected_together
from slipfold.continuation.pieces import PIECE
from slipfold.continuation.traced_curve import Found
from slipfold.errors import BREAKDOWNS
from slipfold.flow.batches import LANES
from slipfold.flow.flow import flow_of
from slipfold.flow.modes import Mode
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES, COLLISIONS, CONTACT_TYPES, PAIRED
from slipfold.orbits.continued import locate_marginal_stops, solve_marginal
from slipfold.orbits.extrema import TOGETHER, Extrema
from slipfold.orbits.marginal import MarginalShooting
from slipfold.orbits.normal_forms.forms import forms_of
from slipfold.orbits.normal_forms.normal_form import Form, solved_forms
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.switched_shooting import WAYS, SwitchedShooting
from slipfold.orbits.test_functions import ALIKE, evaluate_tests, match_multipliers
from slipfold.orbits.uncertainty import (
    SPREAD,
    Again,
    Request,
    answers_of,
    change_at,
    recomputed,
    what_is_common,
)
from slipfold.text import certain

AT_ONCE = 1e-9
"""Arclength beside a place where changes meet, or stick begins, within which they are at once: an
interval between them shorter than 1e-11 of a period is not distinguished from none."""


def describe(results: Sequence[Found]) -> list[SpecialPoint]:
    """Return located points with normal forms and uncertainties; what is alike is one batch."""
    searches = [_uncertainties(item) for item in results]
    known = corrected_together(searches, answers_of, BREAKDOWNS)
    each = list[SpecialPoint]()
    for found, own in zip(results, known, strict=True):
        moved, uncertain = _unknown(found.point) if isinstance(own, Exception) else own
        moved = np.inf if np.isnan(moved) else moved  # what is not a number is not known
        each.append(bare(found, moved, _padded(found.point, uncertain)))
    return with_normal_forms(results, each)


def _unknown(point: OrbitPoint) -> tuple[float, Array]:
    """Uncertainties of the parameter and of the multipliers where nothing is known."""
    return np.inf, np.full(len(point.multipliers), np.inf)


def with_normal_forms(results: Sequence[Found], each: Sequence[SpecialPoint]) -> list[SpecialPoint]:
    """Return located bifurcations with their criticality.

    The normal form is that of one direction; what holds in a plane of them is not known.
    """
    forms = [_coefficient(item.point.curve, item.point, _form_of(item)) for item in results]
    return [
        special if special.several else replace(special, coefficient=known[0], criticality=known[1])
        for special, known in zip(each, solved_forms(forms), strict=True)
    ]


def _nowhere_critical(found: Found) -> tuple[float, Array]:
    """Return the uncertainties of an event, or of where contacts begin or cease to do something."""
    orbits, point, changes = found.point.curve, found.nearest, found.type in CONTACT_TYPES
    met = changes and isinstance(orbits.by, MarginalShooting)
    again, rounding = _met_again(orbits, point) if met else recomputed(orbits, point)
    if again is None:
        return _unknown(point)
    moved = (SPREAD if changes else 1.0) * abs(again.z[-1] - point.z[-1]) + rounding
    if isinstance(found, Happened):
        moved += found.distance_from(again) * abs(point.tangent[-1])
    elif isinstance(found, FoundMeeting):
        moved += PIECE.close + found.unsure
    elif not met:
        moved += PIECE.close + left_to_change(point, found.type)
        moved += AT_ONCE if found.type in ("MEET", "STICK") else 0.0
    if isinstance(found, FoundGrazing):
        moved += float(found.place.error[-1]) + abs(found.place.z[-1] - found.point.z[-1])
    return float(moved) * orbits.width, change_at(point, again)


def _met_again(orbits: Orbits, point: OrbitPoint) -> tuple[OrbitPoint | None, float]:
    """Return changes of contacts that are only just met, found again with other steps.

    Also what errors of steps can do to the parameter.
    """
    other, moved, row = orbits.shifted(point.z, point.tangent)
    beside = other.derived_point(moved, row, point.arclength, point.monodromy, point.residual)
    by = other.by
    assert isinstance(by, MarginalShooting)
    stops = by.met.stops is not None
    again = locate_marginal_stops(other, beside) if stops else solve_marginal(other, beside, [by])
    if again is None:
        return None, np.inf
    return again.point, again.rounding


def _coefficient(
    orbits: Orbits, point: OrbitPoint, form: str | None
) -> Form[tuple[float | None, str | None]]:
    """Find coefficient and criticality; None where the higher derivatives do not exist."""
    by, spans = orbits.by, list[tuple[float, float, Mode]]()
    if form and orbits.free_phase and isinstance(by, SwitchedShooting):
        spans = by.spans(orbits.nodes(point.z), orbits.constants(point.z))
    if form is None or len(spans) > 1 or any(not {*WAYS}.issuperset(mode) for *_, mode in spans):
        return None, None
    with suppress(*BREAKDOWNS):
        coefficient, criticality = yield from forms_of(orbits).special(orbits, point, form)
        if np.isfinite(coefficient):
            return coefficient, criticality
    return None, None


def _form_of(found: Found) -> str | None:
    """Return which normal form a point has; None where it has none, or it is not known.

    Where one of the two branches turns, it bends back on both sides: a pitchfork.
    """
    if found.type != "BP":
        return found.type if found.type in BIFURCATION_TYPES else None
    if found.other is None:
        return None
    slope = min(abs(found.point.tangent[-1]), abs(found.other[-1]))
    if found.unsure > max(slope, BIFURCATION.turning):
        return None
    return "pitchfork" if slope < BIFURCATION.turning else "transcritical"


def bare(
    found: Found, uncertainty: float = np.nan, multiplier_uncertainty: Array | float = np.nan
) -> SpecialPoint:
    """Return what was located as it is: its normal form and its uncertainties take longer."""
    orbits, point = found.point.curve, found.point
    kind, name = _named(found)
    fields = point_fields(found, orbits)
    return SpecialPoint(
        **fields,
        type=kind,
        name=name,
        vary=orbits.vary,
        value=orbits.value(point.z),
        uncertainty=uncertainty,
        nodes=_nodes(found),
        multiplier_uncertainty=np.full(len(fields["multipliers"]), multiplier_uncertainty),
        stuck_fraction=_stuck_fraction(found),
        images=found.images if isinstance(found, SeveralCritical) else 0,
        rare=found.rare if isinstance(found, SeveralCritical) else 0,
        angle=_critical_angle(found),
    )


def _critical_angle(found: Found) -> float:
    """Return the angle of what is critical where others stand; NaN where none, or one of those."""
    point = found.point
    standing = point.curve.orbits.standing
    if standing is None or found.type not in PAIRED:
        return np.nan
    upper = point.multipliers[point.critical(found.type)[:1]]
    beside = np.abs(standing.turning - upper).min() <= ALIKE
    return np.nan if beside or not len(upper) else float(np.angle(upper[0]))


def _nodes(found: Found) -> Array:
    """Return the states of what was located at equidistant phases, shape (M, n)."""
    point = found.point
    if not (isinstance(found, FoundGrazing) and found.extrapolated):
        return np.asarray(point.curve.orbits.evenly(point.z))
    nodes = [item.curve.orbits.evenly(item.z) for item in found.place.points]
    return np.tensordot(found.place.weights, nodes, 1)


def _stuck_fraction(found: Found) -> float:
    """Return the fraction of the period in which a contact sticks: what vanishes there has none."""
    point = found.point
    if not (isinstance(found, FoundGrazing) and found.extrapolated):
        return point.curve.orbits.stuck_fraction(point.z)
    place = found.place
    known = [item.curve.orbits.stuck_fraction(item.z) for item in place.points]
    return float(np.polynomial.polynomial.polyfit(np.sqrt(place.left), known, 1)[0])


def _named(found: Found) -> tuple[str, str]:
    if isinstance(found, Happened):
        return found.type, found.name
    if found.type in CONTACT_TYPES:
        return found.type, CONTACT_TYPES[found.type].title
    if isinstance(found, Collision):
        return found.type, COLLISIONS[found.type]
    form = _form_of(found) or ("BP" if found.other is None else "pitchfork or transcritical")
    if form in BIFURCATION_TYPES:
        return found.type, BIFURCATION_TYPES[form].title
    return found.type, form if form == "pitchfork" else f"{form} branch point"


def _padded(point: OrbitPoint, uncertainty: Array) -> Array:
    """Uncertainties of all multipliers, in their order: what is exactly one is certain."""
    everything = point.curve.orbits.multipliers(point)
    missing = len(everything) - len(uncertainty)
    certain = int(np.count_nonzero(np.abs(point.multipliers) > 1))
    return np.insert(uncertainty, [certain] * missing, 0.0)


def _crossing_again(orbits: Orbits, point: OrbitPoint) -> tuple[Again | None, float]:
    """Find the same branch point with its nodes elsewhere: along one branch it is singular.

    Also how far along the branches rounding may move it.
    """
    other, guess, row = orbits.shifted(point.z, point.tangent)
    start = other.derived_point(guess, row, point.arclength, point.monodromy, point.residual)
    crossing = find_crossing(other, start, row)
    if crossing is None:
        return None, np.inf
    there = crossing.point
    again = Again(there.z[-1], there.multipliers, there.tests, crossing.rounding)
    return again, crossing.blurred


T = TypeVar("T")

Uncertainties = Generator[Request, Any, T]
"""A computation that is sent what it requests of points that are computed again."""


def _uncertainties(found: Found) -> Uncertainties[tuple[float, Array]]:
    """Find the uncertainty of the parameter and of the multipliers, from computing all of it again.

    The parameter is uncertain by how far the orbit moves in it, and by how far along the branch
    the zero of the test function moves: its change over its slope. What the search left over of
    the test function counts as well. A branch point where two branches cross is computed again; how
    far rounding may move it along them moves the multipliers too.
    """
    point, other, orbits = found.point, found.other, found.point.curve
    if found.type not in BIFURCATION_TYPES:
        return _nowhere_critical(found)
    if isinstance(found, SeveralCritical):  # Newton's method is singular there
        along = found.error + ZERO.close
        moved = along * abs(point.tangent[-1])
        rates = yield from _multiplier_rates(point, point.tangent)
        return moved * orbits.width, along * rates
    if other is None:
        again = yield point, None
    else:
        again, blurred = _crossing_again(orbits, point)
    if again is None:
        return _unknown(point)
    rounding = again.rounding
    uncertain = change_at(point, again)
    if found.slope == 0 or not np.isfinite(uncertain).all():
        return _unknown(point)
    if other is None:
        if isinstance(found, Collision):  # two that meet are known to the root of what it is
            here, there = map(found.test, (point.multipliers, again.multipliers))
            blurred = SPREAD * (abs(here) + abs(there - here) + found.rounding)
        else:
            test = "fold" if found.type == "BP" else found.type
            here, there = point.tests[test], again.tests[test]
            blurred = _blurred(test, point, uncertain)
        change = max(SPREAD * abs(there - here) + abs(here), blurred)
        along = change / abs(found.slope)
        rounding += along * abs(point.tangent[-1])
        rates = yield from _multiplier_rates(point, point.tangent)
        uncertain = uncertain + along * rates
    else:
        for direction in (point.tangent, other):
            rates = yield from _multiplier_rates(point, direction)
            uncertain = uncertain + blurred * rates
    # The critical multipliers cannot be known better than they meet the condition.
    places = point.critical(found.type)
    critical = point.multipliers[places]
    off = np.abs(critical - (-1 if found.type == "PD" else 1))
    off = np.abs(np.abs(critical) - 1) if found.type in PAIRED else off
    uncertain[places] = np.maximum(uncertain[places], off)
    moved = SPREAD * abs(again.value - point.z[-1]) + rounding
    value = orbits.value(point.z)
    largest = max(abs(value), orbits.width)
    return float(moved) * orbits.width + float(np.spacing(largest)), uncertain


def _multiplier_rates(point: OrbitPoint, direction: Array) -> Uncertainties[Array]:
    """Find by how much each multiplier changes along a branch, a unit of arclength."""
    step, values = BIFURCATION.differenced, point.multipliers
    while True:
        others = yield point, point.z + step * direction
        change = np.abs(match_multipliers(values, others) - values)
        if change.max(initial=0.0) < 0.01 or step < 1e-4 * BIFURCATION.differenced:
            return np.asarray(change / step, dtype=float)
        step /= 100


def _blurred(test: str, point: OrbitPoint, uncertain: Array) -> float:
    """Return how much a test function changes while its multipliers move by what is uncertain."""
    if test == "LP":  # it is not a function of the multipliers
        return 0.0
    values = point.multipliers
    outward = values + uncertain * values / np.maximum(np.abs(values), 1e-300)
    standing = point.curve.orbits.standing
    there, here = (evaluate_tests(each, (test,), standing)[test] for each in (outward, values))
    return abs(there - here)


Report = Callable[[FollowedCurve[OrbitPoint], Found, int], None]
"""Called with the curve, the special point that is described next, and how many are done."""

ReportOrbits = Callable[[FollowedCurve[OrbitPoint], int], None]
"""Called with a curve and the number of its points whose states are computed."""


def _unwatched(followed: FollowedCurve[OrbitPoint], done: int) -> None:
    """Do nothing: there is no observer, or an earlier step was interrupted."""


def assemble(
    curves: Sequence[FollowedCurve[OrbitPoint]],
    leads: Mapping[Found[OrbitPoint], Sequence[int]],
    started: End,
    known: Mapping[Found, SpecialPoint],
    report_orbits: ReportOrbits = _unwatched,
) -> tuple[Branch, ...]:
    """Return all branches as data, as far as their states are found before an interruption.

    Special points that were not described before it are bare.
    """
    if any(found not in known for followed in curves for found in followed.traced.found):
        report_orbits = _unwatched  # not after an interruption
    described: dict[Found, SpecialPoint] = {}
    branches = []
    for followed in curves:
        own = []
        for found in followed.traced.found:
            (leads_to,) = leads.get(found, [None])[-1:]
            described[found] = replace(known.get(found) or bare(found), leads_to=leads_to)
            own.append(described[found])
        first = started
        if followed.start.found is not None:
            special = described[followed.start.found]
            value = certain(special.value, special.uncertainty)
            reason = f"emanates at {special.vary} = {value:.9g}"
            first = End("bifurcation", reason, (special.value,))
            if special.type == "BP" and len(followed.start.points) > 1:  # it crosses its parent
                own.append(replace(special, arclength=0.0, leads_to=followed.start.parent))
        elif followed.number > 1 and followed.start.points:
            point = followed.start.points[0]
            reason = "begins where another branch closes on its orbits"
            first = End("bifurcation", reason, point.curve.place(point.z))
        own.sort(key=lambda special: special.arclength)
        branches.append(_branch(followed, first, own, report_orbits))
        if branches[-1].stopped.kind == "interrupted":
            break  # where it ended so when it was followed, no other one follows
    return tuple(_without_lost(branch, len(branches)) for branch in branches)


def _without_lost(branch: Branch, kept: int) -> Branch:
    """Return a branch whose special points lead to none after the last that is kept."""
    if all((point.leads_to or 0) <= kept for point in branch.special):
        return branch
    special = (
        replace(point, leads_to=None) if (point.leads_to or 0) > kept else point
        for point in branch.special
    )
    return replace(branch, special=tuple(special))


def describe_in_turn(
    curves: Iterable[FollowedCurve[OrbitPoint]], report: Report
) -> dict[Found, SpecialPoint]:
    """Describe special points in their order, those alike at once, until it is interrupted."""
    known: dict[Found, SpecialPoint] = {}
    with suppress(KeyboardInterrupt):
        for followed in curves:
            for kind, group in groupby(followed.traced.found, _common):
                while results := [*islice(group, 1 if kind is None else LANES)]:
                    report(followed, results[0], len(known))
                    known |= zip(results, describe(results), strict=True)
    return known


def _common(found: Found) -> Hashable:
    """What a located point has in common with those that are described with it."""
    return what_is_common(found.point)


def _branch(
    followed: FollowedCurve[OrbitPoint],
    first: End,
    special: Sequence[SpecialPoint],
    report_orbits: ReportOrbits,
) -> Branch:
    """Return a branch as data, up to where an interruption left its states unknown."""
    traced = followed.traced
    orbits, started, stopped = traced.curve, followed.started or first, traced.end
    assert stopped is not None  # every curve ends
    nodes, whole = _evenly_until_interrupted(traced.points, partial(report_orbits, followed))
    points = traced.points[: len(nodes)]
    if not whole:
        reason = "interrupted before the states along the rest of the branch were found"
        stopped = End("interrupted", reason, orbits.place(points[-1].z))
        started = first if traced.closes else started
        special = [point for point in special if point.arclength <= points[-1].arclength]
    parameter = np.array([orbits.value(point.z) for point in points])
    if started.kind == "span":
        parameter[0] = started.value  # exactly, whatever its scale did
    return Branch(
        **curve_fields(followed, orbits, points),
        vary=orbits.vary,
        parameter=parameter,
        nodes=nodes,
        special=tuple(special),
        stopped=stopped,
        started=started,
    )


def curve_fields(
    followed: FollowedCurve[OrbitPoint], orbits: Orbits, points: Sequence[OrbitPoint]
) -> dict[str, Any]:
    """Return the fields that branches and loci have in common, besides states and ends."""
    durations, model = orbits.durations(points), orbits.model
    stuck = np.array([point.stuck_fraction for point in points])
    return {
        "id": followed.number,
        "kind": orbits.kind,
        "period": orbits.period,
        "parent": followed.start.parent,
        "model": model if durations is None else model.replace(duration=float(durations[0])),
        "multipliers": np.array([orbits.multipliers(point) for point in points]),
        "residual": np.array([point.residual for point in points]),
        "arclength": np.array([point.arclength for point in points]),
        "durations": durations,
        "stuck_fraction": None if np.isnan(stuck).all() else stuck,
    }


def point_fields(found: Found[OrbitPoint], orbits: Orbits) -> dict[str, Any]:
    """Return the fields that special points of branches and of loci have in common."""
    point, model = found.point, orbits.model_at(found.point.z)
    return {
        "model": found.model_of(model) if isinstance(found, Happened) else model,
        "period": orbits.period,
        "multipliers": orbits.multipliers(point),
        "residual": point.residual,
        "arclength": point.arclength,
    }


def evenly(points: Sequence[OrbitPoint]) -> NDArray[np.float64]:
    """States at phases that are the same for all points, shape (n_points, m, n)."""
    return np.array(list(_each_evenly(points)))


def _each_evenly(points: Sequence[OrbitPoint]) -> Iterator[NDArray[np.float64]]:
    count = max(point.curve.orbits.segments for point in points)
    if _solved_for(points):
        count = 1 << (count - 1).bit_length()  # of a mesh there are powers of two
    for point in points:
        yield point.curve.orbits.evenly(point.z, count)


def _solved_for(points: Sequence[OrbitPoint]) -> bool:
    """Whether intervals of a mesh are solved for the states of each point: that takes its time."""
    return any(point.curve.orbits.by.growing for point in points)


def _evenly_until_interrupted(
    points: Sequence[OrbitPoint], report_orbits: Callable[[int], None]
) -> tuple[NDArray[np.float64], bool]:
    """Return the states of the points, at least of the first, and whether they are all."""
    nodes, whole, slow = [], True, _solved_for(points)
    try:
        for states in _each_evenly(points):
            nodes.append(states)
            if slow:
                report_orbits(len(nodes))
    except KeyboardInterrupt:
        whole = False
    return np.array(nodes or [next(_each_evenly(points))]), whole


def complete_branches(branches: Sequence[Branch], report: Callable[[int, int], None]) -> bool:
    """Compute extrema and uncertainties at all points, until it is interrupted.

    Return whether all is done; what is not is NaN.
    """
    total, done = sum(map(len, branches)), 0
    for branch in branches:
        names = flow_of(branch.model).output_names
        low, high = np.full((2, len(branch), len(names)), np.nan)
        vars(branch)["extrema"] = Extrema(names, low, high)
        vars(branch)["multiplier_uncertainty"] = np.full(branch.multipliers.shape, np.nan)
    try:
        for branch in branches:
            for first in range(0, len(branch), TOGETHER):
                rows = range(len(branch))[first : first + TOGETHER]
                report(done, total)
                own = slice(rows.start, rows.stop)
                result = branch._extrema_of(own)
                branch.extrema.minimum[own] = result.minimum
                branch.extrema.maximum[own] = result.maximum
                for begin in rows[::LANES]:
                    report(done, total)
                    own = slice(begin, min(begin + LANES, rows.stop))
                    branch.multiplier_uncertainty[own] = branch._multiplier_uncertainty_of(own)
                    done += own.stop - own.start
    except KeyboardInterrupt:
        pass
    return done == total
