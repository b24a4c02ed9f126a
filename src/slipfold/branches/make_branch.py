"""Branches as data from what was followed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.branches.describe import bare, describe
from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.curve_set import FollowedCurve
from slipfold.continuation.end import End
from slipfold.continuation.traced_curve import Found
from slipfold.flow.batches import LANES
from slipfold.flow.flow import flow_of
from slipfold.orbits.extrema import TOGETHER, Extrema, find_extrema
from slipfold.orbits.orbit_curve import OrbitPoint
from slipfold.orbits.uncertainty import multiplier_uncertainty
from slipfold.text.one_line import certain

Report = Callable[[FollowedCurve[OrbitPoint], Found, int], None]
"""Called with what is described next, the curve that it is on, and how many are done."""

ReportOrbits = Callable[[FollowedCurve[OrbitPoint], int], None]
"""Called with the curve whose states are found, and of how many of its points they are."""


def _unwatched(followed: FollowedCurve[OrbitPoint], done: int) -> None:
    """Continue: nobody watches, or what came before was interrupted."""


def assemble(
    curves: Sequence[FollowedCurve[OrbitPoint]],
    leads: Mapping[Found[OrbitPoint], Sequence[int]],
    begun: End,
    report: Report = lambda followed, found, done: None,
    report_orbits: ReportOrbits = _unwatched,
) -> tuple[Branch, ...]:
    """Return all branches as data, as far as their states are found before an interruption.

    Special points whose normal forms it leaves are bare.
    """
    known = describe_in_turn(curves, report)
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
        first = begun
        if followed.start.found is not None:
            special = described[followed.start.found]
            born = f"born at {special.vary} = {certain(special.value, special.uncertainty):.9g}"
            first = End("born", born, (special.value,))
            if len(followed.start.points) > 1:  # it crosses its parent there
                own.append(replace(special, arclength=0.0, leads_to=followed.start.parent))
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
    """Describe special points in their order, until it is interrupted."""
    known: dict[Found, SpecialPoint] = {}
    try:
        for followed in curves:
            for found in followed.traced.found:
                report(followed, found, len(known))
                known[found] = describe(found)
    except KeyboardInterrupt:
        pass
    return known


def _branch(
    followed: FollowedCurve[OrbitPoint],
    first: End,
    special: Sequence[SpecialPoint],
    report_orbits: ReportOrbits,
) -> Branch:
    """Return a branch as data, up to where an interruption left its states unknown."""
    traced = followed.traced
    orbits, begun, stopped = traced.curve, followed.begun or first, traced.end
    assert stopped is not None  # every curve ends
    nodes, whole = _evenly_until_interrupted(
        traced.points, lambda done: report_orbits(followed, done)
    )
    points = traced.points[: len(nodes)]
    if not whole:
        reason = "interrupted before the states along the rest of the branch were found"
        stopped = End("interrupted", reason, orbits.place(points[-1].z))
        begun = first if traced.closes else begun
        special = [point for point in special if point.arclength <= points[-1].arclength]
    durations, model = orbits.durations(points), orbits.model
    parameter = np.array([orbits.value(point.z) for point in points])
    if begun.kind == "span":
        parameter[0] = begun.value  # exactly, whatever its scale did
    return Branch(
        id=followed.number,
        kind=orbits.kind,
        period=orbits.period,
        parent=followed.start.parent,
        model=model if durations is None else model.replace(duration=float(durations[0])),
        vary=orbits.vary,
        parameter=parameter,
        nodes=nodes,
        multipliers=np.array([orbits.multipliers(point) for point in points]),
        residual=np.array([point.residual for point in points]),
        arclength=np.array([point.arclength for point in points]),
        special=tuple(special),
        stopped=stopped,
        begun=begun,
        durations=durations,
        stuck_fraction=stuck_fractions(points),
    )


def stuck_fractions(points: Sequence[OrbitPoint]) -> NDArray[np.float64] | None:
    """Share of each period in which a contact sticks; None where none may along all of them."""
    found = np.array([point.curve.orbits.stuck_fraction(point.z) for point in points])
    return None if np.isnan(found).all() else found


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
    """Return the states of the first points, of one at least, and whether nobody stopped that."""
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
                some = range(len(branch))[first : first + TOGETHER]
                report(done, total)
                _find_extrema(branch, slice(some.start, some.stop))
                for begin in some[::LANES]:
                    report(done, total)
                    end = min(begin + LANES, some.stop)
                    _find_uncertainty(branch, slice(begin, end))
                    done += end - begin
    except KeyboardInterrupt:
        pass
    return done == total


def _find_extrema(branch: Branch, some: slice) -> None:
    model, extrema = branch.model, branch.extrema
    if branch.stuck_fraction is not None:
        for index in range(some.start, some.stop):
            one = branch.orbit(index).extrema
            extrema.minimum[index], extrema.maximum[index] = one.minimum, one.maximum
        return
    found = find_extrema(model, branch.parameters[some], branch.nodes[some], branch.period)
    extrema.minimum[some], extrema.maximum[some] = found.minimum, found.maximum


def _find_uncertainty(branch: Branch, some: slice) -> None:
    if branch.stuck_fraction is not None:
        for index in range(some.start, some.stop):
            branch.multiplier_uncertainty[index] = branch.orbit(index).multiplier_uncertainty
        return
    branch.multiplier_uncertainty[some] = multiplier_uncertainty(
        branch.model,
        branch.parameters[some],
        branch.nodes[some],
        branch.period,
        branch.multipliers[some],
    )
