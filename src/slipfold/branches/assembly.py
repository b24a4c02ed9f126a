"""A branch as data from its traces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.branches.describe import describe_bifurcation, describe_event
from slipfold.branches.events import Happened
from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.end import End
from slipfold.continuation.search import Found
from slipfold.continuation.trail import Trail
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.cycle_problem import CycleProblem
from slipfold.orbits.equilibrium_problem import EquilibriumProblem
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["assemble"]


def assemble(
    trace: Trail[OrbitPoint],
    number: int,
    parent: int | None,
    begun: End,
    beginning: SpecialPoint | None = None,
) -> tuple[Branch, list[tuple[int, Found]]]:
    """Return a branch as data, and its bifurcations with their place among its special points.

    Parameters
    ----------
    trace
        What was followed.
    number
        Id of the branch.
    parent
        Id of the branch it left, or None.
    begun
        Why it begins where it begins.
    beginning
        The branch point at which it crosses its parent, if it does.
    """
    problem, points = trace.curve, trace.points
    assert trace.end is not None  # every trace ends
    described: list[tuple[SpecialPoint, Found | None]] = [
        (_described(problem, found), found) for found in trace.found
    ]
    if beginning is not None:
        described.append((beginning, None))
    described.sort(key=lambda pair: pair[0].arclength)
    durations, model = _durations(problem, points), problem.model
    branch = Branch(
        id=number,
        kind="equilibrium" if problem.kind == "equilibrium" else "periodic",
        period=problem.period,
        parent=parent,
        model=model if durations is None else model.replace(duration=float(durations[0])),
        vary=problem.vary,
        parameter=np.array([problem.value(point.z) for point in points]),
        nodes=np.array([problem.nodes(point.z) for point in points]),
        multipliers=np.array([problem.all_multipliers(point.multipliers) for point in points]),
        residual=np.array([point.residual for point in points]),
        arclength=np.array([point.arclength for point in points]),
        special=tuple(special for special, _ in described),
        stopped=trace.end,
        begun=begun,
        durations=durations,
    )
    return branch, [(i, found) for i, (_, found) in enumerate(described) if found is not None]


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
