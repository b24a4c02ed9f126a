"""Branches of cycles whose duration grows without bound, towards a homoclinic orbit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipfold.branches.branch import End
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.cycle_problem import CycleProblem
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["homoclinic_end", "nears_homoclinic"]

GROWN = 2.0
"""A duration that has grown less since the branch began says nothing."""

STANDS = 1e-3
"""Change of the parameter, in spans, over that of the duration, in first durations, below which the
parameter has as good as come to its end."""

STILL = 1e-9
"""The same below which it has: special points are located to this, so all that could still be found
would have one and the same value of the parameter."""


def homoclinic_end(
    problem: PeriodicProblem, points: Sequence[OrbitPoint], largest: float
) -> End | None:
    """Return where a branch of cycles ends on its way to a homoclinic orbit, None if it goes on.

    Near one the distance of the parameter from its value there falls exponentially with the
    duration (Kuznetsov, Elements of Applied Bifurcation Theory, section 6.4).

    Parameters
    ----------
    problem
        The boundary-value problem.
    points
        Points of the branch.
    largest
        Largest duration, relative to that at the first point.
    """
    growth = _growth(problem, points)
    value = problem.value(points[-1].z)
    if _stands(problem, points, STILL):
        return End(
            "homoclinic",
            f"the duration grew to {growth:.3g} times that at first while {problem.vary} stays at "
            f"{value:.9g}: the cycle nears a homoclinic orbit",
            value,
        )
    if growth > largest:
        return End(
            "duration",
            f"the duration grew past {largest:g} times that at first: the cycle may near a "
            "homoclinic orbit; allow a larger duration to go on",
            value,
        )
    return None


def nears_homoclinic(problem: PeriodicProblem, points: Sequence[OrbitPoint]) -> str:
    """Return a clause for the sentence of another end where a homoclinic orbit is near, else "".

    Parameters
    ----------
    problem
        The boundary-value problem.
    points
        Points of the branch.
    """
    if not _stands(problem, points, STANDS):
        return ""
    return (
        f"the duration grew to {_growth(problem, points):.3g} times that at first while "
        f"{problem.vary} hardly changes: the cycle nears a homoclinic orbit"
    )


def _growth(problem: PeriodicProblem, points: Sequence[OrbitPoint]) -> float:
    if not isinstance(problem, CycleProblem):
        return 1.0
    return problem.duration(points[-1].z) / problem.duration(points[0].z)


def _stands(problem: PeriodicProblem, points: Sequence[OrbitPoint], share: float) -> bool:
    """Whether the parameter stands still while the duration grows; at a fold one point may."""
    values = [point.z[-1] for point in points]
    if _growth(problem, points) < GROWN or np.ptp(values) < STILL:  # a family of centres
        return False
    unit = points[0].z[-2]
    last = np.array([point.tangent[-2:] for point in points[-2:]])
    return bool((np.abs(last[:, 1]) < share * last[:, 0] / unit).all())
