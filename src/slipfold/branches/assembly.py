"""Branches as data from what was followed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.branches.describe import describe_bifurcation, describe_event
from slipfold.branches.events import Happened
from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.atlas import Atlas, Chart
from slipfold.continuation.end import End
from slipfold.continuation.search import Found
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.cycle_problem import CycleProblem
from slipfold.orbits.equilibrium_problem import EquilibriumProblem
from slipfold.orbits.orbit_point import OrbitPoint
from slipfold.text.one_line import certain

__all__ = ["assemble"]


def assemble(atlas: Atlas[OrbitPoint], begun: End) -> tuple[Branch, ...]:
    """Return all branches as data."""
    described: dict[Found, SpecialPoint] = {}
    branches = []
    for chart in atlas.charts:
        problem, own = chart.trail.curve, []
        for found in chart.trail.found:
            (leads_to,) = atlas.leads.get(found, [None])[-1:]
            described[found] = replace(_described(problem, found), leads_to=leads_to)
            own.append(described[found])
        first = begun
        if chart.start.found is not None:
            special = described[chart.start.found]
            born = f"born at {special.vary} = {certain(special.value, special.uncertainty):.9g}"
            first = End("born", born, (special.value,))
            if len(chart.start.points) > 1:  # it crosses its parent there
                own.append(replace(special, arclength=0.0, leads_to=chart.start.parent))
        own.sort(key=lambda special: special.arclength)
        branches.append(_branch(chart, chart.begun or first, own))
    return tuple(branches)


def _branch(chart: Chart[OrbitPoint], begun: End, special: Sequence[SpecialPoint]) -> Branch:
    problem, points = chart.trail.curve, chart.trail.points
    assert chart.trail.end is not None  # every trail ends
    durations, model = _durations(problem, points), problem.model
    return Branch(
        id=chart.number,
        kind="equilibrium" if problem.kind == "equilibrium" else "periodic",
        period=problem.period,
        parent=chart.start.parent,
        model=model if durations is None else model.replace(duration=float(durations[0])),
        vary=problem.vary,
        parameter=np.array([problem.value(point.z) for point in points]),
        nodes=np.array([problem.nodes(point.z) for point in points]),
        multipliers=np.array([problem.all_multipliers(point.multipliers) for point in points]),
        residual=np.array([point.residual for point in points]),
        arclength=np.array([point.arclength for point in points]),
        special=tuple(special),
        stopped=chart.trail.end,
        begun=begun,
        durations=durations,
    )


def _described(problem: PeriodicProblem, found: Found) -> SpecialPoint:
    if isinstance(found, Happened) and found.event is not None:
        return describe_event(problem, found.event, found.point)
    return describe_bifurcation(problem, found)


def _durations(
    problem: PeriodicProblem, points: Sequence[OrbitPoint]
) -> NDArray[np.float64] | None:
    """Durations in seconds of one round of cycles, of equilibria their units of time."""
    if not isinstance(problem, CycleProblem | EquilibriumProblem):
        return None
    return np.array([problem.duration(point.z) for point in points])
