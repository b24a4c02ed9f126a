"""Newton's method for the collocation equations of a whole orbit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.collocation.condensation import Condensed, Iterate, condense
from slipfold.collocation.reference import Reference
from slipfold.collocation.vector_field import VectorField

ITERATIONS = 12

STILL = 1e-12
"""A step this short, in scaled states, is rounding for states of size one."""

ROUNDING = 1e-7
"""Steps below this that no longer shrink are rounding, magnified by the multipliers."""

FAR = 1e6
"""Steps longer than this, in scaled states, lead nowhere."""

BORDERINGS = 3
"""Times that the vectors of a nearly singular matrix are taken from the matrix bordered by the last
ones: the first borders are any, and the error of those after is that of the matrix being regular,
1e-4 and less, times their own."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What Newton's method came to."""

    iterate: Iterate  # the last iterate
    matrices: Array  # transition matrices of its intervals, shape (N, n, n)
    mismatch: float  # largest violation of an equation, in scaled states
    converged: bool  # whether the steps shrank to rounding


@dataclass(frozen=True, eq=False)
class Unfolding:
    r"""What makes the equations of an orbit at a fold or branch point regular.

    The equations F(u) = 0 become :math:`F(u) + \beta \psi = 0` and
    :math:`\phi^T (u - u_r) = 0` with a new unknown :math:`\beta` and the vectors that the matrix
    sends to nearly nothing from either side. How far :math:`\beta` is from zero is a part of the
    mismatch.
    """

    column: Array  # the vector psi, shape (size,)
    row: Array  # the vector phi at the reference's nodes, zero elsewhere, shape (size,)


def solve(field: VectorField, guess: Iterate, reference: Reference) -> Solution:
    """Solve the collocation equations on one mesh."""
    iterate, step = guess, np.inf
    condensed = condense(field, iterate)
    unfolding = _unfolding(condensed, iterate, reference) if reference.singular else None
    for _ in range(ITERATIONS):
        nodes, time, excess = _step(condensed, iterate, reference, unfolding)
        stages = condensed.stages(nodes, time)
        previous, step = step, float(np.abs(nodes).max())
        if not np.abs(stages).max() < FAR or not iterate.time + time > 0:
            break
        iterate = iterate.moved(nodes, stages, time)
        condensed = condense(field, iterate)
        if step < STILL or ROUNDING > step > 0.5 * previous:
            mismatch = max(condensed.mismatch, excess)
            return Solution(iterate, condensed.matrices, mismatch, True)
    return Solution(iterate, condensed.matrices, condensed.mismatch, False)


def _step(
    condensed: Condensed, iterate: Iterate, reference: Reference, unfolding: Unfolding | None
) -> tuple[Array, float, float]:
    """Return the changes of nodes and unit of time, and what the unfolding has to add."""
    matrix, right = _system(condensed, iterate, reference)
    count, n = condensed.defects.shape
    size = len(right)
    if unfolding is not None:
        matrix = _bordered(matrix, unfolding.column, unfolding.row)
        beside = np.zeros(size)
        beside[: count * n] = (iterate.nodes - reference.spread(iterate.edges)).ravel()
        right = np.append(right, -unfolding.row @ beside)
    step = _factors(matrix)(right)
    excess = 0.0 if unfolding is None else float(np.abs(step[-1] * unfolding.column).max())
    time = float(step[count * n]) if reference.rates is not None else 0.0
    return step[: count * n].reshape(count, n), time, excess


def _system(condensed: Condensed, iterate: Iterate, reference: Reference) -> tuple[Any, Array]:
    """Return matrix and right-hand side of a Newton step.

    Block pattern for three intervals (G transition matrix, I identity; for a cycle also t, the
    pull of the time, and the phase condition as last row)::

        [ G -I  .  t ]
        [ .  G -I  t ]
        [-I  .  G  t ]
        [ -- row -- .]
    """
    from scipy.sparse import bsr_array

    count, n = condensed.defects.shape
    size = count * n
    blocks = np.empty((2 * count, n, n))
    blocks[::2], blocks[1::2] = condensed.matrices, -np.eye(n)
    own = np.arange(count)
    columns = np.stack([own, (own + 1) % count], axis=1).ravel()
    matrix = bsr_array((blocks, columns, 2 * np.arange(count + 1)), shape=(size, size))
    right = -condensed.defects.ravel()
    if reference.rates is None:
        return matrix, right
    row = np.zeros((count, n))
    row[reference.places(iterate.edges)] = reference.rates
    value = float(np.sum((iterate.nodes - reference.spread(iterate.edges)) * row))
    return _bordered(matrix, condensed.pulls.ravel(), row.ravel()), np.append(right, -value)


def _unfolding(condensed: Condensed, iterate: Iterate, reference: Reference) -> Unfolding:
    """Return the null vectors, from bordered systems: the matrix itself may be exactly singular."""
    matrix, right = _system(condensed, iterate, reference)
    count, n = condensed.defects.shape
    column = np.cos(np.arange(len(right)))  # any vector, but not one with a symmetry
    column /= np.linalg.norm(column)
    null = column
    unit = np.zeros(len(right) + 1)
    unit[-1] = 1.0
    for _ in range(BORDERINGS):
        solved = _factors(_bordered(matrix, column, null))
        null, column = solved(unit)[:-1], solved(unit, "T")[:-1]
        null, column = null / np.linalg.norm(null), column / np.linalg.norm(column)
    row = np.zeros(len(right))
    places = reference.places(iterate.edges)
    row[: count * n].reshape(count, n)[places] = null[: count * n].reshape(count, n)[places]
    return Unfolding(column, row)


def _bordered(matrix: Any, column: Array, row: Array) -> Any:
    from scipy.sparse import block_array, csr_array

    return block_array([[matrix, csr_array(column[:, None])], [csr_array(row[None]), None]])


def _factors(matrix: Any) -> Any:
    """Return the function that solves with a sparse matrix; its results are NaN if singular."""
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    try:
        return splu(csc_array(matrix)).solve
    except RuntimeError:  # the factor is exactly singular
        return lambda right, _="N": np.full_like(right, np.nan)
