"""Collocation on a batch of intervals: each solved from the state at its beginning."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.collocation_points import CollocationPoints
from slipfold.flow.compiled_code import Evaluated
from slipfold.flow.equations import Constants
from slipfold.flow.stage_equations import MANY, Inverted, Jacobians, LinearPart, StageEquations


@dataclass(frozen=True, eq=False)
class Field:
    """The right-hand side of a model with the values of its coefficients, in scaled states."""

    flow: Evaluated  # the model's compiled functions
    constants: Constants  # coefficients
    scales: Array  # scales of the states, shape (n,)
    indices: list[int]  # which parameters are free
    linear: LinearPart  # the shared part of its derivatives

    def rates(self, states: Array, phases: Array) -> Array:
        """Return the rates a unit of phase. Shapes: states (..., n); phases (...)."""
        rows = states.reshape(-1, states.shape[-1]) * self.scales
        result = self.flow.rates(rows, phases.ravel(), self.constants)
        return np.asarray((result / self.scales).reshape(states.shape))

    def jacobians(self, states: Array, phases: Array) -> Array:
        """Return the derivatives of the rates, shape (..., n, n).

        Shapes: states (..., n); phases (...).
        """
        n = states.shape[-1]
        rows = states.reshape(-1, n) * self.scales
        result = self.flow.jacobians(rows, phases.ravel(), self.constants)
        ratios = self.scales[None, :] / self.scales[:, None]
        return np.asarray((result * ratios).reshape(*states.shape, n))

    def changing_jacobians(self, states: Array, phases: Array) -> Jacobians:
        """Return the same at points of intervals; of many states only columns that change.

        Shapes: states (m, s, n); phases (m, s).
        """
        m, s, n = states.shape
        if n < MANY:
            return Jacobians.of(self.jacobians(states, phases))
        rows, ratios = states.reshape(-1, n) * self.scales, self.scales / self.scales[:, None]
        common, columns, result = self.flow.changing_jacobians(rows, phases.ravel(), self.constants)
        result *= ratios[:, columns]
        return Jacobians(common * ratios, columns, result.reshape(m, s, n, -1))

    def pulls(self, states: Array, phases: Array) -> Array:
        """Return the derivatives of the rates by the free parameters, shape (..., n, k).

        Shapes: states (..., n); phases (...).
        """
        rows = states.reshape(-1, states.shape[-1]) * self.scales
        along = self.constants.rates[:, self.indices]
        result = self.flow.pulls(rows, phases.ravel(), self.constants, along)
        return np.asarray((result / self.scales[:, None]).reshape(*states.shape, -1))

    def curvatures(self, states: Array, phases: Array, vectors: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``jacobians @ vectors``, (..., n, n) and (..., n, k).

        Shapes: states, vectors (..., n); phases (...).
        """
        n = states.shape[-1]
        rows = states.reshape(-1, n) * self.scales
        along = self.constants.rates[:, self.indices]
        second, mixed = self.flow.curvatures(
            rows, phases.ravel(), self.constants, vectors.reshape(-1, n) * self.scales, along
        )
        ratios = self.scales[None, :] / self.scales[:, None]
        return (
            np.asarray((second * ratios).reshape(*states.shape, n)),
            np.asarray((mixed / self.scales[:, None]).reshape(*states.shape, -1)),
        )

    def cubes(self, states: Array, phases: Array, vectors: Array) -> Array:
        """Return the third derivatives of the rates along vectors, shape (..., n).

        Shapes: states, vectors (..., n); phases (...).
        """
        n = states.shape[-1]
        rows, along = states.reshape(-1, n) * self.scales, vectors.reshape(-1, n) * self.scales
        third = self.flow.powers(rows, phases.ravel(), self.constants, along)[1]
        return np.asarray((third / self.scales).reshape(states.shape))


@dataclass(frozen=True, eq=False)
class Stages:
    r"""Polynomials that meet the equations at some points, and how they depend on the start.

    With stages Y and slopes F the equations in the Runge-Kutta basis are

    .. math:: Y_l = x + h \sum_k a_{lk} F(Y_k), \quad x_+ = x + h \sum_k b_k F(Y_k).

    If the last point is the end, the last stage is the end state, without the rounding errors of
    rates that fast modes magnify.
    """

    points: CollocationPoints  # where in each interval the equations are met
    nodes: Array  # states at the beginnings, shape (m, n)
    # Phases of the beginnings and lengths, shape (m,)
    start: Array
    lengths: Array
    # States and rates at the points, shape (m, s, n); NaN where there is no solution
    stages: Array
    rates: Array
    equations: StageEquations  # their derivatives by the stages
    # Derivatives of the rates at the points; None if not requested, with equations of a solution
    # nearby
    jacobians: Jacobians | None

    @property
    def is_derived(self) -> bool:
        """Whether derivatives are those at the solution."""
        return self.jacobians is not None

    @cached_property
    def phases(self) -> Array:
        """Phases of the stages, shape (m, s)."""
        return _phases(self.start, self.lengths, self.points)

    @cached_property
    def slopes(self) -> Array:
        """Slopes of the polynomials at the points, shape (m, s, n): the rates but for rounding."""
        if not self.points.damps:
            return self.rates
        grown = np.einsum("lk,jka->jla", self.points.outer, self.stages - self.nodes[:, None])
        return np.asarray(grown / self.lengths[:, None, None])

    @cached_property
    def ends(self) -> Array:
        """States at the ends, shape (m, n)."""
        if self.points.damps:
            return self.stages[:, -1]
        total = np.einsum("k,jkn->jn", self.points.weights, self.slopes)
        return self.nodes + self.lengths[:, None] * total

    @property
    def moved(self) -> Array:
        """Derivatives of the stages by the state at the beginning, shape (m, s, n, n)."""
        return self.equations.moved

    @cached_property
    def matrices(self) -> Array:
        """Derivatives of the ends by the beginnings, shape (m, n, n)."""
        if self.points.damps:
            return self.equations.last_moved
        return np.eye(self.nodes.shape[1]) + self._carried(self.moved)

    def _carried(self, changes: Array) -> Array:
        """Return the changes of the ends from changes of the stages.

        Shapes: changes (m, s, n, q); returns (m, n, q).
        """
        assert self.jacobians is not None
        weighted = self.jacobians.whole * self.points.weights[:, None, None]
        return np.asarray(
            self.lengths[:, None, None] * np.einsum("jkab,jkbq->jaq", weighted, changes)
        )

    def answered(self, pushes: Array) -> tuple[Array, Array]:
        """Return the changes of stages and ends from changes of the rates.

        Shapes: pushes (m, s, n, q); returns (m, s, n, q), (m, n, q).
        """
        points, lengths = self.points, self.lengths[:, None, None]
        inner = np.einsum("lk,jkaq->jlaq", points.inner, pushes)
        stages = self.equations.solve(lengths[..., None] * inner)
        if points.damps:
            return stages, stages[:, -1]
        outer = lengths * np.einsum("k,jkaq->jaq", points.weights, pushes)
        return stages, self._carried(stages) + outer

    def at(self, fractions: Array, which: NDArray[np.intp]) -> Array:
        """Evaluate the polynomials of some intervals, each at places of its own.

        Shapes: fractions (q, p); which (q,); returns (q, p, n).
        """
        weights = self.points.integrals(fractions.ravel()).reshape(*fractions.shape, -1)
        grown = np.einsum("qpk,qkn->qpn", weights, self.slopes[which])
        return np.asarray(self.nodes[which][:, None] + self.lengths[which][:, None, None] * grown)


def _phases(start: Array, lengths: Array, points: CollocationPoints) -> Array:
    return np.asarray(start[:, None] + lengths[:, None] * points.points)


def newton_step(
    field: Field,
    points: CollocationPoints,
    nodes: Array,
    start: Array,
    lengths: Array,
    stages: Array,
) -> Stages:
    """Return the solution of the equations linearized at some stages.

    A singular matrix raises an error. Shapes: nodes (m, n); start, lengths (m,); stages (m, s, n).
    """
    given = points, nodes, start, lengths
    rates, jacobians, equations, step = _step(field, *given, stages)
    return Stages(*given, stages + step, rates + jacobians.times(step), equations, jacobians)


def _step(
    field: Field,
    points: CollocationPoints,
    nodes: Array,
    start: Array,
    lengths: Array,
    stages: Array,
) -> tuple[Array, Jacobians, StageEquations, Array]:
    """Return rates, their derivatives, the equations' derivatives and Newton's step."""
    phases = _phases(start, lengths, points)
    rates, jacobians = field.rates(stages, phases), field.changing_jacobians(stages, phases)
    equations = field.linear.equations(points, lengths, jacobians)
    grown = lengths[:, None, None] * (points.inner @ rates)
    step = -equations.solve((stages - nodes[:, None] - grown)[..., None])[..., 0]
    return rates, jacobians, equations, step


@np.errstate(over="ignore", invalid="ignore")  # overflow gives NaN
def solve_intervals(
    field: Field,
    points: CollocationPoints,
    nodes: Array,
    start: Array,
    lengths: Array,
    guess: Array,
    equations: StageEquations | None = None,
    *,
    derived: bool = True,
) -> Stages:
    """Solve the equations of intervals, with derivatives taken at the solution.

    Derivatives nearby are used while they converge. If they do to the end, derivatives at the
    solution are computed only if requested.

    Shapes: nodes (m, n); start, lengths (m,); guess (m, s, n).
    """
    phases, inner = _phases(start, lengths, points), points.inner
    steps, (m, s, n) = lengths[:, None, None], guess.shape
    stages = guess

    def beside(slopes: Array) -> Array:
        grown = steps * (inner @ slopes)
        return np.asarray((stages - nodes[:, None] - grown)[..., None])

    if equations is not None:
        before = np.inf
        for _ in range(8):  # with the same derivatives
            slopes = field.rates(stages, phases)
            step = -equations.solve(beside(slopes))[..., 0]
            length = float(np.abs(step).max())
            if not length < 0.3 * before:  # slow
                break
            stages, before = stages + step, length
            if length < 1e-13 * max(1.0, float(np.abs(stages).max())):
                if not derived:
                    return Stages(points, nodes, start, lengths, stages, slopes, equations, None)
                break
    alone, previous = equations is None and not derived, np.inf
    given = points, nodes, start, lengths
    for _ in range(10):
        try:
            slopes, jacobians, equations, step = _step(field, *given, stages)
        except np.linalg.LinAlgError:
            break
        length = float(np.abs(step).max())
        if not length < 1e6:  # leads nowhere
            break
        stages = stages + step
        size_of_states = max(1.0, float(np.abs(stages).max()))
        # What it leaves is rounding.
        if length < 1e-10 * size_of_states or 1e-7 > length > 0.5 * previous:
            return Stages(*given, stages, slopes + jacobians.times(step), equations, jacobians)
        if alone and length < 1e-3:  # derivatives do for the next steps
            return solve_intervals(field, *given, stages, equations, derived=False)
        previous = length
    lost = np.full((m, s, n), np.nan)
    none = Inverted(np.broadcast_to(np.nan, (m, s * n, s * n)), s)
    unknown = Jacobians.of(np.broadcast_to(np.nan, (m, s, n, n)))
    return Stages(points, nodes, start, lengths, lost, lost, none, unknown)
