"""Newton's method for equations with one linear constraint, and the matrices it solves with."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from math import isfinite, isnan, log, sqrt
from typing import Any, Protocol

import numpy as np

from slipfold.arrays import Array


class NEWTON:
    """Rules for the convergence and the failure of Newton's method."""

    # Distance from where derivatives were taken below which they count as those of the solution:
    # multipliers, which may change a hundred times as much, are then right to 1e-8
    still: float = 1e-10
    # Estimated distance from the solution at which chord steps end; a Newton step follows
    exact: float = 1e-12
    # A correction this many times the one before means divergence
    growth: float = 10.0
    # Length of a correction below which chord steps follow, or may come first
    chord: float = 0.03
    # Maximum ratio of a chord step to the one before; else derivatives are computed again
    chord_gain: float = 0.5
    # Newton's method is aborted if the first chord step exceeds this multiple of the trust radius
    hopeless: float = 100.0
    # Ratio of a correction to the one before above which Newton's method no longer converges
    stalled: float = 0.3
    # Length of a correction below which one that no longer shrinks is a rounding error. Multipliers
    # magnify it: a solution with multipliers of 1e5 is known to 1e-10 at best. The residual decides
    rounding: float = 1e-5
    # Length of an unknown whose last digit is no longer rounding: corrections of it have no effect,
    # so that it would meet any equations
    farthest: float = rounding / np.finfo(float).eps
    chord_steps: int = 8
    # Points before a guess whose derivatives are extrapolated to it: with three there are a ninth
    # more chord steps, with six as many as with five
    known: int = 5


DIVERGED = "Newton's method diverged"
SINGULAR = "the equations met a singularity of the model"
TOO_SHARP = "the curve turns too sharply"


class Linearized(Protocol):
    """Equations at an unknown, with their derivatives."""

    @property
    def defect(self) -> Array:
        """The function that Newton's method brings to zero."""

    @property
    def is_finite(self) -> bool:
        """Whether the equations and all their derivatives exist."""

    def bordered(self, row: Array) -> SquareMatrix:
        """Return the Jacobian with one more row."""


class NewtonEquations(ABC):
    """Smooth equations, one less than there are unknowns."""

    @property
    def chords(self) -> bool:
        """Whether they cost much less without their derivatives."""
        return True

    @property
    def undefined(self) -> str:
        """Why they may have no finite values, as a clause."""
        return SINGULAR

    @abstractmethod
    def defect(self, z: Array) -> Array:
        """Return the function that Newton's method brings to zero."""

    @abstractmethod
    def linearize(self, z: Array) -> Linearized:
        """Return the same with its derivatives."""

    def residual(self, z: Array, defect: Array) -> float:
        """Return the residual of an unknown, in the norm that tolerances refer to."""
        return float(np.abs(defect).max())


@dataclass(frozen=True, eq=False)
class Correction:
    """The result of Newton's method."""

    z: Array  # the last iterate
    linearization: Any  # derivatives within `moved` of `z`; None where there are none
    bordered: Any  # its Jacobian bordered by the constraint; None likewise
    residual: float  # residual of `z`
    distance: float  # distance of `z` from the guess
    moved: float  # distance from where the derivatives were taken
    iterations: int  # number of linearizations
    row: Array  # normal of the hyperplane through the guess
    failure: str  # why there is no solution; empty if there is one

    @property
    def converged(self) -> bool:
        """Whether `z` is a solution."""
        return not self.failure


def correct(
    equations: NewtonEquations,
    guess: Array,
    row: Array,
    tolerance: float = 1e-10,
    iterations: int = 8,
    reach: float = np.inf,
    expected: Linearized | None = None,
) -> Correction:
    """Find the solution nearest a guess in the hyperplane through it.

    If derivatives are interpolated from neighbors, chord steps with them come first, so that new
    ones are computed once only.

    Shapes: guess, row (n,).
    """
    z, left = guess, np.inf
    if expected is not None:
        longest = min(NEWTON.chord, reach) / NEWTON.chord_gain
        z, _, left = _chord_steps(equations, expected.bordered(row), z, 0.0, longest)
        if left > NEWTON.hopeless * reach:
            failure = TOO_SHARP if np.isfinite(left) else equations.undefined
            return Correction(z, None, None, np.inf, 0.0, left, 0, row, failure)
    linearization, bordered = None, None
    moved, mismatch = np.inf, np.inf
    failure = f"no convergence in {iterations} corrections"
    taken = 0
    while taken < iterations:
        taken += 1
        linearization = _linearized(equations, z)
        if linearization is None:
            failure = equations.undefined
            break
        defect = linearization.defect
        bordered = linearization.bordered(row)
        step = bordered.solve(_right(defect, float(row @ (guess - z))))
        previous, moved = moved, length_of(step)
        # On a branch point, where chord steps may lead, no step exists.
        arrived = moved <= NEWTON.still or (left <= NEWTON.exact and isnan(moved))
        arrived = arrived or NEWTON.stalled * previous < moved < NEWTON.rounding
        if arrived and length_of(z) < NEWTON.farthest:
            mismatch = equations.residual(z, defect)
            if mismatch <= tolerance:
                z, failure = z if isnan(moved) else z + step, ""
                if not moved <= NEWTON.still:  # derivatives are those of where it ends
                    linearization, moved = _linearized(equations, z), 0.0
                    bordered = None if linearization is None else linearization.bordered(row)
                    failure = equations.undefined if linearization is None else ""
                break
        largest = max(NEWTON.growth * previous, NEWTON.rounding)
        if not moved < largest or length_of(z) > NEWTON.farthest:
            failure = DIVERGED
            break
        if moved > reach:
            failure = TOO_SHARP
            break
        z, left = z + step, np.inf
        if moved < NEWTON.chord and equations.chords:
            longest = max(NEWTON.growth * moved, NEWTON.rounding)
            z, moved, left = _chord_steps(equations, bordered, z, float(row @ (guess - z)), moved)
            if not left < longest:
                moved, failure = left, DIVERGED if isfinite(left) else equations.undefined
                break
    away = length_of(z - guess)
    z = np.where(np.abs(row) == 1, guess, z)  # on a wall exactly, whatever rounding did
    return Correction(z, linearization, bordered, mismatch, away, moved, taken, row, failure)


def _linearized(equations: NewtonEquations, z: Array) -> Linearized | None:
    """Return the derivatives at an unknown, None where they are not finite."""
    try:
        with np.errstate(all="ignore"):  # rates may overflow where a step went too far
            linearization = equations.linearize(z)
    except np.linalg.LinAlgError:  # of matrices that are not finite
        return None
    return linearization if linearization.is_finite else None


def _chord_steps(
    equations: NewtonEquations, bordered: SquareMatrix, z: Array, constraint: float, moved: float
) -> tuple[Array, float, float]:
    """Take steps with the old derivatives, which cost a third of new ones, while these converge.

    Each step updates the derivatives (Broyden's method, in the form that stores steps instead of
    matrices). The next derivatives are then computed so near the solution that they are the last.
    Also return the length of the last step and the estimated distance from the solution.
    """
    steps: list[Array] = []
    turned: list[Array] = []  # each step over the square of its length
    left = np.inf
    for _ in range(NEWTON.chord_steps):
        defect = equations.defect(z)
        if not isfinite(np.dot(defect, defect)):  # as are all its terms; cheaper than to ask each
            break
        step = bordered.solve(_right(defect, constraint))
        for one, next_one in zip(turned, steps[1:], strict=False):
            step = step + (one @ step) * next_one
        if steps:
            gained = 1 - turned[-1] @ step
            if gained == 0:  # the updated matrix is singular
                break
            step = step / gained
        left = length = length_of(step)
        if not 0 < length <= NEWTON.chord_gain * moved:  # nothing is left to do where it is zero
            break
        left *= length / moved if steps else NEWTON.chord_gain
        z, moved, constraint = z + step, length, 0.0
        if left <= NEWTON.exact:
            break
        steps.append(step)
        turned.append(step / (length * length))
    return z, moved, left


def _right(defect: Array, constraint: float) -> Array:
    """Right-hand side of a Newton step."""
    right = np.empty(len(defect) + 1)
    np.negative(defect, out=right[:-1])
    right[-1] = constraint
    return right


def length_of(vector: Array) -> float:
    """Return the Euclidean length of a vector, in a third of the time that NumPy's takes."""
    return sqrt(np.dot(vector, vector))  # which may overflow where Newton's method diverges


# -- a Jacobian with one more row -----------------------------------------------------------------


class SquareMatrix(ABC):
    """A Jacobian with one more row: its solutions, tangent and determinant."""

    @property
    @abstractmethod
    def matrix(self) -> Array:
        """The whole matrix."""

    @abstractmethod
    def solve(self, right: Array) -> Array:
        """Return the solution for a right-hand side, NaN if the matrix is singular."""

    def solve_transposed(self, right: Array) -> Array:
        """Return the solution with the transposed matrix."""
        return np.asarray(np.linalg.solve(self.matrix.T, right), dtype=float)

    @property
    @abstractmethod
    def _kernel(self) -> Array:
        """Last column of the inverse."""

    @property
    @abstractmethod
    def _determinant(self) -> tuple[float, float]:
        """Sign and logarithm of the determinant."""

    @property
    def sign(self) -> int:
        """Sign of the determinant."""
        return int(self._determinant[0])

    @property
    def volume(self) -> float:
        """Logarithm of the determinant's modulus if the tangent were the last row.

        A row r and the tangent t give determinants in the ratio r t, and the last column of the
        inverse is t/(r t).
        """
        return self._determinant[1] + log(length_of(self._kernel))

    def tangent(self) -> Array:
        """Return the unit vector of the kernel that the last row leaves, along that row."""
        kernel = self._kernel
        return np.asarray(kernel / length_of(kernel))


class WholeMatrix(SquareMatrix):
    """A full matrix, inverted once."""

    def __init__(self, matrix: Array) -> None:
        self._matrix = matrix

    @property
    def matrix(self) -> Array:
        """The whole matrix."""
        return self._matrix

    @cached_property
    def _inverse(self) -> Array:
        """Inverse, NaN if there is none."""
        try:
            inverse = np.asarray(np.linalg.inv(self.matrix), dtype=float)
        except np.linalg.LinAlgError:
            return np.full_like(self.matrix, np.nan)
        return inverse if np.isfinite(inverse).all() else np.full_like(inverse, np.nan)

    def solve(self, right: Array) -> Array:
        """Return the solution for a right-hand side, NaN if the matrix is singular."""
        return self._inverse @ right

    @property
    def _kernel(self) -> Array:
        return self._inverse[:, -1]

    @cached_property
    def _determinant(self) -> tuple[float, float]:
        sign, logarithm = np.linalg.slogdet(self.matrix)
        return float(sign), float(logarithm)


class LeastSquares(WholeMatrix):
    """A full matrix of more equations than unknowns, which a solution meets nevertheless.

    Newton's method with the pseudo-inverse converges to it as with an inverse. There is no
    determinant.
    """

    @cached_property
    def _inverse(self) -> Array:
        """Pseudo-inverse, NaN if there is none."""
        try:
            return np.asarray(np.linalg.pinv(self.matrix), dtype=float)
        except np.linalg.LinAlgError:
            return np.full_like(self.matrix.T, np.nan)

    def solve_transposed(self, right: Array) -> Array:
        """Return the least solution with the transposed matrix."""
        return self._inverse.T @ right

    @cached_property
    def _determinant(self) -> tuple[float, float]:
        return 0.0, 0.0
