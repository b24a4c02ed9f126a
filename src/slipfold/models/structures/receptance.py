"""Receptances of a structure: displacements for a unit force, from its matrices or its modes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.models.structures.matrices import MATRICES, lowest_modes, solver


class RECEPTANCE:
    """Where receptances are compared."""

    # Loss factor of the stiffness, that of 1 % of modal damping: an undamped resonance is infinite,
    # and the damping of a model is a parameter, on which the coordinates must not depend
    loss: float = 0.02
    # Most natural frequencies, and most between them, at which they are compared: each takes a
    # factorization of the matrices
    peaks: int = 6
    # Frequencies between which errors are interpolated: a resonance of the least damping compared
    # is as wide as 2 % of its frequency
    between: int = 200
    # Part of a static displacement below which what the kept modes leave of it is rounding
    residual: float = 1e-10
    # Mass that is added to the stiffness against rigid-body motion, in the lowest squared frequency
    # above it: the matrix is as regular as that of a structure that is held
    shift: float = 1e-2
    corrections: int = 8  # of static displacements for it: each leaves a hundredth of the error


Solve = Callable[[Any], Any]
"""What solves linear equations. Shapes: (n, a) to (n, a)."""


class LowestModes:
    """The lowest modes of two matrices, computed as far as they are needed."""

    def __init__(self, stiffness: Any, mass: Any) -> None:
        self._stiffness, self._mass = stiffness, mass
        self.size = int(mass.shape[0])  # degrees of freedom n
        self.most = int(np.count_nonzero(abs(mass).sum(axis=1)))  # those with mass: modes
        self._squares, self._shapes = np.empty(0), np.empty((self.size, 0))

    def first(self, count: int) -> tuple[Array, Array]:
        """Return as many modes. Shapes: (count,), (n, count)."""
        if count > len(self._squares):
            dense = isinstance(self._mass, np.ndarray)
            # Few modes cost as much as twice as many, and the next are often needed.
            several = self.most if dense else min(max(2 * len(self._squares), count), self.most)
            self._squares, self._shapes = self._compute(several)
        return self._squares[:count], self._shapes[:, :count]

    def _compute(self, count: int) -> tuple[Array, Array]:
        return lowest_modes(self._stiffness, self._mass, count)

    @property
    def free(self) -> int:
        """Number of rigid-body modes."""
        rounding = self.rounding  # computes some modes
        return int(np.searchsorted(self._squares, rounding, side="right"))

    @cached_property
    def rounding(self) -> float:
        """Size of rounding errors of squared circular frequencies of rigid-body modes."""
        squares, shapes = self.first(min(self.most, 8))
        masses = np.sum(shapes.conj() * (self._mass @ shapes), axis=0).real
        sums = np.sum(np.abs(shapes) * (abs(self._stiffness) @ np.abs(shapes)), axis=0) / masses
        # Full matrices have the rounding errors of their fastest mode; all modes are known then.
        largest = max(sums.max(), 4.0 * self._squares[-1])
        return float(max(np.finfo(float).eps * largest, MATRICES.free**2 * squares[-1]))

    def count_up_to(self, frequency: float) -> int:
        """Return the number of modes up to a frequency in Hz."""
        highest = (2 * math.pi * frequency) ** 2
        count = min(16, self.most)
        while count < self.most and self.first(count)[0][-1] <= highest:
            count = min(2 * count, self.most)
        return int(np.searchsorted(self.first(count)[0], highest, side="right"))


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Modal coordinates of a structure, in which its mass and its stiffness are diagonal."""

    squares: Array  # squared circular frequencies, shape (r,)
    shapes: Array  # displacements of all n degrees of freedom by coordinate, shape (n, r)
    masses: Array  # modal masses in kg, shape (r,)

    def receptance(self, directions: Array, frequencies: Array) -> Complex:
        """Return displacements for unit forces. Shapes: (n, s), (f,); returns (f, s, s)."""
        rows = directions.T @ self.shapes
        turned = (2 * math.pi * frequencies[:, None]) ** 2
        answers = 1 / (self.masses * (self.squares * (1 + 1j * RECEPTANCE.loss) - turned))
        return np.asarray(np.einsum("ai,fi,bi->fab", rows, answers, rows, optimize=True))


class FullStructure:
    """A structure with all its degrees of freedom: what reductions approximate.

    The weights of the degrees of freedom in each direction of a force are `acting`, those of
    displacements that are outputs `watched`. Shapes: mass, stiffness (n, n), full or sparse;
    acting (n, a); watched (n, w).
    """

    def __init__(self, mass: Any, stiffness: Any, acting: Array, watched: Array) -> None:
        self.mass, self.stiffness = mass, stiffness
        self.acting, self.directions = acting, _apart(np.hstack([acting, watched]))
        self.modes = LowestModes(stiffness, mass)
        self._receptances: dict[float, Complex] = {}

    def coordinates(self, shapes: Array) -> Coordinates:
        """Return the modal coordinates of the motions that some shapes span. Shapes: (n, r)."""
        pair = (self.mass, self.stiffness)
        mass, stiffness = (shapes.T @ np.asarray(part @ shapes) for part in pair)
        squares, mixed = lowest_modes((stiffness + stiffness.T) / 2, (mass + mass.T) / 2)
        return self.diagonal(squares, shapes @ mixed)

    def diagonal(self, squares: Array, shapes: Array) -> Coordinates:
        """Return modal coordinates in m: the largest displacement of each shape is one.

        Rigid-body modes have no stiffness: rounding errors of it would let them drift apart.
        """
        squares = np.where(np.abs(squares) <= self.modes.rounding, 0.0, squares)
        largest = np.abs(shapes).argmax(axis=0)
        shapes = shapes / shapes[largest, np.arange(shapes.shape[1])]
        return Coordinates(squares, shapes, np.sum(shapes * (self.mass @ shapes), axis=0))

    def _lowest(self) -> tuple[Array, Array, int]:
        """Return some modes, and the position of the lowest that is no rigid-body motion."""
        squares, shapes = self.modes.first(min(self.modes.most, 8))
        return squares, shapes, min(self.modes.free, len(squares) - 1)

    @property
    def rounding(self) -> float:
        """Relative change of the lowest natural frequency by the rounding of K's entries."""
        squares, shapes, first = self._lowest()
        shape = shapes[:, first]
        if squares[first] <= 0:
            return 0.0
        work = np.abs(shape) @ (abs(self.stiffness) @ np.abs(shape))
        return float(
            np.finfo(float).eps / 4 * work / (shape @ (self.mass @ shape) * squares[first])
        )

    @cached_property
    def _static(self) -> Solve:
        """What returns static displacements for forces that move no rigid body."""
        squares, _, first = self._lowest()
        added = RECEPTANCE.shift * squares[first] if first else 0.0
        return self._solver(
            added,
            "K is singular to rounding, so static displacements cannot be computed; keep modes "
            "alone with ModalReduction",
        )

    def _solver(self, added: float, what: str) -> Solve:
        """Return what solves equations with the stiffness and a part of the mass."""
        return solver(self.stiffness + added * self.mass, what)

    def residual_shapes(self, count: int) -> Array:
        r"""Return what the modes from `count` on add to the static displacement for each force.

        .. math::

            R = K^{-1} B - \sum_{i \le count} \phi_i \phi_i^T B / (\omega_i^2 m_i)

        With rigid-body modes a small part of the mass is added to the stiffness. Forces without
        the part that the lowest modes take have no such motion, so it changes nothing else.

        Shapes: returns (n, d), d at most the number of directions.
        """
        size = self.modes.size
        if count >= self.modes.most or not self.acting.shape[1]:
            return np.empty((size, 0))
        shapes = self.modes.first(count)[1]
        moved = self.mass @ shapes
        moved = moved / np.sum(shapes * moved, axis=0)
        rest = self.acting - moved @ (shapes.T @ self.acting)
        answers = self._static(rest)
        for _ in range(RECEPTANCE.corrections if self.modes.free else 1):
            answers += self._static(rest - self.stiffness @ answers)  # without what was added
        answers -= shapes @ (moved.T @ answers)
        # Forces along one line have one shape; those that the modes take whole have none.
        work = answers.T @ rest
        whole = np.sqrt(np.abs(np.sum(self.acting * self._static(self.acting), axis=0)))
        values, mixed = np.linalg.eigh((work + work.T) / 2 / np.outer(whole, whole))
        kept = values > RECEPTANCE.residual
        return answers @ (mixed[:, kept] / whole[:, None])

    def samples(self, band: float) -> tuple[Array, Array]:
        """Return some natural frequencies in Hz up to `band`, and frequencies between them."""
        squares = self.modes.first(self.modes.count_up_to(band))[0]
        peaks = np.sqrt(squares[self.modes.free :]) / (2 * math.pi)
        between = (np.append(0.0, peaks) + np.append(peaks, band)) / 2
        return _thinned(peaks), np.union1d(_thinned(between), [band])

    def error(self, reduced: Coordinates, band: float) -> float:
        """Return the largest error of a receptance of modal coordinates up to a frequency in Hz.

        It is relative to the receptance, or to its geometric mean over the band where that is
        larger: near antiresonances. Away from resonances, errors are interpolated. Zero without
        directions.
        """
        if not self.directions.shape[1]:
            return 0.0
        even = np.linspace(0, band, RECEPTANCE.between + 1)[1:]
        own = np.abs(reduced.receptance(self.directions, even))
        mean = np.exp(np.mean(np.log(np.einsum("faa->fa", own)), axis=0))
        typical = np.sqrt(np.outer(mean, mean))
        peaks, between = (
            (part, np.abs(reduced.receptance(self.directions, part) - self._exact(part)))
            for part in self.samples(band)
        )
        errors = [difference / np.maximum(np.abs(self._exact(at)), typical)
                  for at, difference in (peaks, between)]  # fmt: skip
        for a, b in np.ndindex(typical.shape):
            likely = np.interp(even, between[0], between[1][:, a, b])
            errors.append(likely / np.maximum(own[:, a, b], typical[a, b]))
        return max(float(part.max(initial=0.0)) for part in errors)

    def _displacements(self, turned: float, loss: float) -> Complex:
        """Return displacements at a squared circular frequency for unit forces, shape (n, s)."""
        return solved(self.stiffness * (1 + 1j * loss) - turned * self.mass, self.directions)

    def _exact(self, frequencies: Array) -> Complex:
        """Return receptances by solutions with the whole matrices, shape (f, s, s)."""
        for frequency in frequencies:
            if frequency not in self._receptances:
                turned = (2 * math.pi * frequency) ** 2
                answer = self.directions.T @ self._displacements(turned, RECEPTANCE.loss)
                self._receptances[frequency] = answer
        size = self.directions.shape[1]
        return np.array([self._receptances[one] for one in frequencies]).reshape(-1, size, size)


def solved(matrix: Any, right: Array) -> Complex:
    """Solve linear equations once. Shapes: matrix (n, n), right (n, a)."""
    if isinstance(matrix, np.ndarray):
        return np.linalg.solve(matrix, right.astype(complex))
    from scipy.sparse.linalg import splu

    return np.asarray(splu(matrix.tocsc()).solve(right.astype(complex)))


def _apart(directions: Array) -> Array:
    """Return the directions that differ, each once. Shapes: (n, s)."""
    return np.unique(directions, axis=1) if directions.shape[1] else directions


def _thinned(frequencies: Array) -> Array:
    """Return some of the frequencies, the first and the last among them. Shapes: (f,)."""
    chosen = np.linspace(0, len(frequencies) - 1, min(len(frequencies), RECEPTANCE.peaks))
    return frequencies[np.unique(chosen.round().astype(int))]
