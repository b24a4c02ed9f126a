"""From what was found side by side to branches as data, as they are by themselves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.abreast.limits import AtLimit, orbits_at_limits
from slipfold.branches.abreast.located import settled_zeros, tests_of
from slipfold.branches.abreast.own_branch import Case, OwnBranch
from slipfold.branches.abreast.walk import Walk
from slipfold.branches.bifurcations import span_end
from slipfold.branches.branch import Branch
from slipfold.branches.make_branch import assemble
from slipfold.branches.response import span_begin
from slipfold.continuation.atlas import Chart, Start
from slipfold.continuation.end import End
from slipfold.continuation.locate import CLOSE
from slipfold.continuation.search import Found
from slipfold.continuation.trail import Trail
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.critical import doubled_orbit
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.orbit_batch import OrbitBatch, Settled
from slipfold.orbits.orbit_curve import OrbitPoint
from slipfold.orbits.test_functions import floquet_multipliers


def settle_special(
    orbits: OrbitBatch, cases: Sequence[Case], branches: Sequence[OwnBranch], tolerance: float
) -> None:
    """Add the orbits at the special points of branches, as the flow itself has them."""
    items = [item for branch in branches for item in branch.special if not cases[item.case].lost]
    zeros = settled_zeros(orbits, items, tests_of, CLOSE, tolerance)
    for item, zero in zip(items, zeros, strict=True):
        if zero is None:
            cases[item.case].lost = "special point not located"
    known = {item: zero[0] for item, zero in zip(items, zeros, strict=True) if zero is not None}
    for branch in branches:
        branch.placed = [known[item] for item in branch.special if item in known]


def placed_on(case: Case, branch: OwnBranch, vary: str, width: float) -> list[Found[OrbitPoint]]:
    """Return the special points of a branch."""
    orbits = ForcedOrbits(case.model, {vary: width}, branch.period)
    found = []
    for item, at in zip(branch.special, branch.placed, strict=True):
        known = at.z[0], at.tangents[0], item.arclength, at.monodromies[0], float(at.residuals[0])
        found.append(Found(item.bracket.kind, orbits.derived_point(*known), item.slope))
    return found


# -- all orbits of many branches -----------------------------------------------------------------


def settle(
    orbits: OrbitBatch,
    walk: Walk,
    cases: Sequence[Case],
    branches: Sequence[OwnBranch],
    tolerance: float,
) -> None:
    """Add all orbits to branches that were walked, as well as they are to be told."""
    numbers = [number for number, fate in enumerate(walk.fates) if fate in ("span", "limit")]
    limits = orbits_at_limits(orbits, walk, tolerance)
    kept, rows = [], []
    for number in numbers:
        points, case = walk.points[number], cases[int(walk.cases[number])]
        inner = slice(int(branches[number].parent is not None), None)
        lines = [tangent for _, tangent, _ in points]
        held = hold_parameter(orbits.size)
        lines[0], lines[-1] = held * np.sign(lines[0][-1]), held * np.sign(lines[-1][-1])
        if branches[number].fate == "limit":
            branches[number].limit = limit = limits[number]
            inner = slice(inner.start, -1)
            if limit is None or not (limit.orbit.residuals <= tolerance).all():
                case.lost = case.lost or "limit not located"
            else:  # what was taken for an orbit before the limit may lie beyond it
                before = sum(point[2] < limit.arclength for point in points)
                inner = slice(inner.start, before)
                if any(item.arclength >= limit.arclength for item in branches[number].special):
                    case.lost = case.lost or "beyond the limit"
        kept.append(points[inner])
        rows += lines[inner]
    if not rows:
        return
    which = np.repeat(walk.cases[numbers], [len(item) for item in kept])
    z = np.array([point[0] for item in kept for point in item])
    found = orbits.settled(which, z, np.array(rows), tolerance)
    first = 0
    for number, item in zip(numbers, kept, strict=True):
        some = slice(first, first + len(item))
        first += len(item)
        branch, case = branches[number], cases[int(walk.cases[number])]
        branch.orbits, branch.arclengths = found.of(some), np.array([point[2] for point in item])
        if not (branch.orbits.residuals <= tolerance).all():
            case.lost = case.lost or "residual"


# -- a case --------------------------------------------------------------------------------------


def assembled(case: Case, vary: str, span: tuple[float, float]) -> tuple[Branch, ...] | None:
    """Return the branches of a case, None if it has to be followed by itself."""
    if case.lost:
        return None
    charts, leads = list[Chart[OrbitPoint]](), dict[Found[OrbitPoint], list[int]]()
    width = abs(span[1] - span[0])
    for number, branch in enumerate(case.branches, 1):
        found = placed_on(case, branch, vary, width)
        orbits = ForcedOrbits(case.model, {vary: width}, branch.period)
        try:
            chart = _chart(orbits, branch, number, charts, found)
        except BREAKDOWNS:
            chart = None
        if chart is None:
            return None
        if chart.start.found is not None:
            leads.setdefault(chart.start.found, []).append(number)
        charts.append(chart)
    return assemble(charts, leads, span_begin(vary, span[0]))


def _chart(
    orbits: ForcedOrbits,
    branch: OwnBranch,
    number: int,
    charts: Sequence[Chart[OrbitPoint]],
    found: list[Found[OrbitPoint]],
) -> Chart[OrbitPoint] | None:
    """Return a branch as if it had been followed by itself."""
    assert branch.orbits is not None
    points, parent, birth = _points(orbits, branch.orbits, branch.arclengths), None, None
    if branch.parent is not None:
        place, which = branch.parent
        parent, birth = place + 1, charts[place].trail.found[which]
        born = doubled_orbit(birth.point.curve, birth.point.z)
        residual = birth.point.residual
        first = orbits.derived_point(born.z, born.tangent, 0.0, born.monodromy, residual)
        points.insert(0, first)
    if branch.limit is None:
        end = span_end(orbits, points[-1])
    else:
        points.append(_points(orbits, branch.limit.orbit, np.array([branch.limit.arclength]))[0])
        end = _limit_end(orbits, branch.limit, points[-1])
    trail = Trail(orbits, points, branch.parent is not None, found, end)
    start = Start(orbits, (points[0],), departs=trail.departs, parent=parent, found=birth)
    return Chart(number, start, trail, None)


def _points(orbits: ForcedOrbits, settled: Settled, arclengths: Array) -> list[OrbitPoint]:
    multipliers = floquet_multipliers(settled.monodromies)
    return [
        OrbitPoint(
            settled.z[row],
            settled.tangents[row],
            float(arclengths[row]),
            {},
            0,
            float(settled.residuals[row]),
            curve=orbits,
            monodromy=settled.monodromies[row],
            multipliers=multipliers[row],
        )
        for row in range(len(arclengths))
    ]


def _limit_end(orbits: ForcedOrbits, at: AtLimit, last: OrbitPoint) -> End:
    """Say that a branch ends at a limit of the model."""
    limit = orbits.model.limits[at.limit]
    return End("limit", limit.reason.format(value=at.margin + limit.bound), orbits.place(last.z))
