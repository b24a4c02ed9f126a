"""Cyclic symmetry: one sector of a structure of equal ones, and the sectors that repeat."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np

from slipfold.arrays import Array, Complex, Indices
from slipfold.errors import InputError, suggest
from slipfold.models.structures.component import (
    EVERY,
    Component,
    Direction,
    Sector,
    brief,
    degrees_along,
    is_whole,
)
from slipfold.models.structures.contacts import NormalLoad
from slipfold.models.structures.matrices import (
    MATRICES,
    Matrix,
    frequencies_of,
    lowest_modes,
    solver,
)
from slipfold.models.structures.receptance import (
    Coupling,
    FullStructure,
    LowestModes,
    Solve,
    solved,
)
from slipfold.text import listed

MOST_SECTORS = 1000
"""Most sectors: a bladed disk has some tens, and each one that repeats has coordinates."""

_Part = TypeVar("_Part", Component, NormalLoad)


@dataclass(frozen=True)
class CyclicSymmetry:
    r"""Equal sectors around an axis, of which matrices and components of one are given.

    Displacements are along axes that turn with the sectors, such as radial ones; those of `high`
    along the axes of the next sector. What is periodic in time travels around with the engine order
    k: in sector j it is that of the given sector, later by :math:`jk/(Nf)`.
    So sectors that are :math:`m = N/\gcd(N, k)` apart move alike, and m of them are the structure
    of the equations. The motion of all of these is computed, so contacts within a sector, to the
    ground and between neighbors are exact, with all harmonics. A loss of stability to motions that
    do not repeat after m sectors is not seen.

    The next sectors' degrees of freedom are called ``tip_s1``, ``tip_s2`` and so on. Outputs,
    memories and limits of components end in the same way; their parameters are those of the given
    sector.

    Parameters
    ----------
    sectors
        Their number N, from 2 to 1000.
    engine_order
        Number k of periods of the forcing around the axis, 0 or more. It excites the nodal diameter
        ``nodal_diameter`` with its first harmonic.
    low, high
        Names of the degrees of freedom of the given sector on its two boundaries, a sequence or one
        text with blanks between. Each of `high` is that of `low` in the same place in the next
        sector, so it has no name of its own there.

    Examples
    --------
    >>> ring = CyclicSymmetry(sectors=12, engine_order=9, low="a", high="b")
    >>> ring.nodal_diameter, ring.repeating
    (3, 4)
    """

    sectors: int
    engine_order: int
    low: Any
    high: Any

    def __post_init__(self) -> None:
        """Check the numbers and the names."""
        for name, least in (("sectors", 2), ("engine_order", 0)):
            value = getattr(self, name)
            if not is_whole(value, least, MOST_SECTORS):
                raise InputError(
                    f"{name} = {brief(value)}; give a whole number from {least} to {MOST_SECTORS}",
                    name,
                )
            object.__setattr__(self, name, int(value))
        for name in ("low", "high"):
            object.__setattr__(self, name, _names(getattr(self, name), name))
        if len(self.low) != len(self.high):
            raise InputError(
                f"low has {len(self.low)} degrees of freedom and high {len(self.high)}; give those "
                "of one boundary and, in the same order, of the other",
                "high",
            )

    @property
    def nodal_diameter(self) -> int:
        """Nodal diameters of the first harmonic of the motion."""
        rest = self.engine_order % self.sectors
        return min(rest, self.sectors - rest)

    @property
    def repeating(self) -> int:
        """Number m of sectors after which the motion repeats."""
        return self.sectors // math.gcd(self.sectors, self.engine_order)

    @property
    def note(self) -> str:
        """What is computed, as a sentence."""
        alike = "move alike" if self.repeating == 1 else f"repeat after {self.repeating}"
        return (
            f"{self.sectors} sectors, of which one is given: engine order {self.engine_order} "
            f"excites nodal diameter {self.nodal_diameter}, and the sectors {alike}"
        )


def _names(given: Any, key: str) -> tuple[str, ...]:
    several = isinstance(given, Iterable) and not isinstance(given, str)
    names = tuple(given) if several else tuple(str(given).split())
    if not names or not all(isinstance(name, str) for name in names):
        raise InputError(f"{key} = {brief(given)}; give names of degrees of freedom", key)
    if len(set(names)) < len(names):
        raise InputError(f"{key} has a degree of freedom twice; give each once", key)
    return names


_ANOTHER = re.compile(r"(.+)_s([1-9]\d*)")
"""Name of a degree of freedom of another sector."""


class Sectors:
    """The sectors that repeat, with the degrees of freedom of all.

    Raises `InputError` if a boundary is not in the sector, or two of them have one name.
    """

    def __init__(self, cyclic: CyclicSymmetry, names: tuple[str, ...]) -> None:
        for key in ("low", "high"):
            for name in getattr(cyclic, key):
                if name not in names:
                    raise InputError(
                        f"{key} has {brief(name)}, which is no degree of freedom of the sector; "
                        f"{suggest(name, names)}it has {listed(names)}",
                        key,
                    )
        self.cyclic, self.own = cyclic, names
        self.count = cyclic.repeating
        joined = dict(zip(cyclic.high, cyclic.low, strict=True))
        if both := sorted(joined.keys() & set(cyclic.low)):
            raise InputError(f"{both[0]} is in low and in high; give it to one boundary", "high")
        self.kept = tuple(name for name in names if name not in joined)
        places = {name: place for place, name in enumerate(self.kept)}
        self._places = np.array([places[joined.get(name, name)] for name in names])
        # Of the degrees of freedom that are the next sector's, one
        self.ahead = np.array([name in joined for name in names], dtype=np.int64)
        self._known = {name: place for place, name in enumerate(names)}
        self.names = tuple(
            name if sector == 0 else f"{name}_s{sector}"
            for sector in range(self.count)
            for name in self.kept
        )
        if len({*self.names, *cyclic.high}) < len(self.names) + len(cyclic.high):
            raise InputError(
                "a degree of freedom has the name of another sector's, such as tip_s1; rename it",
                "sectors",
            )

    def places(self, sector: int) -> Indices:
        """Return where the degrees of freedom of a sector are among all, shape (n,)."""
        return self._places + len(self.kept) * ((sector + self.ahead) % self.count)

    def matrix(self, one: Matrix) -> Matrix:
        """Return the matrix of all sectors. Shapes: one (n, n)."""
        size = len(self.names)
        everywhere = [self.places(sector) for sector in range(self.count)]
        keys = np.concatenate([place[one.rows] * size + place[one.columns] for place in everywhere])
        unique, inverse = np.unique(keys, return_inverse=True)
        entries = np.bincount(inverse, np.tile(one.entries, self.count), len(unique))
        kept = entries != 0
        rows, columns = np.divmod(unique[kept], size)
        terms = tuple((text, self.matrix(part)) for text, part in one.terms)
        return Matrix(size, rows, columns, entries[kept], terms=terms)

    def wave(self, diameter: int, one: Matrix) -> Any:
        r"""Return the matrix of one sector in a wave that travels with some nodal diameters.

        Displacements on the high boundary are those on the low one, times
        :math:`e^{2\pi i d/N}`; so it is Hermitian if the sector's is symmetric.

        Shapes: one (n, n); returns (kept, kept).
        """
        from scipy.sparse import coo_array

        turned = np.exp(2j * np.pi * diameter / self.cyclic.sectors * self.ahead)
        entries = one.entries * turned[one.columns] * turned[one.rows].conj()
        places = (self._places[one.rows], self._places[one.columns])
        result = coo_array((entries, places), (len(self.kept),) * 2)
        return result.toarray() if len(self.kept) <= MATRICES.dense else result.tocsr()

    def frequencies(self, mass: Matrix, stiffness: Matrix, modes: int) -> Array:
        """Return the natural frequencies in Hz, shape (N // 2 + 1, modes)."""
        squares = [
            lowest_modes(self.wave(d, stiffness), self.wave(d, mass), modes)[0]
            for d in range(self.cyclic.sectors // 2 + 1)
        ]
        return frequencies_of(np.array(squares))

    def name(self, name: str, sector: int) -> str:
        """Return the name that a degree of freedom has where a sector is the given one."""
        match = _ANOTHER.fullmatch(name)
        if name not in self._known and match and match[1] in self._known:
            name, sector = match[1], sector + int(match[2])
        if name not in self._known:
            raise InputError(
                f"the sector has no degree of freedom {brief(name)}; {suggest(name, self.own)}it "
                f"has {listed(self.own)}, and the next one {self.kept[0]}_s1 and so on"
            )
        place = self._places[self._known[name]] + len(self.kept) * (
            (sector + self.ahead[self._known[name]]) % self.count
        )
        return self.names[place]

    def direction(self, given: Direction, sector: int) -> Direction:
        """Return a direction where a sector is the given one."""
        weights: dict[str, float] = {}
        for name, weight in given.weights:
            every = degrees_along(name, self.own) if name.startswith(EVERY) else []
            for one in [self.own[place] for place in every] or [name]:
                known = self.name(one, sector)
                weights[known] = weights.get(known, 0.0) + weight
        kept = tuple((name, weight) for name, weight in weights.items() if weight)
        if not kept:
            raise InputError(
                f"with engine_order = {self.cyclic.engine_order} all {self.cyclic.sectors} sectors "
                f"move alike, so {given} is always zero; leave the component out"
            )
        return Direction(kept)

    def component(self, given: Component, sector: int) -> Component:
        """Return a component where a sector is the given one."""
        made = self._moved(given, sector)
        if sector:
            later = sector * self.cyclic.engine_order % self.cyclic.sectors
            object.__setattr__(made, "sector", Sector(sector, later / self.cyclic.sectors))
        return made

    def components(self, given: Iterable[Component]) -> tuple[Any, ...]:
        """Return the components of all sectors, the given one first."""
        several = tuple(given)
        if self.count > 1 and (base := next((one for one in several if one.inertial), None)):
            raise InputError(
                f"a {base.title} moves all sectors at once, which is the engine order 0 and not "
                f"{self.cyclic.engine_order}; give engine_order = 0, or forces"
            )
        return tuple(self.component(one, sector) for sector in range(self.count) for one in several)

    def _moved(self, part: _Part, sector: int) -> _Part:
        """Return a part with its directions where a sector is the given one."""
        changes: dict[str, Any] = {}
        for item in fields(part):
            value = getattr(part, item.name)
            if isinstance(value, Direction):
                changes[item.name] = self.direction(value, sector)
            elif isinstance(value, NormalLoad):
                changes[item.name] = self._moved(value, sector)
            elif isinstance(value, tuple) and value and isinstance(value[0], Direction):
                changes[item.name] = tuple(self.direction(one, sector) for one in value)
        return replace(part, **changes)


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

    def _displacements(self, turn: float, loss: float, coupling: Coupling | None) -> Complex:
        if coupling is not None:
            return super()._displacements(turn, loss, coupling)

        def each(stiffness: Any, mass: Any) -> Solve:
            return lambda right: solved(stiffness * (1 + 1j * loss) - turn**2 * mass, right)

        return self._by_waves([each(*pair) for pair in self._waves], self.directions)

    def _by_waves(self, solvers: list[Solve], right: Array) -> Complex:
        """Solve for the waves of which forces consist. Shapes: right (n, a)."""
        parts = np.fft.fft(right.reshape(self._count, -1, right.shape[1]), axis=0)
        answers = [solve(part) for solve, part in zip(solvers, parts, strict=True)]
        return np.asarray(np.fft.ifft(np.array(answers), axis=0).reshape(right.shape))
