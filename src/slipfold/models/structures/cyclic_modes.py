"""Modes and receptances of a cyclic structure, from matrices of one sector."""

from __future__ import annotations

from typing import Any

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.models.structures.cyclic import Sectors
from slipfold.models.structures.matrices import Matrix, solver
from slipfold.models.structures.receptance import FullStructure, LowestModes, Solve, solved


class CyclicModes(LowestModes):
    r"""The lowest modes of all sectors that repeat, by waves.

    Sector s moves by :math:`\phi e^{2\pi i n s/m}` in a wave; the other one with this frequency
    travels backward. Their parts in phase and out of phase are the modes.
    """

    def __init__(
        self, stiffness: Any, mass: Any, waves: list[tuple[Any, Any]], sectors: int
    ) -> None:
        super().__init__(stiffness, mass)
        self._waves = [LowestModes(*pair) for pair in waves[: sectors // 2 + 1]]
        self._sectors = sectors

    def _compute(self, count: int) -> tuple[Array, Array]:
        found = []
        for number, wave in enumerate(self._waves):
            alone = number == 0 or 2 * number == self._sectors
            several = min(count if alone else -(-count // 2), wave.most)
            squares, shapes = wave.first(several)
            turns = np.exp(2j * np.pi * number * np.arange(self._sectors) / self._sectors)
            whole = (turns[:, None, None] * shapes).reshape(self.size, -1)
            pair = [whole.real] if alone else [whole.real, whole.imag]
            found.append(
                (np.repeat(squares, len(pair)), np.stack(pair, axis=2).reshape(self.size, -1))
            )
        squares = np.concatenate([one for one, _ in found])
        lowest = np.argsort(squares, kind="stable")[:count]  # of two equal ones, both
        return squares[lowest], np.hstack([shapes for _, shapes in found])[:, lowest]


class CyclicStructure(FullStructure):
    """All sectors that repeat; equations with their matrices are solved wave by wave."""

    def __init__(
        self,
        sectors: Sectors,
        one: tuple[Matrix, Matrix],
        whole: tuple[Any, Any],
        acting: Array,
        watched: Array,
    ) -> None:
        super().__init__(*whole, acting, watched)
        self._count = sectors.count
        each = sectors.cyclic.sectors // sectors.count
        mass, stiffness = one
        self._waves = [
            (sectors.wave(number * each, stiffness), sectors.wave(number * each, mass))
            for number in range(self._count)
        ]
        self.modes = CyclicModes(self.stiffness, self.mass, self._waves, self._count)

    def _solver(self, added: float, what: str) -> Solve:
        solvers = [solver(stiffness + added * mass, what) for stiffness, mass in self._waves]
        return lambda right: self._by_waves(solvers, right).real

    def _displacements(self, turned: float, loss: float) -> Complex:
        def each(stiffness: Any, mass: Any) -> Solve:
            return lambda right: solved(stiffness * (1 + 1j * loss) - turned * mass, right)

        return self._by_waves([each(*pair) for pair in self._waves], self.directions)

    def _by_waves(self, solvers: list[Solve], right: Array) -> Complex:
        """Solve for the waves of which forces consist. Shapes: right (n, a)."""
        parts = np.fft.fft(right.reshape(self._count, -1, right.shape[1]), axis=0)
        answers = [solve(part) for solve, part in zip(solvers, parts, strict=True)]
        return np.asarray(np.fft.ifft(np.array(answers), axis=0).reshape(right.shape))
