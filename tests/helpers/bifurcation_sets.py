"""Bifurcation sets, and special points of responses held against them.

What a response finds in one parameter and what a locus says in two meet on a line of the plane.
Between its points a locus is interpolated by a spline here, not by what the package uses.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from slipfold import InputError, Settings, SlidingOscillator, Steps
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.loci.bifurcation_set import find_bifurcation_set
from slipfold.bifurcations.loci.locus_equations import LocusEquations
from slipfold.bifurcations.loci.make_locus import coefficient_at
from slipfold.continuation.newton import correct
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.normal_forms.normal_form import criticality_of

PLANES = {
    ("f", "Nd"): ((11.5, 13.5), (0.0, 0.98)),
    ("Vd", "Nd"): ((0.3, 1.2), (0.0, 0.98)),
    ("alpha", "Nd"): ((0.0, np.pi), (0.0, 0.98)),
    ("mu", "Nd"): ((0.1, 0.9), (0.0, 0.98)),
    ("Ns", "Nd"): ((0.5, 2.0), (0.0, 0.49)),
}
"""Windows of the checks; all values besides are those of the base case."""

TYPES = ("LP", "PD", "NS")
SAMPLES = 24
SAME_VALUE = 1e-8
SAME_ORBIT = 1e-5
NEAR = 0.1
PASSES = 1e-3
"""Distance from a branch, in scaled states, below which the branch passes an orbit."""


OFTEN = ("f", "Nd")
"""The plane whose regions are tested in every run; its set is computed once, with regions."""


def whole_set(plane, regions=False):
    """Everything in the window of a plane."""
    return _whole_set(plane, regions or plane == OFTEN)


@lru_cache(maxsize=16)
def _whole_set(plane, regions):
    with pytest.MonkeyPatch.context() as patch:
        # Those across the middle lead to all that there is: the rest is a quarter of the time.
        if plane == OFTEN:
            patch.setattr("slipfold.bifurcations.loci.bifurcation_set.LINES", (1, 1))
        return find_bifurcation_set(SlidingOscillator(), plane, PLANES[plane], regions=regions)


@lru_cache(maxsize=128)
def response(vary, span, values, largest_period=2, largest=0.5):
    """Special points and branches of one response; immutable, so that tests share them."""
    settings = Settings(steps=Steps(largest=largest), largest_period=largest_period)
    return trace_response(SlidingOscillator(**dict(values)), vary, span, settings=settings)


def bifurcations(branches, *kinds):
    """Special points of the types that have a locus, or of some of them."""
    return [p for b in branches for p in b.special if p.type in (kinds or TYPES)]


class Orbit(NamedTuple):
    """An orbit by its period and its nodes."""

    period: int
    nodes: np.ndarray


@dataclass(frozen=True)
class Crossing:
    """Where a locus crosses a line of the plane; or any other point of it."""

    locus: object
    problem: object
    point: object

    @property
    def values(self):
        return self.problem.orbits.values(self.point.z)

    @property
    def nodes(self):
        return self.problem.orbits.nodes(self.point.z)

    @property
    def orbit(self):
        return Orbit(self.locus.period, self.nodes)

    @property
    def multipliers(self):
        return self.point.multipliers

    @property
    def coefficient(self):
        return coefficient_at(self.problem, self.point)

    @property
    def criticality(self):
        return criticality_of(self.locus.type, self.coefficient)

    @property
    def name(self):
        a, b = self.values
        return f"{self.locus.type} of period {self.locus.period} at {a:.9f}, {b:.9f}"


def crossings(loci, axis, value):
    """All crossings of loci with the line where one parameter has a value."""
    return [item for locus in loci for item in locus_crossings(locus, axis, value)]


def _propagated(problem, z, index, target, row):
    """Bring a point of a locus to another value of a parameter, in steps."""
    for place in np.linspace(z[index], target, 17)[1:]:
        guess = z.copy()
        guess[index] = place
        found = correct(problem, guess, row, iterations=20)
        z = found.z
    return found


@lru_cache(maxsize=128)
def _locus_curve(locus):
    """A locus between its points, as unknowns of its equations; places on it, close together."""
    widths = tuple(map(float, np.ptp(locus.values, axis=0)))
    vary = dict(zip(locus.vary, widths, strict=True))
    orbits = ForcedOrbits(locus.model, vary, locus.period, locus.nodes.shape[1])
    pairs = zip(locus.nodes, locus.values, strict=True)
    s, z = locus.arclength, np.array([orbits.join(*pair) for pair in pairs])
    spline = CubicSpline(s, z)
    grid = np.unique(np.concatenate([np.linspace(a, b, SAMPLES) for a, b in pairwise(s)]))
    return widths, LocusEquations(orbits, locus.type), z, spline, grid, spline(grid)


def locus_crossings(locus, axis, value):
    """Crossings of one locus: from a spline through its points, corrected."""
    widths, problem, z, spline, grid, places = _locus_curve(locus)
    s = locus.arclength
    gaps = places[:, axis - 2] - value / widths[axis]
    row = np.zeros(z.shape[1])
    row[axis - 2] = 1.0
    for i in np.flatnonzero((gaps[:-1] > 0) != (gaps[1:] > 0)):
        share = gaps[i] / (gaps[i] - gaps[i + 1])
        guess = spline(grid[i] + share * (grid[i + 1] - grid[i]))
        guess[axis - 2] = value / widths[axis]
        found = correct(problem, guess, row, iterations=20)
        if not found.converged:  # points are as sparse as their tangents allow, a spline has none
            near = z[np.abs(s - grid[i]).argmin()]
            found = _propagated(problem, near, axis - 2, guess[axis - 2], row)
        assert found.converged, f"{locus.type} at {locus.vary[axis]} = {value}: {found.failure}"
        yield Crossing(locus, problem, problem.point(found, 0.0))


def same_orbit(nodes, others, scales, period):
    """Distance of two orbits in scaled states, whatever phase they begin in."""
    m = len(nodes)
    return min(
        np.abs((np.roll(nodes, -turn * m // period, axis=0) - others) / scales).max()
        for turn in range(period)
    )


def matches(point, crossing, plane):
    """Whether a special point is what a locus has on its line."""
    locus = crossing.locus
    if (point.type, point.period) != (locus.type, locus.period):
        return False
    values = np.array([point.model.values[name] for name in plane])
    if np.abs(values - crossing.values).max() > SAME_VALUE:
        return False
    scales = point.model.state_scales()
    return same_orbit(point.nodes, crossing.nodes, scales, point.period) < SAME_ORBIT


def _branch_curve(branch):
    """A branch between its points, as unknowns of a boundary-value problem."""
    width = float(np.ptp(branch.parameter)) or 1.0
    segments = branch.nodes.shape[1]
    problem = ForcedOrbits(branch.model, {branch.vary: width}, branch.period, segments)
    pairs = zip(branch.nodes, branch.parameter, strict=True)
    z = np.array([problem.join(*pair) for pair in pairs])
    return problem, CubicSpline(branch.arclength, z)


def passes(branch, orbit, value):
    """Whether a branch passes an orbit.

    The orbit of the branch is looked for in the hyperplane through the other, abeam of it.
    """
    if branch.period != orbit.period or len(branch) < 2:
        return False
    problem, spline = _branch_curve(branch)
    s = branch.arclength
    grid = np.unique(np.concatenate([np.linspace(a, b, SAMPLES) for a, b in pairwise(s)]))
    places = spline(grid)
    for turn in range(branch.period):
        rolled = np.roll(orbit.nodes, -turn * problem.segments // branch.period, axis=0)
        target = problem.join(rolled, value)
        distance = np.linalg.norm(places - target, axis=1)
        falls, rises = distance[1:] <= distance[:-1], distance[:-1] <= distance[1:]
        nearest = np.flatnonzero(np.r_[True, falls] & np.r_[rises, True] & (distance < NEAR))
        for i in nearest:
            row = spline(grid[i], 1)
            row /= np.linalg.norm(row)
            guess = places[i] + row * (row @ (target - places[i]))
            found = correct(problem, guess, row, reach=2 * NEAR)
            if found.converged and np.linalg.norm(found.z - target) < PASSES:
                return True
    return False


def orbits_at(branch, value):
    """Nodes of all orbits of a branch at a value of its parameter."""
    problem, spline = _branch_curve(branch)
    gaps = branch.parameter - value
    for i in np.flatnonzero((gaps[:-1] > 0) != (gaps[1:] > 0)):
        a, b = branch.arclength[i : i + 2]
        guess = spline(a + gaps[i] / (gaps[i] - gaps[i + 1]) * (b - a))
        guess[-1] = value / problem.width
        found = correct(problem, guess, hold_parameter(problem.size), iterations=20)
        if found.converged:
            yield problem.nodes(found.z)


@dataclass(frozen=True)
class Comparison:
    """A line's special points held against the crossings of loci with it.

    Parameters
    ----------
    points
        Number of special points.
    off
        Special points that are on no locus.
    missing
        Crossings whose orbit was passed without being found.
    excused
        Crossings whose orbit is connected with none that was followed.
    """

    vary: str
    value: float
    points: int
    off: tuple
    missing: tuple
    excused: tuple


def compare(plane, loci, axis, value, branches):
    """Hold a response against the loci on its line.

    Parameters
    ----------
    axis
        Which parameter of the plane is fixed; the response is in the other.
    """
    window = PLANES[plane]
    vary, (low, high) = plane[1 - axis], window[1 - axis]
    points = [p for p in bifurcations(branches) if p.period <= 2 and low <= p.value <= high]
    here = crossings(loci, axis, value)
    off = [p for p in points if not any(matches(p, c, plane) for c in here)]
    unmet = [c for c in here if not any(matches(p, c, plane) for p in points)]
    # A response consists of the orbits connected with its first one. What it does not pass, it
    # cannot find.
    missing, excused = [], []
    for crossing in unmet:
        at = float(crossing.values[1 - axis])
        passed = any(passes(branch, crossing.orbit, at) for branch in branches)
        (missing if passed else excused).append(crossing.name)
    described = tuple(
        f"{p.type} of period {p.period} at {vary} = {p.value:.9f}, {plane[axis]} = {value:.9f}"
        for p in off
    )
    return Comparison(vary, value, len(points), described, tuple(missing), tuple(excused))


def compared_at(plane, loci, axis, place):
    """Compare on the line through a place; None if there is no response."""
    fixed, vary = plane[axis], plane[1 - axis]
    value = float(place[axis])
    try:
        branches = response(vary, PLANES[plane][1 - axis], ((fixed, value),))
    except InputError:
        return None
    return compare(plane, loci, axis, value, branches)
