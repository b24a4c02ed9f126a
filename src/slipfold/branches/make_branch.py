"""Branches as data from what was followed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.branches.describe import bare, describe
from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.atlas import Chart
from slipfold.continuation.end import End
from slipfold.continuation.search import Found
from slipfold.orbits.orbit_point import OrbitPoint
from slipfold.text.one_line import certain

__all__ = ["assemble", "describe_in_turn", "evenly", "stuck_fractions"]

Tell = Callable[[Chart[OrbitPoint], Found, int], None]
"""Called with what is described next, the chart that it is on, and how many are done."""

Told = Callable[[Chart[OrbitPoint], int], None]
"""Called with the chart whose states are found, and of how many of its points they are."""


def assemble(
    charts: Sequence[Chart[OrbitPoint]],
    leads: Mapping[Found[OrbitPoint], Sequence[int]],
    begun: End,
    tell: Tell = lambda chart, found, done: None,
    told: Told = lambda chart, done: None,
) -> tuple[Branch, ...]:
    """Return all branches as data; special points that an interruption leaves are bare."""
    known = describe_in_turn(charts, tell)
    described: dict[Found, SpecialPoint] = {}
    branches = []
    for chart in charts:
        own = []
        for found in chart.trail.found:
            (leads_to,) = leads.get(found, [None])[-1:]
            described[found] = replace(known.get(found) or bare(found), leads_to=leads_to)
            own.append(described[found])
        first = begun
        if chart.start.found is not None:
            special = described[chart.start.found]
            born = f"born at {special.vary} = {certain(special.value, special.uncertainty):.9g}"
            first = End("born", born, (special.value,))
            if len(chart.start.points) > 1:  # it crosses its parent there
                own.append(replace(special, arclength=0.0, leads_to=chart.start.parent))
        own.sort(key=lambda special: special.arclength)
        branches.append(_branch(chart, chart.begun or first, own, told))
    return tuple(branches)


def describe_in_turn(charts: Iterable[Chart[OrbitPoint]], tell: Tell) -> dict[Found, SpecialPoint]:
    """Describe special points in their order, until whoever watches stops it."""
    known: dict[Found, SpecialPoint] = {}
    try:
        for chart in charts:
            for found in chart.trail.found:
                tell(chart, found, len(known))
                known[found] = describe(found)
    except KeyboardInterrupt:
        pass
    return known


def _branch(
    chart: Chart[OrbitPoint], begun: End, special: Sequence[SpecialPoint], told: Told
) -> Branch:
    orbits, points = chart.trail.curve, chart.trail.points
    assert chart.trail.end is not None  # every trail ends
    durations, model = orbits.durations(points), orbits.model
    parameter = np.array([orbits.value(point.z) for point in points])
    if begun.kind == "span":
        parameter[0] = begun.value  # exactly, whatever its scale did
    return Branch(
        id=chart.number,
        kind=orbits.kind,
        period=orbits.period,
        parent=chart.start.parent,
        model=model if durations is None else model.replace(duration=float(durations[0])),
        vary=orbits.vary,
        parameter=parameter,
        nodes=evenly(points, lambda done: told(chart, done)),
        multipliers=np.array([orbits.multipliers(point) for point in points]),
        residual=np.array([point.residual for point in points]),
        arclength=np.array([point.arclength for point in points]),
        special=tuple(special),
        stopped=chart.trail.end,
        begun=begun,
        durations=durations,
        stuck_fraction=stuck_fractions(points),
    )


def stuck_fractions(points: Sequence[OrbitPoint]) -> NDArray[np.float64] | None:
    """Share of each period in which a contact sticks; None where none may along all of them."""
    found = np.array([point.curve.orbits.stuck_fraction(point.z) for point in points])
    return None if np.isnan(found).all() else found


def evenly(
    points: Sequence[OrbitPoint], told: Callable[[int], None] = lambda done: None
) -> NDArray[np.float64]:
    """States at phases that are the same for all points, shape (n_points, m, n)."""
    count = max(point.curve.orbits.segments for point in points)
    if not any(point.curve.orbits.by.growing for point in points):
        return np.array([point.curve.orbits.evenly(point.z, count) for point in points])
    count, nodes = 1 << (count - 1).bit_length(), []  # of a mesh there are powers of two
    for point in points:
        nodes.append(point.curve.orbits.evenly(point.z, count))
        told(len(nodes))  # intervals are solved for each of them: that takes its time
    return np.array(nodes)
