"""Newton's method for many orbits of a branch at once, each in a hyperplane of its own.

One orbit after the other fills the lanes of the flow with its own segments and pays for each call;
here all segments of all orbits go side by side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.linearisation import Linearisation

__all__ = ["Corrected", "correct_many"]

Array = NDArray[np.float64]

ITERATIONS = 6

CLOSE = 1e-6
"""A correction shorter than this is the last: as Newton's method squares it, what is left is below
1e-10. The derivatives, taken before it, are good to about ten times its length."""

LONGEST = 0.5
"""A correction this long, in scaled variables, leads to another branch."""


@dataclass(frozen=True, eq=False)
class Corrected:
    """Orbits of one period.

    Parameters
    ----------
    z
        Unknowns of the boundary-value problem, shape (k, m n + 1); NaN where Newton's method
        failed.
    monodromies
        Monodromy matrices in scaled states, taken within the last correction of `z`, shape
        (k, n, n).
    tangents
        Unit tangents of the branch, along the rows of the hyperplanes, shape (k, m n + 1).
    """

    z: Array
    monodromies: Array
    tangents: Array

    def some(self, rows: list[int]) -> Corrected:
        """Return some of the orbits."""
        return Corrected(self.z[rows], self.monodromies[rows], self.tangents[rows])

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether each orbit was found, shape (k,)."""
        return np.asarray(np.isfinite(self.z).all(axis=1))


def correct_many(
    problem: PeriodicProblem, guesses: Array, rows: Array, close: float = CLOSE
) -> Corrected:
    """Find the orbits nearest guesses, each in the hyperplane through it.

    Shapes: guesses, rows (k, m n + 1).
    """
    z = guesses.copy()
    k, size = z.shape
    n = len(problem.scales)
    monodromies = np.full((k, n, n), np.nan)
    tangents = np.full((k, size), np.nan)
    active = np.arange(k)
    for _ in range(ITERATIONS):
        if not len(active):
            break
        defects, matrices, monodromies[active] = _linearise(problem, z[active], rows[active])
        behind = np.einsum("ka,ka->k", rows[active], guesses[active] - z[active])
        right = np.zeros((len(active), size, 2))
        right[:, :-1, 0], right[:, -1, 0], right[:, -1, 1] = -defects, behind, 1.0
        solved = _solve(matrices, right)
        step = solved[:, :, 0]
        length = np.linalg.norm(step, axis=1)
        tangents[active] = solved[:, :, 1] / np.linalg.norm(solved[:, :, 1], axis=1)[:, None]
        lost = ~(length < LONGEST)
        z[active] += np.where(lost[:, None], np.nan, step)
        active = active[~lost & ~(length < close)]
    z[active] = np.nan
    return Corrected(z, monodromies, tangents)


def _linearise(problem: PeriodicProblem, z: Array, rows: Array) -> tuple[Array, Array, Array]:
    """Return defects (k, m n), bordered Jacobians, and monodromy matrices."""
    k, m, n = len(z), problem.segments, len(problem.scales)
    nodes = np.array([problem.nodes(item) for item in z])
    vectors = np.array([problem.vector(item) for item in z])
    constants = problem.flow.constants(vectors, problem.flow_scales)
    directions = np.repeat(constants.rates[:, :, problem.indices], m, axis=0)
    edges = np.arange(m + 1) * (problem.period / m)
    ends, blocks, vectors = problem.flow.linearise(
        nodes.reshape(k * m, n),
        np.tile(edges[:-1], k),
        np.tile(edges[1:], k),
        constants.repeated(m),
        directions,
    )
    scales = problem.scales
    residual = (ends.reshape(k, m, n) - np.roll(nodes, -1, axis=1)) / scales
    blocks = blocks.reshape(k, m, n, n) * (scales[None, :] / scales[:, None])
    along = vectors.reshape(k, m, n, -1) * (problem.units / np.sqrt(m) / scales[:, None])
    parts = [Linearisation(*item) for item in zip(residual, blocks, along, strict=True)]
    return (
        np.array([part.defect for part in parts]),
        np.array([part.bordered(row).matrix for part, row in zip(parts, rows, strict=True)]),
        np.array([part.monodromy for part in parts]),
    )


def _solve(matrices: Array, right: Array) -> Array:
    """Solve linear systems; NaN where one is singular or not finite."""
    result = np.full_like(right, np.nan)
    good = np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(right).all(axis=(1, 2))
    try:
        result[good] = np.linalg.solve(matrices[good], right[good])
    except np.linalg.LinAlgError:
        for i in np.flatnonzero(good):
            try:
                result[i] = np.linalg.solve(matrices[i], right[i])
            except np.linalg.LinAlgError:
                continue
    return result
