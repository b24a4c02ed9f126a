"""Newton's method for an orbit under one linear constraint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.orbits.linearisation import Bordered, Linearisation
from slipfold.orbits.shooting import Shooting

__all__ = ["Correction", "correct"]

Array = NDArray[np.float64]

STILL = 1e-10
"""Derivatives are those of the orbit once it has moved by less than this since they were taken:
multipliers, which may move a hundred times as far, are then right to 1e-8."""

GROWTH = 10.0
"""A correction this many times the one before means divergence."""

CHORD = 0.03
"""Corrections below this are followed by chord steps."""

CHORD_STEPS = 3

CHORD_GAIN = 0.1
"""A chord step must be this much shorter than the one before, or derivatives are renewed."""

ROUNDING = 1e-5
"""Corrections below this that no longer shrink are rounding errors, magnified by the multipliers:
an orbit with multipliers of 1e5 is known to 1e-10 at best, and its residual decides."""


@dataclass(frozen=True, eq=False)
class Correction:
    """What Newton's method came to.

    Parameters
    ----------
    z
        The last iterate.
    linearisation
        Derivatives within `moved` of `z`; None where the flow met a singularity.
    bordered
        Its Jacobian bordered by the constraint; None likewise.
    residual
        Largest mismatch at `z`, in scaled states.
    distance
        Distance from the guess.
    moved
        Distance from where the derivatives were taken.
    iterations
        Number of linearisations.
    failure
        Empty, or why there is no orbit.
    """

    z: Array
    linearisation: Linearisation | None
    bordered: Bordered | None
    residual: float
    distance: float
    moved: float
    iterations: int
    failure: str

    @property
    def converged(self) -> bool:
        """Whether `z` is an orbit."""
        return not self.failure


def correct(
    problem: Shooting,
    guess: Array,
    row: Array,
    tolerance: float = 1e-10,
    iterations: int = 8,
    reach: float = np.inf,
) -> Correction:
    """Find the orbit nearest a guess in the hyperplane through it.

    Parameters
    ----------
    problem
        The equations, one less than unknowns.
    guess
        Start, shape (m n + k,) with k free parameters.
    row
        Normal of the hyperplane, shape (m n + k,). The unit vector of a parameter keeps that.
    tolerance
        Largest mismatch of an accepted orbit, in scaled states, measured on the result itself.
    iterations
        Linearisations before giving up.
    reach
        A first correction longer than this is given up at once.
    """
    z = guess
    linearisation, bordered = None, None
    moved, mismatch = np.inf, np.inf
    failure = f"no convergence in {iterations} corrections"
    taken = 0
    while taken < iterations:
        taken += 1
        linearisation = problem.linearise(z)
        defect = linearisation.defect
        if not np.isfinite(defect).all():
            failure = "the orbit met a singularity of the model"
            break
        bordered = linearisation.bordered(row)
        step = bordered.solve(np.append(-defect, row @ (guess - z)))
        previous, moved = moved, float(np.linalg.norm(step))
        if not moved < max(GROWTH * previous, ROUNDING):
            failure = "Newton's method diverged"
            break
        if moved > reach:
            failure = "the branch turns too sharply"
            break
        z = z + step
        at_rounding = moved < ROUNDING and moved > 0.3 * previous
        if moved <= STILL or at_rounding:
            mismatch = float(np.abs(problem.defect(z)).max()) * np.sqrt(problem.segments)
            if mismatch <= tolerance:
                failure = ""
                if moved > STILL:
                    linearisation = problem.linearise(z)
                    bordered, moved = linearisation.bordered(row), 0.0
                break
        elif moved < CHORD:
            z, moved = _chord_steps(problem, bordered, z, float(row @ (guess - z)), moved)
    return Correction(
        z,
        linearisation,
        bordered,
        mismatch,
        float(np.linalg.norm(z - guess)),
        moved,
        taken,
        failure,
    )


def _chord_steps(
    problem: Shooting,
    bordered: Bordered,
    z: Array,
    constraint: float,
    moved: float,
) -> tuple[Array, float]:
    """Go on with the old derivatives, which cost a third of new ones, while that gains digits.

    The next derivatives are then taken so near the orbit that they are the last.
    """
    for _ in range(CHORD_STEPS):
        defect = problem.defect(z)
        if not np.isfinite(defect).all():
            break
        step = bordered.solve(np.append(-defect, constraint))
        length = float(np.linalg.norm(step))
        if length > CHORD_GAIN * moved:
            break
        z, moved, constraint = z + step, length, 0.0
        if moved <= STILL:
            break
    return z, moved
