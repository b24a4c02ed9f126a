"""Branches that close: on themselves, or on a period doubling or Hopf point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import End
from slipfold.continuation.interpolation import POINTS, hermite, well_spaced
from slipfold.continuation.locate import LostBranchError, orbit_at
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.orbit_point import OrbitPoint, make_point
from slipfold.orbits.shooting import Shooting

__all__ = [
    "BEFORE",
    "Birth",
    "asymmetry",
    "birth_point",
    "close_on_parent",
    "has_copy",
    "meets_its_copy",
    "return_to_start",
    "step_beside_parent",
]

Array = NDArray[np.float64]

BEFORE = 3e-3
"""How far before the parent the last regular orbit of a closing branch lies, in arclength."""

NEAR = 0.05
"""Distance within which the end of a closing branch is matched with a place of birth, in scaled
states and spans: the meeting is interpolated over one step."""

ABEAM = 3
"""Corrections to where the first point of a closed curve lies abeam: each squares the error."""

SAME = 1e-5
"""Two orbits this close are one; steps and orbits differ by much more."""


@dataclass(frozen=True, eq=False)
class Birth:
    """Where a branch of doubled period, or of cycles, begins.

    Parameters
    ----------
    problem
        The boundary-value problem of the branch that begins.
    start
        Its first point.
    """

    problem: PeriodicProblem
    start: OrbitPoint

    def fits(self, problem: PeriodicProblem) -> bool:
        """Whether a branch of a problem may end here."""
        return (self.problem.kind, self.problem.period) == (problem.kind, problem.period)

    def in_terms_of(self, problem: PeriodicProblem) -> Array:
        """Return the first point as an unknown of another problem."""
        return problem.adopt(self.problem, self.start.z)


def has_copy(problem: PeriodicProblem) -> bool:
    """Whether each orbit, begun half its period later, is another point of the same curve.

    So it is with even periods, and with cycles: they may end where both coincide.

    Parameters
    ----------
    problem
        The boundary-value problem.
    """
    return problem.kind == "cycle" or problem.period % 2 == 0


def meets_its_copy(problem: Shooting, before: OrbitPoint, point: OrbitPoint) -> bool:
    """Whether a branch of doubled period passed its parent and goes on as its own copy.

    The copy is the same orbit half a period later, so the difference between the halves of the
    orbit changes sign.

    Parameters
    ----------
    problem
        The equations.
    before, point
        Neighbouring points.
    """
    here, there = asymmetry(problem, before.z), asymmetry(problem, point.z)
    # A step may also land beside the parent, within what Newton's method can tell apart.
    return bool(here @ there < 0 or np.linalg.norm(there) < 0.1 * BEFORE)


def step_beside_parent(problem: Shooting, point: OrbitPoint) -> float:
    """Return the longest step that cannot pass the parent by more than its distance.

    Near the parent the halves of the orbit differ by about 1.4 times the arclength to it. A longer
    step could land on another branch that leaves the same parent nearby.

    Parameters
    ----------
    problem
        The equations.
    point
        A point of a curve of doubled period.
    """
    return max(BEFORE, 0.9 * float(np.linalg.norm(asymmetry(problem, point.z))))


def asymmetry(problem: Shooting, z: Array) -> Array:
    """Return by how much the halves of an orbit differ, in scaled states.

    Parameters
    ----------
    problem
        The equations.
    z
        An orbit.
    """
    half = problem.size // 2
    return z[:half] - z[half : problem.size]


def close_on_parent(
    problem: PeriodicProblem,
    known: Sequence[OrbitPoint],
    before: OrbitPoint,
    point: OrbitPoint,
    births: Sequence[Birth],
) -> tuple[OrbitPoint, End, Birth | None]:
    """Go back to just before the branch meets its copy.

    Where it does, the orbit is that of the parent's period doubling, or an equilibrium, and
    Newton's method is singular, so the last regular orbit lies a short step before it.

    Parameters
    ----------
    problem
        The boundary-value problem.
    known
        Points of the branch in order.
    before, point
        Neighbouring points between which the branch meets its copy.
    births
        Where branches are known to begin.

    Returns
    -------
    point : OrbitPoint
        The last regular orbit.
    end : End
        Names the place.
    birth : Birth or None
        Where the branch ended; None if nothing is known to begin there.
    """
    from scipy.optimize import brentq  # a fifth of a second to import, and seldom needed

    direction = asymmetry(problem, before.z)
    near = well_spaced(known, before.arclength, point.arclength, POINTS)
    place = point.arclength
    if direction @ asymmetry(problem, point.z) < 0:
        place = brentq(
            lambda arclength: direction @ asymmetry(problem, hermite(near, arclength)[0]),
            before.arclength,
            point.arclength,
            xtol=1e-6,
        )
    meeting = hermite(near, place)[0]
    birth = _matching(problem, meeting, births)
    value = problem.value(meeting if birth is None else birth.in_terms_of(problem))
    where = _place_of_meeting(problem, meeting)
    end = End("closed", f"the branch closed on {where} at {problem.vary} = {value:.9g}", value)
    length = place - before.arclength
    for back in (BEFORE, 4 * BEFORE, 16 * BEFORE):
        if back < length:
            last = orbit_at(problem, known, place - back)
            # Newton's method may fall onto the parent, where the halves do not differ.
            if np.linalg.norm(asymmetry(problem, last.z)) > 0.3 * back:
                return last, end, birth
    return before, end, birth


def _place_of_meeting(problem: PeriodicProblem, meeting: Array) -> str:
    if problem.period % 2 == 0:
        return "its parent's period doubling"
    nodes = problem.flat(problem.nodes(meeting)).reshape(problem.segments, -1)
    still = float(np.linalg.norm(nodes - nodes.mean(axis=0))) < NEAR
    return "a Hopf point" if still else "the period doubling of a cycle of half its duration"


def _matching(problem: PeriodicProblem, meeting: Array, births: Sequence[Birth]) -> Birth | None:
    """Return the place of birth whose orbit is the one where the branch met its copy."""

    def distance(birth: Birth) -> float:
        return problem.distance(birth.in_terms_of(problem), meeting)

    alike = [birth for birth in births if birth.fits(problem)]
    nearest = min(alike, key=distance, default=None)
    return nearest if nearest is not None and distance(nearest) < NEAR else None


def birth_point(problem: PeriodicProblem, last: OrbitPoint, birth: Birth) -> OrbitPoint:
    """Return the place of birth that a branch closed on as its last point.

    Parameters
    ----------
    problem
        The boundary-value problem of the branch.
    last
        Its last regular point.
    birth
        Where it ends.
    """
    start = birth.start
    z = problem.in_phase(birth.in_terms_of(problem), last.z)
    place = last.arclength + float(np.linalg.norm(z - last.z))
    return make_point(z, last.tangent, place, start.monodromy, start.residual)


def return_to_start(
    problem: Shooting, points: Sequence[OrbitPoint], point: OrbitPoint
) -> OrbitPoint | None:
    """Return where the last step passed the first point of the curve again, None if it did not.

    Parameters
    ----------
    problem
        The equations.
    points
        Points of the curve so far.
    point
        The next one.
    """
    first, before = points[0], points[-1]
    if len(points) < 4:
        return None
    along = float((first.z - before.z) @ before.tangent)
    length = point.arclength - before.arclength
    if not 0 < along < 1.5 * length or np.linalg.norm(first.z - before.z) > 1.5 * length:
        return None
    place = before.arclength + min(along, length)
    known = [*points[-2:], point]
    try:
        passed = orbit_at(problem, known, place)
        for _ in range(ABEAM):  # to where the first point lies abeam
            place = passed.arclength + float((first.z - passed.z) @ passed.tangent)
            if not before.arclength < place <= point.arclength:
                return None
            passed = orbit_at(problem, known, place)
    except LostBranchError:
        return None
    return passed if np.linalg.norm(passed.z - first.z) < SAME else None
