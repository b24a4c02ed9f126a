"""Collocation on a batch of intervals: each solved from the state at its beginning."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Complex, Indices
from slipfold.collocation_points import CollocationPoints
from slipfold.flow.compiled_code import Evaluated
from slipfold.flow.equations import Constants


@dataclass(frozen=True, eq=False)
class Jacobians:
    """Matrices at the s points of m intervals that differ in some columns only."""

    common: Array  # one of them, shape (n, n)
    columns: Indices  # those that may change, in their order, shape (c,)
    changing: Array  # what stands there, shape (m, s, n, c)

    @staticmethod
    def of(whole: Array) -> Jacobians:
        """Return matrices of which all columns may change. Shapes: whole (m, s, n, n)."""
        return Jacobians(whole[0, 0], np.arange(whole.shape[-1]), whole)

    @cached_property
    def whole(self) -> Array:
        """All of them, shape (m, s, n, n)."""
        m, s, n, c = self.changing.shape
        if c == n:
            return self.changing
        result = np.empty((m, s, n, n))
        result[:] = self.common
        result[..., self.columns] = self.changing
        return result

    @cached_property
    def first(self) -> Array:
        """The first of them, shape (n, n)."""
        result = self.common.copy()
        result[:, self.columns] = self.changing[0, 0]
        return result

    @property
    def changed(self) -> Indices:
        """Columns that are not the same everywhere."""
        differ = (self.changing != self.changing[0, 0]).any(axis=(0, 1, 2))
        return self.columns[differ]

    @property
    def is_finite(self) -> bool:
        """Whether there are numbers everywhere."""
        return bool(np.isfinite(self.changing).all() and np.isfinite(self.first).all())

    def at(self, columns: Indices) -> Array:
        """Return some of those columns that may change, shape (m, s, n, ...)."""
        return np.asarray(self.changing[..., np.searchsorted(self.columns, columns)])

    def times(self, vectors: Array) -> Array:
        """Return each of them times a vector of its own. Shapes: vectors (m, s, n)."""
        rest = self.first.copy()
        rest[:, self.columns] = 0.0
        own = np.einsum("jkab,jkb->jka", self.changing, vectors[..., self.columns])
        return np.asarray(vectors @ rest.T + own)


MANY = 12
"""Number of states above which the linear part of the equations is separated."""


class StageEquations(ABC):
    r"""The system :math:`Z_l - h \sum_k a_{lk} J_k Z_k = R_l` of each of m intervals."""

    @abstractmethod
    def solve(self, right: Array) -> Array:
        """Return the solutions. Shapes: right and solutions (m, s, n, q)."""

    @property
    @abstractmethod
    def moved(self) -> Array:
        """Derivatives of the stages by the state at the beginning, shape (m, s, n, n)."""

    @property
    @abstractmethod
    def last_moved(self) -> Array:
        """Those of the last stages, shape (m, n, n)."""

    @abstractmethod
    def along(self, changes: Array) -> Array:
        """Return how stages follow changes at the beginnings. Shapes: (m, n) to (m, s, n)."""


class Inverted(StageEquations):
    """The inverses of the whole systems, shape (m, s n, s n)."""

    def __init__(self, inverses: Array, stages: int) -> None:
        self._inverses, self._stages = inverses, stages

    @staticmethod
    def of(points: CollocationPoints, lengths: Array, jacobians: Array) -> Inverted:
        """Invert; a singular matrix raises an error."""
        m, s, n, _ = jacobians.shape
        steps = lengths[:, None, None, None]
        matrix = np.einsum("lk,jkab->jlakb", -points.inner, jacobians * steps)
        matrix = matrix.reshape(m, s * n, s * n)
        matrix[:, np.arange(s * n), np.arange(s * n)] += 1.0
        return Inverted(np.linalg.inv(matrix), s)

    def solve(self, right: Array) -> Array:
        """Return the solutions."""
        m, s, n, q = right.shape
        return np.asarray((self._inverses @ right.reshape(m, s * n, q)).reshape(m, s, n, q))

    @cached_property
    def moved(self) -> Array:
        """Derivatives of the stages by the state at the beginning, shape (m, s, n, n)."""
        (m, size, _), s = self._inverses.shape, self._stages
        ones = np.tile(np.eye(size // s), (s, 1))  # takes a seventh of the time of a sum
        return np.asarray((self._inverses @ ones).reshape(m, s, -1, ones.shape[1]))

    @property
    def last_moved(self) -> Array:
        """Those of the last stages, shape (m, n, n)."""
        return self.moved[:, -1]

    def along(self, changes: Array) -> Array:
        """Return how stages follow changes at the beginnings."""
        return np.asarray(np.einsum("jkab,jb->jka", self.moved, changes))


@dataclass(frozen=True, eq=False)
class _Modes:
    """A matrix by its eigenvectors; one of each conjugate pair, doubled, stands for both."""

    matrix: Array  # shape (n, n)
    columns: Indices  # those in which Jacobians differ from its multiples, shape (c,)
    values: Complex  # eigenvalues, shape (p,)
    left: Complex  # what there is of each in a state, shape (p, n)
    right: Complex  # what each does to the state, shape (n, p)

    @staticmethod
    def of(matrix: Array, columns: Indices) -> _Modes | None:
        """Return them, None where eigenvectors nearly coincide."""
        values, right = np.linalg.eig(matrix)
        try:
            left = np.linalg.inv(right)
        except np.linalg.LinAlgError:
            return None
        lost = np.abs((right * values) @ left - matrix).max() / np.abs(matrix).max()
        # Else eigenvectors nearly coincide.
        if not max(lost, np.abs(left @ right - np.eye(len(values))).max()) < 1e-9:
            return None
        kept = values.imag >= 0
        doubled = np.where(values.imag > 0, 2.0, 1.0)
        return _Modes(
            matrix, columns, values[kept] + 0j, left[kept] + 0j, (right * doubled)[:, kept] + 0j
        )

    def factor_of(self, jacobian: Array) -> float | None:
        """Return the factor of the matrix that equals a Jacobian except in the columns, or None."""
        kept = np.delete(self.matrix, self.columns, axis=1)
        given = np.delete(jacobian, self.columns, axis=1)
        factor = float((given * kept).sum() / (kept * kept).sum())
        off = np.abs(given - factor * kept)
        return factor if bool((off <= 1e-12 * np.abs(factor * kept)).all()) else None  # rounding


class LinearPart:
    """The part that all Jacobians of a model share, up to a factor and some columns.

    In a structure only the columns of displacements and speeds at contacts and nonlinear springs
    vary; the factor is the period. The shared part is decomposed once, so that rounding errors of
    fast modes are the same in all derivatives along a branch and do not enter slow modes.
    """

    def __init__(self) -> None:
        self._modes: _Modes | None = None

    def equations(
        self, points: CollocationPoints, lengths: Array, jacobians: Jacobians
    ) -> StageEquations:
        """Return the systems of intervals; a singular matrix raises an error.

        Shapes: lengths (m,).
        """
        n = len(jacobians.common)
        if n < MANY or not jacobians.is_finite:
            return Inverted.of(points, lengths, jacobians.whole)
        changes, known = jacobians.changed, self._modes
        factor = None if known is None else known.factor_of(jacobians.first)
        if known is None or factor is None or not np.isin(changes, known.columns).all():
            if known is not None:
                changes = np.union1d(changes, known.columns)
            if len(changes) > 0.25 * n:  # otherwise a full inverse is faster
                return Inverted.of(points, lengths, jacobians.whole)
            known, factor = _Modes.of(jacobians.first, changes), 1.0
            if known is None:
                return Inverted.of(points, lengths, jacobians.whole)
            self._modes = known
        return _Separated(points, lengths, jacobians, known, factor)


def _times(matrices: NDArray[Any], columns: NDArray[Any]) -> Complex:
    """Return products of many small matrices; a sum is faster for single columns."""
    if columns.shape[-1] > 1:
        return np.asarray(matrices @ columns)
    return np.asarray((matrices * columns[..., 0][..., None, :]).sum(axis=-1)[..., None])


class _Separated(StageEquations):
    r"""Modes of the linear part, each individually, coupled by what a few columns add.

    With :math:`J_k = V \Lambda U + N_k E^T` the modes :math:`\zeta = U Z` and what the columns see,
    :math:`y_k = E^T Z_k`, are

    .. math:: \zeta_l = W_{lk} U R_k + h W_{lk} a_{ki} U N_i y_i, \quad
              W = (I - h \lambda A)^{-1},

    so that a system of the size of the columns at all stages gives y. The operations grow with n^2,
    and fast modes do not mix with slow ones.
    """

    def __init__(
        self,
        points: CollocationPoints,
        lengths: Array,
        jacobians: Jacobians,
        modes: _Modes,
        factor: float,
    ) -> None:
        self._modes, columns = modes, modes.columns
        inner, s = points.inner, len(points.points)
        turned = (factor * lengths)[:, None] * modes.values
        # W and h W A, shape (m, p, s, s)
        self._answers = np.linalg.inv(np.eye(s) - turned[..., None, None] * inner)
        self._driven = lengths[:, None, None, None] * (self._answers @ inner)
        added = jacobians.at(columns) - factor * modes.matrix[:, columns]
        self._pushes = modes.left @ added  # U N, shape (m, s, p, c)
        self._seen = modes.right[columns]  # E^T V, shape (c, p)
        m, c = len(lengths), len(columns)
        # What the modes at the stages do with y, shape (m, p, s, s c)
        self._forced = np.einsum("jplk,jkpc->jplkc", self._driven, self._pushes)
        self._forced = self._forced.reshape(m, len(modes.values), s, s * c)
        coupled = np.eye(s * c) - self._watched(self._forced)
        self._coupled = np.linalg.inv(coupled)

    def _watched(self, modes: Complex) -> Array:
        """Return what columns see of the modes at all stages, (m, p, s, q) to (m, s c, q)."""
        m, _, s, q = modes.shape
        seen = np.tensordot(self._seen, modes, axes=(1, 1)).real  # (c, m, s, q)
        return np.moveaxis(seen, 0, 2).reshape(m, s * len(self._seen), q)

    def solve(self, right: Array) -> Array:
        """Return the solutions."""
        parts = np.tensordot(self._modes.left, right, axes=(1, 2))  # (p, m, s, q)
        modes = _times(self._answers, np.swapaxes(parts, 0, 1))
        seen = self._coupled @ self._watched(modes)
        modes += _times(self._forced, seen[:, None])
        result = np.tensordot(modes, self._modes.right, axes=(1, 1)).real  # (m, s, q, n)
        return np.asarray(np.swapaxes(result, 2, 3))

    def along(self, changes: Array) -> Array:
        """Return how stages follow changes at the beginnings."""
        s = self._answers.shape[-1]
        return self.solve(np.repeat(changes[:, None, :, None], s, axis=1))[..., 0]

    @cached_property
    def _initial(self) -> Complex:
        """What stages have of a mode that is there at the beginning, shape (m, p, s)."""
        return np.asarray(self._answers.sum(axis=3))

    @cached_property
    def _seen_moved(self) -> Array:
        """What columns see of changes at the beginnings, shape (m, s c, n)."""
        alone = np.einsum("cp,jps->jscp", self._seen, self._initial)
        m, s, c, p = alone.shape
        return np.asarray(self._coupled @ (alone.reshape(m, s * c, p) @ self._modes.left).real)

    def _moved_at(self, stage: int) -> Array:
        modes = self._initial[:, :, stage, None] * self._modes.left
        modes += self._forced[:, :, stage] @ self._seen_moved
        return np.asarray((self._modes.right @ modes).real)

    @cached_property
    def moved(self) -> Array:
        """Derivatives of the stages by the state at the beginning, shape (m, s, n, n)."""
        stages = range(self._answers.shape[-1])
        return np.stack([self._moved_at(stage) for stage in stages], axis=1)

    @cached_property
    def last_moved(self) -> Array:
        """Those of the last stages, shape (m, n, n)."""
        return self._moved_at(-1)


@dataclass(frozen=True, eq=False)
class Field:
    """The right-hand side of a model with the values of its coefficients, in scaled states."""

    flow: Evaluated  # the model's compiled functions
    constants: Constants  # coefficients
    # Scales of the states, shape (n,); of trajectories with constants of their own (m, n), as many
    # rows as there are states
    scales: Array
    indices: list[int]  # which parameters are free
    linear: LinearPart  # the shared part of its derivatives

    def _at(self, states: Array, phases: Array) -> tuple[Array, Array, Constants]:
        """Return states in their own units, phases and coefficients: where to evaluate."""
        return states.reshape(-1, states.shape[-1]) * self.scales, phases.ravel(), self.constants

    @property
    def _ratios(self) -> Array:
        return np.asarray(self.scales[..., None, :] / self.scales[..., :, None])

    @property
    def _along(self) -> Array:
        """Changes of the coefficients with the free parameters."""
        return self.constants.rates[:, self.indices]

    def rates(self, states: Array, phases: Array) -> Array:
        """Return the rates a unit of phase. Shapes: states (..., n); phases (...)."""
        result = self.flow.rates(*self._at(states, phases))
        return np.asarray((result / self.scales).reshape(states.shape))

    def jacobians(self, states: Array, phases: Array) -> Array:
        """Return the derivatives of the rates, shape (..., n, n).

        Shapes: states (..., n); phases (...).
        """
        result = self.flow.jacobians(*self._at(states, phases)) * self._ratios
        return np.asarray(result.reshape(*states.shape, states.shape[-1]))

    def changing_jacobians(self, states: Array, phases: Array) -> Jacobians:
        """Return the same at points of intervals; of many states only columns that change.

        Shapes: states (m, s, n); phases (m, s).
        """
        if states.shape[-1] < MANY:
            return Jacobians.of(self.jacobians(states, phases))
        ratios = self._ratios
        common, columns, result = self.flow.changing_jacobians(*self._at(states, phases))
        result *= ratios[:, columns]
        return Jacobians(common * ratios, columns, result.reshape(*states.shape, -1))

    def parameter_slopes(self, states: Array, phases: Array) -> Array:
        """Return the derivatives of the rates by the free parameters, shape (..., n, k).

        Shapes: states (..., n); phases (...).
        """
        result = self.flow.parameter_slopes(*self._at(states, phases), self._along)
        return np.asarray((result / self.scales[:, None]).reshape(*states.shape, -1))

    def curvatures(self, states: Array, phases: Array, vectors: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``jacobians @ vectors``, (..., n, n) and (..., n, k).

        Shapes: states, vectors (..., n); phases (...).
        """
        own = vectors.reshape(-1, vectors.shape[-1]) * self.scales
        second, mixed = self.flow.curvatures(*self._at(states, phases), own, self._along)
        return (
            np.asarray((second * self._ratios).reshape(*states.shape, states.shape[-1])),
            np.asarray((mixed / self.scales[:, None]).reshape(*states.shape, -1)),
        )

    def cubes(self, states: Array, phases: Array, vectors: Array) -> Array:
        """Return the third derivatives of the rates along vectors, shape (..., n).

        Shapes: states, vectors (..., n); phases (...).
        """
        own = vectors.reshape(-1, vectors.shape[-1]) * self.scales
        third = self.flow.powers(*self._at(states, phases), own)[1]
        return np.asarray((third / self.scales).reshape(states.shape))


@dataclass(frozen=True, eq=False)
class Intervals:
    """Intervals from states at their beginnings on."""

    points: CollocationPoints  # where in each interval the equations are met
    nodes: Array  # states at the beginnings, shape (m, n)
    # Phases of the beginnings and lengths, shape (m,)
    start: Array
    lengths: Array

    @cached_property
    def phases(self) -> Array:
        """Phases of the points, shape (m, s)."""
        return np.asarray(self.start[:, None] + self.lengths[:, None] * self.points.points)

    def with_stages(self, *found: Any) -> Stages:
        """Return the polynomials through stages, from the other fields of these."""
        return Stages(self.points, self.nodes, self.start, self.lengths, *found)


@dataclass(frozen=True, eq=False)
class Stages(Intervals):
    r"""Polynomials that meet the equations at some points, and how they depend on the start.

    With stages Y and slopes F the equations in the Runge-Kutta basis are

    .. math:: Y_l = x + h \sum_k a_{lk} F(Y_k), \quad x_+ = x + h \sum_k b_k F(Y_k).

    If the last point is the end, the last stage is the end state, without the rounding errors of
    rates that fast modes magnify.
    """

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

    @cached_property
    def matrices(self) -> Array:
        """Derivatives of the ends by the beginnings, shape (m, n, n)."""
        if self.points.damps:
            return self.equations.last_moved
        return np.eye(self.nodes.shape[1]) + self._propagated(self.equations.moved)

    def _propagated(self, changes: Array) -> Array:
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
        return stages, self._propagated(stages) + outer

    @property
    def last_term(self) -> float:
        """Largest last Legendre coefficient of the polynomials: it bounds what is left out."""
        grown = self.points.transform[-1] @ self.slopes * self.lengths[:, None]
        return float(np.abs(grown).max()) / (2 * (2 * len(self.points.points) - 1))

    def at(self, fractions: Array, which: Indices) -> Array:
        """Evaluate the polynomials of some intervals, each at places of its own.

        Shapes: fractions (q, p); which (q,); returns (q, p, n).
        """
        weights = self.points.integrals(fractions.ravel()).reshape(*fractions.shape, -1)
        grown = np.einsum("qpk,qkn->qpn", weights, self.slopes[which])
        return np.asarray(self.nodes[which][:, None] + self.lengths[which][:, None, None] * grown)


def newton_step(field: Field, given: Intervals, stages: Array) -> Stages:
    """Return the solution of the equations linearized at some stages.

    A singular matrix raises an error. Shapes: stages (m, s, n).
    """
    rates, jacobians, equations, step = _step(field, given, stages)
    return given.with_stages(stages + step, rates + jacobians.times(step), equations, jacobians)


def _step(
    field: Field, given: Intervals, stages: Array
) -> tuple[Array, Jacobians, StageEquations, Array]:
    """Return rates, their derivatives, the equations' derivatives and Newton's step."""
    points, lengths = given.points, given.lengths
    rates = field.rates(stages, given.phases)
    jacobians = field.changing_jacobians(stages, given.phases)
    equations = field.linear.equations(points, lengths, jacobians)
    grown = lengths[:, None, None] * (points.inner @ rates)
    step = -equations.solve((stages - given.nodes[:, None] - grown)[..., None])[..., 0]
    return rates, jacobians, equations, step


@np.errstate(over="ignore", invalid="ignore")  # overflow gives NaN
def solve_intervals(
    field: Field,
    given: Intervals,
    guess: Array,
    equations: StageEquations | None = None,
    *,
    derived: bool = True,
) -> Stages:
    """Solve the equations of intervals, with derivatives taken at the solution.

    Derivatives nearby are used while they converge. If they do to the end, derivatives at the
    solution are computed only if requested.

    Shapes: guess (m, s, n).
    """
    steps, (m, s, n) = given.lengths[:, None, None], guess.shape
    stages = guess

    def beside(slopes: Array) -> Array:
        grown = steps * (given.points.inner @ slopes)
        return np.asarray((stages - given.nodes[:, None] - grown)[..., None])

    if equations is not None:
        before = np.inf
        for _ in range(8):  # with the same derivatives
            slopes = field.rates(stages, given.phases)
            step = -equations.solve(beside(slopes))[..., 0]
            length = float(np.abs(step).max())
            if not length < 0.3 * before:  # slow
                break
            stages, before = stages + step, length
            if length < 1e-13 * max(1.0, float(np.abs(stages).max())):
                if not derived:
                    return given.with_stages(stages, slopes, equations, None)
                break
    alone, previous = equations is None and not derived, np.inf
    for _ in range(10):
        try:
            slopes, jacobians, equations, step = _step(field, given, stages)
        except np.linalg.LinAlgError:
            break
        length = float(np.abs(step).max())
        if not length < 1e6:  # leads nowhere
            break
        stages = stages + step
        size_of_states = max(1.0, float(np.abs(stages).max()))
        # What it leaves is rounding.
        if length < 1e-10 * size_of_states or 1e-7 > length > 0.5 * previous:
            return given.with_stages(stages, slopes + jacobians.times(step), equations, jacobians)
        if alone and length < 1e-3:  # derivatives do for the next steps
            return solve_intervals(field, given, stages, equations, derived=False)
        previous = length
    lost = np.full((m, s, n), np.nan)
    none = Inverted(np.broadcast_to(np.nan, (m, s * n, s * n)), s)
    unknown = Jacobians.of(np.broadcast_to(np.nan, (m, s, n, n)))
    return given.with_stages(lost, lost, none, unknown)
