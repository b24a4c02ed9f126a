"""Collocation equations of each interval, solved for what happens inside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.collocation.vector_field import RightHandSide
from slipfold.collocation_points import gauss_points
from slipfold.models.turns import without_turns

CHUNK = 4_000_000
"""Numbers in the matrices that are held at a time: 32 MB."""


@dataclass(frozen=True, eq=False)
class Iterate:
    """Piecewise polynomials that Newton's method improves, in scaled states."""

    edges: Array  # phases at which intervals begin and end, shape (N + 1,)
    nodes: Array  # states at the beginning of each interval, shape (N, n)
    stages: Array  # states at the Gauss points, shape (N, m, n)
    time: float  # seconds in a unit of phase

    @property
    def lengths(self) -> Array:
        """Lengths of the intervals in units of phase, shape (N,)."""
        return np.diff(self.edges)

    @property
    def phases(self) -> Array:
        """Phases of the Gauss points, shape (N, m)."""
        points = gauss_points(self.stages.shape[1]).points
        return np.asarray(self.edges[:-1, None] + self.lengths[:, None] * points)

    def moved(self, nodes: Array, stages: Array, time: float) -> Iterate:
        """Return the iterate after a step."""
        return Iterate(self.edges, self.nodes + nodes, self.stages + stages, self.time + time)


@dataclass(frozen=True, eq=False)
class Condensed:
    r"""Linearised equations between the nodes alone, and the way back to the stages.

    .. math:: G_i \delta x_i + t_i \delta T - \delta x_{i+1} = -r_i
    """

    matrices: Array  # transition matrices G, shape (N, n, n)
    # Derivatives t of the interval's end with respect to the unit of time, shape (N, n)
    pulls: Array
    defects: Array  # what r is left to the equations between the nodes, shape (N, n)
    # Change of the stages: with each component of the node, with the unit of time, and what the
    # equations inside the interval ask for, shape (N, m, n, n + 2)
    inside: Array
    mismatch: float  # largest violation of any collocation equation, in scaled states

    def stages(self, nodes: Array, time: float) -> Array:
        """Return the change of the stages that belongs to a change of the nodes.

        Shapes: nodes (N, n).
        """
        n = nodes.shape[1]
        change = np.einsum("iknj,ij->ikn", self.inside[..., :n], nodes)
        return np.asarray(change + self.inside[..., n] * time + self.inside[..., n + 1])


def condense(field: RightHandSide, iterate: Iterate) -> Condensed:
    r"""Linearise the collocation equations and eliminate the stages.

    They are written in the Runge-Kutta basis, which rounding hurts least (Ascher, Mattheij and
    Russell, Numerical Solution of Boundary Value Problems, SIAM 1995, section 5.6),

    .. math:: Y_l = x + h T \sum_k a_{lk} f(Y_k), \quad x_+ = x + h T \sum_k b_k f(Y_k).
    """
    count, m, n = iterate.stages.shape
    each = max(1, CHUNK // (m * n) ** 2)
    following = np.roll(iterate.nodes, -1, axis=0)
    parts = [
        _condense_some(field, iterate, following, slice(first, first + each))
        for first in range(0, count, each)
    ]
    return Condensed(
        np.concatenate([part.matrices for part in parts]),
        np.concatenate([part.pulls for part in parts]),
        np.concatenate([part.defects for part in parts]),
        np.concatenate([part.inside for part in parts]),
        max(part.mismatch for part in parts),
    )


def _condense_some(
    field: RightHandSide, iterate: Iterate, following: Array, some: slice
) -> Condensed:
    nodes, stages = iterate.nodes[some], iterate.stages[some]
    steps, time = iterate.lengths[some, None, None], iterate.time
    count, m, n = stages.shape
    gauss = gauss_points(m)
    inner = gauss.inner
    rates, jacobians = field.linear(stages, iterate.phases[some])
    grown = steps * np.einsum("lk,ikn->iln", inner, rates)
    outgrown = steps[:, 0] * np.einsum("k,ikn->in", gauss.weights, rates)
    beside = stages - nodes[:, None] - time * grown
    unequal = without_turns(nodes + time * outgrown - following[some], field.turns)

    matrix = np.einsum("lk,ikab->ilakb", -time * inner, jacobians * steps[..., None])
    matrix = matrix.reshape(count, m * n, m * n)
    matrix[:, np.arange(m * n), np.arange(m * n)] += 1.0
    right = np.empty((count, m, n, n + 2))
    right[..., :n] = np.eye(n)
    right[..., n] = grown
    right[..., n + 1] = -beside
    inside = np.linalg.solve(matrix, right.reshape(count, m * n, n + 2))
    inside = inside.reshape(count, m, n, n + 2)

    weighted = gauss.weights[:, None, None] * (time * steps[..., None]) * jacobians
    carried = np.einsum("ikab,ikbc->iac", weighted, inside)
    return Condensed(
        carried[..., :n] + np.eye(n),
        carried[..., n] + outgrown,
        carried[..., n + 1] + unequal,
        inside,
        float(max(np.abs(beside).max(), np.abs(unequal).max())),
    )
