"""Receptances of a structure: displacements for a unit force, from its matrices or its modes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
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
    # Part of the work of a static force below which what the kept modes leave of it is rounding
    residual: float = 1e-10
    # The same of forces that couple modes: a hundredth of a displacement that is small itself. Of
    # rotors and dampers a smaller part leaves more coordinates, a larger one larger errors
    coupled: float = 1e-4
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


@dataclass(eq=False)
class Coupling:
    """Matrices that couple undamped modes, full or sparse: C and G, H, parts with parameters."""

    damping: Any  # of the rates, shape (n, n)
    stiffness: Any  # of the displacements
    mass: Any  # of the accelerations
    peaks: Array | None = None  # natural frequencies in Hz at which errors are computed
    receptances: dict[float, Complex] = field(default_factory=dict)  # what is known there

    def at(self, turns: Any) -> Any:
        """Return their part of the dynamic stiffness at circular frequencies."""
        return 1j * turns * self.damping + self.stiffness - turns**2 * self.mass

    def within(self, shapes: Array) -> Coupling:
        """Return those of some coordinates. Shapes: (n, r)."""
        parts = (self.damping, self.stiffness, self.mass)
        return Coupling(*(shapes.T @ np.asarray(part @ shapes) for part in parts))


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Modal coordinates of a structure, in which its mass and its stiffness are diagonal."""

    squares: Array  # squared circular frequencies, shape (r,)
    shapes: Array  # displacements of all n degrees of freedom by coordinate, shape (n, r)
    masses: Array  # modal masses in kg, shape (r,)

    def receptance(
        self, directions: Array, frequencies: Array, coupling: Coupling | None = None
    ) -> Complex:
        """Return displacements for unit forces. Shapes: (n, s), (f,); returns (f, s, s)."""
        rows = directions.T @ self.shapes
        turns = 2 * math.pi * frequencies[:, None]
        own = self.masses * (self.squares * (1 + 1j * RECEPTANCE.loss) - turns**2)
        if coupling is None:
            return np.asarray(np.einsum("ai,fi,bi->fab", rows, 1 / own, rows, optimize=True))
        dynamic = own[:, None] * np.eye(len(self.masses)) + coupling.at(turns[:, None])
        return np.asarray(rows @ np.linalg.solve(dynamic, rows.T.astype(complex)))

    def frequencies(self, coupling: Coupling) -> Array:
        """Return those of the coupled modes in Hz, rising, shape (f,)."""
        mass = np.diag(self.masses) + coupling.mass
        stiffness = np.diag(self.masses * self.squares) + coupling.stiffness
        rates = np.linalg.solve(mass, np.hstack([-stiffness, -coupling.damping]))
        moved = np.hstack([np.zeros_like(mass), np.eye(len(mass))])
        values = np.linalg.eigvals(np.vstack([moved, rates]))
        return np.sort(values.imag[values.imag > 0]) / (2 * math.pi)


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
        self.couples: Sequence[Any] = ()  # matrices whose forces couple its modes, (n, n)
        self.coupling: Coupling | None = None  # the same at the model's first values
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

        Of the forces that couple modes those in the lowest ones have such shapes, in which G, C and
        H are right to the second order. With rigid-body modes a small part of the mass is added to
        the stiffness. Forces without the part that the lowest modes take have no such motion, so it
        changes nothing else.

        Shapes: returns (n, d), d at most the number of forces.
        """
        found = np.empty((self.modes.size, 0))
        if count >= self.modes.most:
            return found
        shapes = self.modes.first(count)[1]
        coupled = [product(part, shapes) for part in self.couples]
        sizes = RECEPTANCE.residual, RECEPTANCE.coupled
        for forces, least in zip((self.acting, np.hstack([found, *coupled])), sizes, strict=True):
            forces = forces[:, np.any(forces, axis=0)]
            if forces.shape[1]:
                found = np.hstack([found, self._residual(forces, shapes, found, least)])
        return found

    def _residual(self, forces: Array, shapes: Array, others: Array, least: float) -> Array:
        """Return shapes of what modes and other such shapes leave of the static displacements.

        Shapes: forces (n, a), shapes (n, m), others (n, o); returns (n, d).
        """
        moved = self.mass @ shapes
        moved = moved / np.sum(shapes * moved, axis=0)
        rest = forces - moved @ (shapes.T @ forces)
        answers = self._static(rest)
        for _ in range(RECEPTANCE.corrections if self.modes.free else 1):
            answers += self._static(rest - self.stiffness @ answers)  # without what was added
        answers -= shapes @ (moved.T @ answers)
        held = self.stiffness @ others
        answers -= others @ np.linalg.solve(others.T @ held, held.T @ answers)
        # Forces along one line have one shape; those that the modes take whole have none.
        work = answers.T @ rest
        whole = np.sqrt(np.abs(np.sum(forces * self._static(forces), axis=0)))
        values, mixed = np.linalg.eigh((work + work.T) / 2 / np.outer(whole, whole))
        kept = values > least
        return np.asarray(answers @ (mixed[:, kept] / whole[:, None]))

    def samples(self, band: float, peaks: Array | None = None) -> tuple[Array, Array]:
        """Return some natural frequencies in Hz up to `band`, and frequencies between them."""
        if peaks is None:
            squares = self.modes.first(self.modes.count_up_to(band))[0]
            peaks = np.sqrt(squares[self.modes.free :]) / (2 * math.pi)
        between = (np.append(0.0, peaks) + np.append(peaks, band)) / 2
        return _thinned(peaks), np.union1d(_thinned(between), [band])

    def error(
        self,
        reduced: Coordinates,
        band: float,
        coupling: Coupling | None = None,
        *,
        anew: bool = False,
    ) -> float:
        """Return the largest error of a receptance of modal coordinates up to a frequency in Hz.

        It is relative to the receptance, or to its geometric mean over the band where that is
        larger: near antiresonances. Away from resonances, errors are interpolated. Zero without
        directions. Resonances are those known of the coupling, or anew those of the coordinates.
        """
        if not self.directions.shape[1]:
            return 0.0
        own, coupling = None, coupling or self.coupling
        if coupling is not None:
            own = coupling.within(reduced.shapes)
            if anew or coupling.peaks is None:
                found = reduced.frequencies(own)
                coupling.peaks = found[(found > MATRICES.free * band) & (found <= band)]
        peaks = None if coupling is None else coupling.peaks
        even = np.linspace(0, band, RECEPTANCE.between + 1)[1:]
        sizes = np.abs(reduced.receptance(self.directions, even, own))
        mean = np.exp(np.mean(np.log(np.einsum("faa->fa", sizes)), axis=0))
        typical = np.sqrt(np.outer(mean, mean))
        known = [(part, self._exact(part, coupling)) for part in self.samples(band, peaks)]
        apart = [np.abs(reduced.receptance(self.directions, part, own) - exact)
                 for part, exact in known]  # fmt: skip
        errors = [one / np.maximum(np.abs(exact), typical)
                  for one, (_, exact) in zip(apart, known, strict=True)]  # fmt: skip
        for a, b in np.ndindex(typical.shape):
            likely = np.interp(even, known[1][0], apart[1][:, a, b])
            errors.append(likely / np.maximum(sizes[:, a, b], typical[a, b]))
        return max(float(part.max(initial=0.0)) for part in errors)

    def _displacements(self, turn: float, loss: float, coupling: Coupling | None) -> Complex:
        """Return displacements at a circular frequency for unit forces, shape (n, s)."""
        dynamic = self.stiffness * (1 + 1j * loss) - turn**2 * self.mass
        return solved(dynamic if coupling is None else dynamic + coupling.at(turn), self.directions)

    def _exact(self, frequencies: Array, coupling: Coupling | None = None) -> Complex:
        """Return receptances by solutions with the whole matrices, shape (f, s, s)."""
        known = self._receptances if coupling is None else coupling.receptances
        for frequency in set(frequencies).difference(known):
            moved = self._displacements(2 * math.pi * frequency, RECEPTANCE.loss, coupling)
            known[frequency] = self.directions.T @ moved
        size = self.directions.shape[1]
        return np.array([known[one] for one in frequencies]).reshape(-1, size, size)


def product(matrix: Any, shapes: Array) -> Array:
    """Return a matrix times shapes, zero where that is rounding. Shapes: (n, n), (n, r)."""
    result = np.asarray(matrix @ shapes)
    result[np.abs(result) < MATRICES.projected * np.asarray(abs(matrix) @ np.abs(shapes))] = 0.0
    return result


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
