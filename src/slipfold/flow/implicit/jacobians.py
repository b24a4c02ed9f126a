"""Derivatives of the rates at all points of all intervals: of many states few columns change."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array

Places = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Jacobians:
    """Matrices that differ in some columns only, at the s points of m intervals."""

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
        found = np.empty((m, s, n, n))
        found[:] = self.common
        found[..., self.columns] = self.changing
        return found

    @cached_property
    def first(self) -> Array:
        """The first of them, shape (n, n)."""
        found = self.common.copy()
        found[:, self.columns] = self.changing[0, 0]
        return found

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
