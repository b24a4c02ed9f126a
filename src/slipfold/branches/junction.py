"""Where branches begin and meet: which special points are known, and which branches they join."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import Branch
from slipfold.branches.closing import Birth
from slipfold.branches.detection import SAME
from slipfold.branches.start import doubled_start, hopf_start
from slipfold.continuation.search import Found
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.equilibrium_problem import EquilibriumProblem
from slipfold.orbits.orbit_point import OrbitPoint

__all__ = ["Junction", "Meeting", "find_meeting", "junctions_on", "linked"]

MATCH = 1e-7
"""Two branch points this close in the parameter, in spans, may be one."""


@dataclass(frozen=True, eq=False)
class Junction:
    """A special point of a known branch at which another branch begins.

    Parameters
    ----------
    branch
        Id of the branch it lies on.
    place
        Its place among the special points of that branch.
    found
        The special point.
    problem
        The boundary-value problem of the branch it lies on.
    birth
        The branch that begins there.
    """

    branch: int
    place: int
    found: Found
    problem: PeriodicProblem
    birth: Birth

    @property
    def two_sided(self) -> bool:
        """Whether the other branch goes on in both directions, as one does at a branch point."""
        return self.found.type == "BP"

    @property
    def rank(self) -> tuple[bool, int]:
        """Its turn: what may end at a place of birth is followed once those are known.

        Equilibria come before cycles, orbits before those of longer period.
        """
        return self.birth.problem.kind != "equilibrium", self.birth.problem.period

    def is_reached(self, branches: Sequence[Branch]) -> bool:
        """Whether the other branch is known."""
        return branches[self.branch - 1].special[self.place].leads_to is not None


@dataclass(frozen=True)
class Meeting:
    """A special point with the branch it leads to.

    Parameters
    ----------
    branch, place
        The special point: its branch and place.
    leads_to
        Id of the other branch.
    """

    branch: int
    place: int
    leads_to: int


def junctions_on(
    problem: PeriodicProblem,
    branch: int,
    found: Sequence[tuple[int, Found]],
    largest_period: int,
) -> list[Junction]:
    """Return the places of a branch at which others begin.

    Parameters
    ----------
    problem
        The boundary-value problem of the branch.
    branch
        Its id.
    found
        Its bifurcations with their places among its special points.
    largest_period
        Branches are followed up to this period.
    """
    births = ((place, item, _known_birth(problem, item, largest_period)) for place, item in found)
    return [
        Junction(branch, place, item, problem, birth)
        for place, item, birth in births
        if birth is not None
    ]


def _known_birth(problem: PeriodicProblem, found: Found, largest_period: int) -> Birth | None:
    """Return the branch that begins at a special point, None if its start cannot be computed."""
    try:
        return _birth(problem, found, largest_period)
    except BREAKDOWNS:
        return None


def _birth(problem: PeriodicProblem, found: Found, largest_period: int) -> Birth | None:
    if found.type == "BP" and found.other is not None:
        return Birth(problem, _other_branch(found, found.other))
    if found.type == "NS" and isinstance(problem, EquilibriumProblem):
        return Birth(*hopf_start(problem, found.point))
    if found.type == "PD" and 2 * problem.period <= largest_period:
        return Birth(*doubled_start(problem, found.point))
    return None


def _other_branch(found: Found, tangent: NDArray[np.float64]) -> OrbitPoint:
    tests = {**found.point.tests, "LP": float(tangent[-1])}
    return replace(found.point, tangent=tangent, arclength=0.0, tests=tests)


def find_meeting(junction: Junction, known: Sequence[Junction]) -> Junction | None:
    """Return the branch point of a known branch that another branch passed again, if it is one.

    Parameters
    ----------
    junction
        A branch point.
    known
        Known ones.
    """
    problem, z = junction.problem, junction.found.point.z
    for other in known:
        if (
            (other.found.type, junction.found.type) == ("BP", "BP")
            and Birth(problem, junction.found.point).fits(other.problem)
            and abs(problem.value(z) - other.problem.value(other.found.point.z))
            < MATCH * problem.width
            and problem.distance(problem.adopt(other.problem, other.found.point.z), z) < SAME
        ):
            return other
    return None


def linked(branches: Sequence[Branch], meetings: Sequence[Meeting]) -> list[Branch]:
    """Note on branches where they lead.

    Parameters
    ----------
    branches
        The branches.
    meetings
        What joins them.
    """
    result = list(branches)
    for meeting in meetings:
        branch = result[meeting.branch - 1]
        special = list(branch.special)
        special[meeting.place] = replace(special[meeting.place], leads_to=meeting.leads_to)
        result[meeting.branch - 1] = replace(branch, special=tuple(special))
    return result
