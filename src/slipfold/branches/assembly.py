"""A branch as data from its traces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch, End
from slipfold.branches.describe import describe_bifurcation, describe_event
from slipfold.branches.special_point import SpecialPoint
from slipfold.branches.trace import Trace
from slipfold.continuation.search import Found
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.cycle_problem import CycleProblem
from slipfold.orbits.equilibrium_problem import EquilibriumProblem
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["assemble", "joined", "turned"]


def assemble(
    trace: Trace,
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
    problem, points = trace.problem, trace.points
    assert trace.end is not None  # every trace ends
    described: list[tuple[SpecialPoint, Found | None]] = [
        (describe_bifurcation(problem, found), found) for found in trace.found
    ]
    described += [(describe_event(problem, event, point), None) for event, point in trace.events]
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


def _durations(
    problem: PeriodicProblem, points: Sequence[OrbitPoint]
) -> NDArray[np.float64] | None:
    """Durations in seconds of one round of cycles, of equilibria their units of time."""
    if not isinstance(problem, CycleProblem | EquilibriumProblem):
        return None
    return np.array([problem.duration(point.z) for point in points])


def joined(backward: Trace, forward: Trace) -> Trace:
    """Join the two directions of a branch from one point of it.

    Parameters
    ----------
    backward, forward
        Traces that begin at the same point with opposite tangents; arclength counts from it.

    Returns
    -------
    Trace
        From the end of the one to the end of the other; it ends as `forward` does.
    """
    return replace(
        forward,
        points=[turned(point) for point in backward.points[:0:-1]] + forward.points,
        found=[replace(found, point=turned(found.point)) for found in reversed(backward.found)]
        + forward.found,
        events=[(event, turned(point)) for event, point in reversed(backward.events)]
        + forward.events,
        reached=backward.reached + forward.reached,
    )


def turned(point: OrbitPoint) -> OrbitPoint:
    """Return a point as one of the curve followed in the other direction.

    Parameters
    ----------
    point
        The point.
    """
    return replace(
        point,
        tangent=-point.tangent,
        arclength=-point.arclength,
        tests={**point.tests, "LP": -point.tests["LP"]},
        orientation=-point.orientation,
    )
