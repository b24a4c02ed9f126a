"""Branch points: where two branches cross, and the direction of the other one."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.locate import LostCurveError
from slipfold.continuation.newton import NEWTON
from slipfold.orbits.linearization import Linearization
from slipfold.orbits.orbit_curve import OrbitCurve, OrbitPoint


class CROSSING:
    """Rules for branch points."""

    # Half the distance over which first derivatives are differenced, in scaled variables: the error
    # of second derivatives is 1e-9 for rounding, and for truncation 1e-8, or 1e-4 where contacts
    # change nearby; the last ones are extrapolated from twice as much and half of it
    step: float = 1e-4
    iterations: int = 8  # maximum corrections of a branch point
    slope: float = 1e-6  # minimum slope, over the largest, of a number that crosses zero
    elsewhere: float = 0.05  # a branch point this far from where it was located is another one
    # Fraction of the largest component below which the parameter is constant along a direction
    oriented: float = 1e-4
    # Maximum remainder of the reduced equation at a branch point, in errors of the equations. Where
    # two folds face each other the remainder is larger: a step across the gap was too long
    remains: float = 10.0


@dataclass(frozen=True, eq=False)
class Crossing:
    """A branch point."""

    point: OrbitPoint  # the orbit, with the tangent of the branch on which it was met
    other: Array  # unit tangent of the other branch
    unsure: float  # uncertainty of its component along the parameter
    rounding: float  # what rounding can do to the parameter
    blurred: float  # what it can do to the place on a branch, in arclength


def find_crossing(
    curve: OrbitCurve, point: OrbitPoint, along: Array, length: float = 0.0
) -> Crossing | None:
    r"""Correct a branch point that was located on one branch, and find how the other leaves it.

    At a branch point the equations' Jacobian has a kernel of two dimensions and one vector psi on
    its left. The method of Lyapunov and Schmidt solves all equations but one: to coordinates c in
    the kernel belong an orbit z(c) and a number e(c) with

    .. math:: F(z) + e \psi = 0, \quad \Phi^T (z - z_0) = c

    which stays regular. Branches are e = 0; they cross where the gradient of e vanishes too, and
    leave along the directions in which its second derivative does: the algebraic branching equation
    (Keller, in Applications of Bifurcation Theory, 1977, 359-384; Govaerts, Numerical Methods for
    Bifurcations of Dynamical Equilibria, 2000, section 7.8).

    Within a step of some length that is long Newton's method may have led onto the other branch,
    far from the crossing: an error asks for a shorter one.
    """
    reduced = _Reduction(curve, point.z)
    place = np.zeros(2)
    for _ in range(CROSSING.iterations):
        slopes, hessian = reduced.slopes(place), reduced.hessian(place, CROSSING.step)
        if not np.isfinite(hessian).all() or abs(np.linalg.det(hessian)) < CROSSING.slope**2:
            return None
        step = np.linalg.solve(hessian, -slopes)
        place = place + step
        if np.linalg.norm(place) > CROSSING.elsewhere:
            if length > CROSSING.elsewhere:
                raise LostCurveError("a step led onto another branch before they cross")
            return None
        if np.linalg.norm(step) < NEWTON.still:
            break
    solved = reduced.solve(place)
    if solved is None:
        return None
    by_step = [reduced.hessian(place, 2.0**k * CROSSING.step) if k else hessian for k in (1, 0, -1)]
    coarse, hessian = (fine + (fine - other) / 3 for other, fine in pairwise(by_step))
    directions, near = _zero_directions(hessian), _zero_directions(coarse)
    if directions is None or near is None:
        return None
    if abs(solved.remainder) > CROSSING.remains * curve.orbits.by.remainder:
        raise LostCurveError("two branches come close and turn away from each other")
    moves = [solved.moves @ direction for direction in (*directions, *near)]
    tangents = [each / np.linalg.norm(each) for each in moves]
    alike = [float(tangent @ along) for tangent in tangents[:2]]
    own = int(np.abs(alike).argmax())
    other = _oriented(tangents[1 - own])
    unsure = min(abs(float(other[-1] - np.sign(each @ other) * each[-1])) for each in tangents[2:])
    part = solved.linearization
    residual = float(np.abs(part.residual).max())
    at = solved.z, tangents[own] * np.sign(alike[own]), point.arclength
    found = curve.derived_point(*at, part.monodromy, residual, part)
    # Rounding of the slopes moves the place, and with it the parameter.
    errors = solved.rounding * solved.moves @ np.linalg.inv(hessian)
    rounding, blurred = float(np.linalg.norm(errors[-1])), float(np.linalg.norm(errors, 2))
    return Crossing(found, other, unsure, rounding, blurred)


def _oriented(tangent: Array) -> Array:
    """Return a direction with the sign that rounding does not choose.

    The parameter rises along it; where that stands still, the first large component does.
    """
    sizes = np.abs(tangent)
    if sizes[-1] > CROSSING.oriented * sizes.max():
        return tangent * np.sign(tangent[-1])
    return tangent * np.sign(tangent[np.flatnonzero(sizes > 0.5 * sizes.max())[0]])


def _zero_directions(hessian: Array) -> list[Array] | None:
    """Return the two directions along which a quadratic form vanishes, None if it has a sign."""
    values, vectors = np.linalg.eigh(hessian)
    if not values[0] < 0 < values[1]:
        return None
    weights = np.sqrt(np.array([values[1], -values[0]]) / (values[1] - values[0]))
    return [vectors @ (weights * [1, sign]) for sign in (1, -1)]


@dataclass(frozen=True, eq=False)
class _Solved:
    """All equations but one solved: the orbit, what the last one leaves, and how both move."""

    z: Array
    remainder: float
    moves: Array
    slopes: Array
    linearization: Linearization
    rounding: float


class _Reduction:
    """The equations near an orbit reduced to one in two coordinates."""

    def __init__(self, curve: OrbitCurve, z: Array) -> None:
        self._curve = curve
        self._origin = z
        jacobian = curve.linearize(z).jacobian
        left, _, right = np.linalg.svd(jacobian)
        self._left = left[:, -1]
        self._kernel = right[-2:]

    def slopes(self, place: Array) -> Array:
        """Return the derivatives of the number that is left, shape (2,)."""
        solved = self.solve(place)
        return np.full(2, np.nan) if solved is None else solved.slopes

    def hessian(self, place: Array, step: float) -> Array:
        """Return its second derivatives, shape (2, 2), by central differences of the first."""
        rows = [self.slopes(place + way) - self.slopes(place - way) for way in step * np.eye(2)]
        hessian = np.array(rows) / (2 * step)
        return 0.5 * (hessian + hessian.T)

    def solve(self, place: Array) -> _Solved | None:
        """Solve all equations but one at two coordinates; None if that fails."""
        z = self._origin + self._kernel.T @ place
        remainder, n = 0.0, len(z)
        still = False
        for _ in range(CROSSING.iterations):
            linearization = self._curve.linearize(z)
            defect = linearization.defect + remainder * self._left
            if not np.isfinite(defect).all():
                return None
            matrix = np.zeros((n + 1, n + 1))
            matrix[: n - 1, :n] = linearization.jacobian
            matrix[: n - 1, n] = self._left
            matrix[n - 1 :, :n] = self._kernel
            try:
                inverse: Array = np.linalg.inv(matrix).astype(float)
            except np.linalg.LinAlgError:
                return None
            kept = self._kernel @ (z - self._origin) - place
            step = inverse @ np.concatenate([-defect, -kept])
            z, remainder = z + step[:n], remainder + float(step[n])
            if still:
                moves, slopes = inverse[:n, -2:], inverse[n, -2:]
                rounding = float(np.finfo(float).eps * np.linalg.norm(inverse, 2))
                return _Solved(z, remainder, moves, slopes, linearization, rounding)
            # The derivatives are those before the step: they are taken once it is rounding.
            still = bool(np.linalg.norm(step) < NEWTON.still)
        return None
