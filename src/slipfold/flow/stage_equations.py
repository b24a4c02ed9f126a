"""The linear system of collocation's stages, batched over intervals."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Complex
from slipfold.collocation_points import CollocationPoints

Places = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Jacobians:
    """Matrices at the s points of m intervals that differ in some columns only."""

    common: Array  # one of them, shape (n, n)
    columns: Places  # those that may change, in their order, shape (c,)
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
    def changed(self) -> Places:
        """Columns that are not the same everywhere."""
        differ = (self.changing != self.changing[0, 0]).any(axis=(0, 1, 2))
        return self.columns[differ]

    @property
    def is_finite(self) -> bool:
        """Whether there are numbers everywhere."""
        return bool(np.isfinite(self.changing).all() and np.isfinite(self.first).all())

    def at(self, columns: Places) -> Array:
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
        m, size, _ = self._inverses.shape
        s, n = self._stages, size // self._stages
        return np.asarray(self._inverses.reshape(m, size, s, n).sum(axis=2).reshape(m, s, n, n))

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
    columns: NDArray[np.intp]  # those in which Jacobians differ from its multiples, shape (c,)
    values: Complex  # eigenvalues, shape (p,)
    left: Complex  # what there is of each in a state, shape (p, n)
    right: Complex  # what each does to the state, shape (n, p)

    @staticmethod
    def of(matrix: Array, columns: NDArray[np.intp]) -> _Modes | None:
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

    def pace(self, jacobian: Array) -> float | None:
        """Return the factor of the matrix that equals a Jacobian except in the columns, or None."""
        kept = np.delete(self.matrix, self.columns, axis=1)
        given = np.delete(jacobian, self.columns, axis=1)
        pace = float((given * kept).sum() / (kept * kept).sum())
        same = bool((np.abs(given - pace * kept) <= 1e-12 * np.abs(pace * kept)).all())  # rounding
        return pace if same else None


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
        pace = None if known is None else known.pace(jacobians.first)
        if known is None or pace is None or not np.isin(changes, known.columns).all():
            if known is not None:
                changes = np.union1d(changes, known.columns)
            if len(changes) > 0.25 * n:  # otherwise a full inverse is faster
                return Inverted.of(points, lengths, jacobians.whole)
            known, pace = _Modes.of(jacobians.first, changes), 1.0
            if known is None:
                return Inverted.of(points, lengths, jacobians.whole)
            self._modes = known
        return _Separated(points, lengths, jacobians, known, pace)


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
        pace: float,
    ) -> None:
        self._modes, columns = modes, modes.columns
        inner, s = points.inner, len(points.points)
        turned = (pace * lengths)[:, None] * modes.values
        # W and h W A, shape (m, p, s, s)
        self._answers = np.linalg.inv(np.eye(s) - turned[..., None, None] * inner)
        self._driven = lengths[:, None, None, None] * (self._answers @ inner)
        added = jacobians.at(columns) - pace * modes.matrix[:, columns]
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
    def _begun(self) -> Complex:
        """What stages have of a mode that is there at the beginning, shape (m, p, s)."""
        return np.asarray(self._answers.sum(axis=3))

    @cached_property
    def _seen_moved(self) -> Array:
        """What columns see of changes at the beginnings, shape (m, s c, n)."""
        alone = np.einsum("cp,jps->jscp", self._seen, self._begun)
        m, s, c, p = alone.shape
        return np.asarray(self._coupled @ (alone.reshape(m, s * c, p) @ self._modes.left).real)

    def _moved_at(self, stage: int) -> Array:
        modes = self._begun[:, :, stage, None] * self._modes.left
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
