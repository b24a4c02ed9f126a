"""Branches that close: on themselves, or on the period doubling of their parent."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.branch import End
from slipfold.branches.interpolation import POINTS, hermite, well_spaced
from slipfold.branches.location import LostBranchError, orbit_at
from slipfold.branches.point import Point, make_point
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.shooting import Shooting

__all__ = [
    "BEFORE",
    "Doubling",
    "asymmetry",
    "close_on_parent",
    "doubled",
    "meets_its_copy",
    "parent_point",
    "return_to_start",
    "step_beside_parent",
]

Array = NDArray[np.float64]

Doubling = tuple[PeriodicProblem, Point]
"""A period doubling and the boundary-value problem of the branch it lies on."""

BEFORE = 3e-3
"""How far before the parent the last regular orbit of a closing branch lies, in arclength."""

NEAR = 0.05
"""Distance within which a closing branch is matched with its parent's doublings, in scaled states
and spans: the meeting is interpolated over one step."""

ABEAM = 3
"""Corrections to where the first point of a closed curve lies abeam: each squares the error."""

SAME = 1e-5
"""Two orbits this close are one; steps and orbits differ by much more."""


def meets_its_copy(problem: Shooting, before: Point, point: Point) -> bool:
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


def step_beside_parent(problem: Shooting, point: Point) -> float:
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
    known: Sequence[Point],
    before: Point,
    point: Point,
    doublings: Sequence[Doubling],
) -> tuple[Point, End]:
    """Go back to just before the branch meets its copy.

    Where it does, the orbit is that of the parent's period doubling and Newton's method is
    singular, so the last regular orbit lies a short step before it.

    Parameters
    ----------
    problem
        The boundary-value problem.
    known
        Points of the branch in order.
    before, point
        Neighbouring points between which the branch meets its copy.
    doublings
        Known period doublings of the parent.

    Returns
    -------
    point : Point
        The last regular orbit.
    end : End
        Names the period doubling.
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
    matched = _matching(problem, meeting, doublings)
    value = problem.value(meeting) if matched is None else matched[0].value(matched[1].z)
    where = "its parent's period doubling" if problem.period % 2 == 0 else "an equilibrium"
    end = End("closed", f"the branch closed on {where} at {problem.vary} = {value:.9g}", value)
    length = place - before.arclength
    for back in (BEFORE, 4 * BEFORE, 16 * BEFORE):
        if back < length:
            last = orbit_at(problem, known, place - back)
            # Newton's method may fall onto the parent, where the halves do not differ.
            if np.linalg.norm(asymmetry(problem, last.z)) > 0.3 * back:
                return last, end
    return before, end


def _matching(
    problem: PeriodicProblem, meeting: Array, doublings: Sequence[Doubling]
) -> Doubling | None:
    """Return the period doubling whose orbit is the one where the branch met its copy."""

    def distance(doubling: Doubling) -> float:
        parent, point = doubling
        return float(np.linalg.norm(doubled(parent, point) - meeting))

    nearest = min(doublings, key=distance, default=None)
    return nearest if nearest is not None and distance(nearest) < NEAR else None


def parent_point(
    problem: PeriodicProblem, last: Point, value: float, doublings: Sequence[Doubling]
) -> list[Point]:
    """Return the parent's period doubling as the last point of a closed branch, if it is known.

    Parameters
    ----------
    problem
        The boundary-value problem of the doubled branch.
    last
        Its last regular point.
    value
        Value of the parameter where it closes.
    doublings
        Known period doublings of the parent.
    """
    for parent, doubling in doublings:
        if parent.value(doubling.z) == value:
            z = doubled(parent, doubling)
            place = last.arclength + float(np.linalg.norm(z - last.z))
            square = doubling.monodromy @ doubling.monodromy
            return [make_point(z, last.tangent, place, square, doubling.residual)]
    return []


def doubled(parent: PeriodicProblem, point: Point) -> Array:
    """Return the unknown of an orbit passed twice, at the nodes of twice its period.

    Parameters
    ----------
    parent
        The boundary-value problem of the orbit.
    point
        The orbit.
    """
    m = parent.segments
    nodes = parent.nodes(point.z)[np.arange(0, 2 * m, 2) % m]
    return np.concatenate([parent.flat(nodes), point.z[parent.size :]])


def return_to_start(problem: Shooting, points: Sequence[Point], point: Point) -> Point | None:
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
