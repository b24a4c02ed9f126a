"""Fewer degrees of freedom: modal truncation, and the Craig-Bampton method."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.errors import InputError, suggest
from slipfold.models.structures.component import brief
from slipfold.models.structures.matrices import (
    MATRICES,
    Matrix,
    lowest_modes,
    require_symmetric,
    solver,
)
from slipfold.models.units import parse_quantity
from slipfold.text import OneLine, PrintedTable, listed, number_text


@dataclass(frozen=True, eq=False, repr=False)
class ReductionReport(OneLine):
    """Natural frequencies before and after a reduction.

    Parameters
    ----------
    frequencies
        Of the reduced structure in Hz, shape (r,).
    exact
        The lowest of the full structure in Hz, shape (r,).
    band
        Highest frequency in Hz that the reduction is meant for.
    whole
        Number of degrees of freedom before the reduction.

    Examples
    --------
    >>> import numpy as np
    >>> print(ReductionReport(np.array([1.0, 2.02]), np.array([1.0, 2.0]), 1.5, 10))
    10 degrees of freedom reduced to 2
    band up to 1.5 Hz, where natural frequencies are wrong by 0 at most
    f (Hz)  exact (Hz)  error
         1           1      0
      2.02           2   0.01
    """

    frequencies: Array
    exact: Array
    band: float
    whole: int

    @property
    def errors(self) -> Array:
        """Relative errors of the natural frequencies, shape (r,)."""
        free = self.exact <= MATRICES.free * self.exact.max(initial=0.0)
        return np.abs(self.frequencies - self.exact) / np.where(free, np.inf, self.exact)

    @property
    def error(self) -> float:
        """Largest relative error of a natural frequency in the band."""
        return float(self.errors[self.exact <= self.band * (1 + 1e-12)].max(initial=0.0))

    def _line(self) -> str:
        return (
            f"ReductionReport: {self.whole} degrees of freedom to {len(self.exact)}, natural "
            f"frequencies up to {number_text(self.band)} Hz wrong by {self.error:.2g} at most"
        )

    def _rows(self) -> PrintedTable:
        rows = zip(self.frequencies, self.exact, self.errors, strict=True)
        lines = [[*map(number_text, (f, exact)), f"{error:.2g}"] for f, exact, error in rows]
        return PrintedTable(["f (Hz)", "exact (Hz)", "error"], lines)

    def __str__(self) -> str:
        """Table of the frequencies."""
        lines = [
            f"{self.whole} degrees of freedom reduced to {len(self.exact)}",
            f"band up to {self.band:.6g} Hz, where natural frequencies are wrong by "
            f"{self.error:.2g} at most",
            *self._rows().text(),
        ]
        return "\n".join(lines)


@dataclass(frozen=True, eq=False)
class Reduced:
    """A structure in fewer coordinates."""

    names: tuple[str, ...]  # names of the r coordinates
    basis: Array  # displacements of all n degrees of freedom by coordinate, shape (n, r)
    # Reduced matrices, shape (r, r)
    mass: Array
    stiffness: Array
    report: ReductionReport | None = None  # None if they are all degrees of freedom


class Reduction:
    """A way to describe a structure by fewer coordinates: displacements that stay, and modes."""

    title: ClassVar[str] = "reduction"

    boundary: Any = ()
    modes: int | None
    up_to: float | str | None

    def __post_init__(self) -> None:
        """Check that one of the two extents is given."""
        if (self.modes is None) == (self.up_to is None):
            raise InputError(
                f"a {self.title} needs modes, how many to keep, or up_to, the frequency in Hz up "
                "to which to keep them; give one of the two"
            )
        fewest = 1 if self.boundary == () else 0
        if self.modes is not None and (type(self.modes) is not int or self.modes < fewest):
            raise InputError(f"modes = {brief(self.modes)}; give a whole number >= {fewest}")
        if self.up_to is not None:
            value = parse_quantity(self.up_to, "Hz", "up_to")
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"up_to = {value:g} Hz; give a finite frequency > 0")
            object.__setattr__(self, "up_to", value)

    def _fits(self, mass: Matrix, stiffness: Matrix, names: tuple[str, ...]) -> None:
        """Refuse matrices and counts that do not fit, before anything is computed."""
        require_symmetric(
            stiffness,
            "K",
            f"a {self.title} needs a symmetric one, so correct it or keep all coordinates",
        )
        size = len(self._split(names)[1])
        if self.modes is not None and self.modes > size:
            raise InputError(
                f"{self.modes} modes are requested of {size} degrees of freedom; give at most "
                f"{size}"
            )

    def _apply(self, mass: Matrix, stiffness: Matrix, names: tuple[str, ...]) -> Reduced:
        """Return a structure in fewer coordinates."""
        self._fits(mass, stiffness, names)
        m, k = mass.array(), stiffness.array()
        held, free = self._split(names)
        k_free, m_free = _block(k, free, free), _block(m, free, free)
        count = len(held)
        static = np.empty((len(free), 0))
        if count:
            solve = solver(
                k_free,
                "the boundary does not hold the rest of the structure, which can move without "
                "force; add degrees of freedom to the boundary",
            )
            coupling = _block(k, free, held)
            static = -solve(coupling if isinstance(k, np.ndarray) else coupling.toarray())
        squares, shapes = self._modes(k_free, m_free)
        size = count + len(squares)
        if not size:
            raise InputError(
                f"the structure has no mode up to {self.up_to:g} Hz; raise up_to or give modes"
            )
        basis = np.zeros((len(names), size))
        basis[held, np.arange(count)] = 1.0
        basis[free] = np.hstack([static, shapes])
        small_mass = basis.T @ np.asarray(m @ basis)
        small_stiffness = basis.T @ np.asarray(k @ basis)
        # What the theory says is zero must be, or rounding would enter the equations as terms.
        modal = np.diag(small_mass)[count:].copy()
        small_mass[count:, count:] = np.diag(modal)
        small_stiffness[count:] = small_stiffness[:, count:] = 0.0
        small_stiffness[count:, count:] = np.diag(modal * squares)
        reached = exact = _frequencies(squares)
        if count:
            reached = _frequencies(lowest_modes(small_stiffness, small_mass)[0])
            exact = _frequencies(lowest_modes(k, m, size)[0])
        band = float(_frequencies(squares)[-1] if len(squares) else exact[0])
        band = band if self.up_to is None else float(self.up_to)
        kept = (*self.boundary, *(f"mode{number + 1}" for number in range(len(squares))))
        report = ReductionReport(reached, exact, band, mass.size)
        return Reduced(kept, basis, small_mass, small_stiffness, report)

    def _split(self, names: tuple[str, ...]) -> tuple[Indices, Indices]:
        """Return the positions of the boundary and of the other degrees of freedom."""
        for name in self.boundary:
            if name not in names:
                error = InputError(
                    f"the boundary has {brief(name)}, which is no degree of freedom of the "
                    f"structure; {suggest(str(name), names)}it has {listed(names)}"
                )
                error.entry = ("boundary",)
                raise error
        held = np.array([names.index(name) for name in self.boundary], dtype=np.int64)
        free = np.setdiff1d(np.arange(len(names)), held)
        if not len(free):
            raise InputError(
                "the boundary is the whole structure, so there is nothing to reduce; leave the "
                "reduction out"
            )
        return held, free

    def _modes(self, stiffness: Any, mass: Any) -> tuple[Array, Array]:
        """Return as many modes as are requested, or all up to a frequency."""
        size = mass.shape[0]
        if self.modes == 0:
            return np.empty(0), np.empty((size, 0))
        if self.modes is not None:
            return lowest_modes(stiffness, mass, self.modes)
        assert self.up_to is not None
        highest = (2 * math.pi * float(self.up_to)) ** 2
        count = size if isinstance(mass, np.ndarray) else 16
        while True:
            squares, shapes = lowest_modes(stiffness, mass, min(count, size))
            if count >= size or squares[-1] > highest:
                kept = squares <= highest
                return squares[kept], shapes[:, kept]
            count *= 2


@dataclass(frozen=True)
class ModalReduction(Reduction):
    """The lowest undamped modes as coordinates ``mode1 mode2 ...``; they are exact.

    Each mode is scaled so that its largest displacement is 1; a coordinate is a displacement in m.
    The compliance of the higher modes at forces that act at a point is lost.

    Parameters
    ----------
    modes
        How many; or give `up_to`.
    up_to
        Keep the modes up to this frequency in Hz.

    Examples
    --------
    >>> ModalReduction(up_to="200 Hz")
    ModalReduction(modes=None, up_to=200.0)
    """

    title: ClassVar[str] = "modal reduction"

    modes: int | None = None
    up_to: float | str | None = None


@dataclass(frozen=True)
class CraigBampton(Reduction):
    """Boundary degrees of freedom, and modes of the others with the boundary held.

    The coordinates are the boundary's displacements by their names, then ``mode1 mode2 ...``.
    Static loads at the boundary are exact; without modes it is Guyan's condensation.

    Parameters
    ----------
    boundary
        Names of the degrees of freedom that stay: those with elements, contacts and forces.
    modes
        How many modes with the boundary held; or give `up_to`.
    up_to
        Keep the modes with the boundary held up to this frequency in Hz; about 1.5 times the
        highest frequency of interest is usual.

    References
    ----------
    R. R. Craig and M. C. C. Bampton, Coupling of substructures for dynamic analyses, AIAA Journal 6
    (1968) 1313-1319.

    Examples
    --------
    >>> CraigBampton(["tip"], modes=3).boundary
    ('tip',)
    """

    title: ClassVar[str] = "Craig-Bampton reduction"

    boundary: Any = field()
    modes: int | None = None
    up_to: float | str | None = None

    def __post_init__(self) -> None:
        """Check the boundary, and that one of the two extents is given."""
        several = isinstance(self.boundary, Iterable) and not isinstance(self.boundary, str)
        given = tuple(self.boundary) if several else (self.boundary,)
        named = all(isinstance(item, str) for item in given)
        if not given or not named or len(set(given)) < len(given):
            raise InputError(
                f"boundary = {brief(self.boundary)}; give the names "
                "of the degrees of freedom that stay, each once"
            )
        object.__setattr__(self, "boundary", given)
        super().__post_init__()


def _block(matrix: Any, rows: Indices, columns: Indices) -> Any:
    dense = isinstance(matrix, np.ndarray)
    return matrix[np.ix_(rows, columns)] if dense else matrix[rows][:, columns]


def _frequencies(squares: Array) -> Array:
    return np.sqrt(np.maximum(squares, 0.0)) / (2 * math.pi)
