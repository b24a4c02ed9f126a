"""Few modal coordinates for many degrees of freedom: modes, static shapes, their error."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.errors import InputError, suggest
from slipfold.models.structures.component import brief, is_whole
from slipfold.models.structures.matrices import (
    MATRICES,
    Matrix,
    frequencies_of,
    require_symmetric,
    solver,
)
from slipfold.models.structures.receptance import Coordinates, Coupling, FullStructure, LowestModes
from slipfold.models.units import parse_quantity
from slipfold.read_only import Documented
from slipfold.text import OneLine, PrintedTable, listed, number_text


@dataclass(frozen=True, eq=False, repr=False)
class ReductionReport(OneLine, Documented):
    """What a reduction changes: natural frequencies and receptances, computed with all of it.

    A receptance is the displacement along one direction for a unit force along another, at one
    frequency. The directions are those of elements, contacts, forcing and `watch`. Receptances are
    compared at natural frequencies in the band and between them, six of each at most, and errors
    are interpolated; with a loss factor of 2 %, since an undamped resonance is infinite, and with
    the matrices C, G, H and parts with parameters at the model's values. The error is relative to
    the receptance, or to its geometric mean over the band where that is larger, beside
    antiresonances. So the motion that given forces cause is wrong by this part, harmonic by
    harmonic, as far as the harmonics are in the band. How much more a response changes where it is
    sensitive to forces, at a fold or near a loss of stability, it does not say.

    Examples
    --------
    >>> import numpy as np
    >>> print(ReductionReport(np.array([1.0, 2.02]), np.array([1.0, 2.0]), 1.5, 10, 3e-4))
    10 degrees of freedom reduced to 2
    band up to 1.5 Hz, where natural frequencies are wrong by 0 at most, receptances by 0.0003
    f (Hz)  exact (Hz)  error
         1           1      0
      2.02           2   0.01
    """

    frequencies: Annotated[Array, "Natural ones of the reduced structure in Hz, shape (r,)."]
    exact: Annotated[Array, "The lowest of the full structure in Hz, shape (r,)."]
    band: Annotated[float, "Highest frequency in Hz that the reduction is meant for."]
    whole: Annotated[int, "Number of degrees of freedom before the reduction."]
    receptance_error: Annotated[
        float, "Largest relative error of a receptance in the band; NaN without directions."
    ] = math.nan
    rounding: Annotated[
        float,
        "Relative change of the lowest natural frequency that the rounding of the stiffness "
        "matrix to floats may cause: large for fine meshes of beams, where no reduction can be "
        "better.",
    ] = 0.0

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
            f"ReductionReport: {self.whole} degrees of freedom to {len(self.exact)}, up to "
            f"{number_text(self.band)} Hz {self._errors}"
        )

    @property
    def _errors(self) -> str:
        known = not math.isnan(self.receptance_error)
        other = f", receptances by {self.receptance_error:.2g}" if known else ""
        return f"natural frequencies are wrong by {self.error:.2g} at most{other}"

    def _rows(self) -> PrintedTable:
        rows = zip(self.frequencies, self.exact, self.errors, strict=True)
        lines = [[*map(number_text, (f, exact)), f"{error:.2g}"] for f, exact, error in rows]
        return PrintedTable(["f (Hz)", "exact (Hz)", "error"], lines)

    def __str__(self) -> str:
        """Table of the frequencies."""
        lines = [
            f"{self.whole} degrees of freedom reduced to {len(self.exact)}",
            f"band up to {self.band:.6g} Hz, where {self._errors}",
            *self._rows().text(),
        ]
        if self.rounding > MATRICES.asymmetry:
            lines.append(
                f"rounding of the stiffness matrix changes the lowest by up to {self.rounding:.2g}"
            )
        return "\n".join(lines)


@dataclass(frozen=True, eq=False)
class Reduced:
    """A structure in modal coordinates, with the full one that they approximate."""

    coordinates: Coordinates
    band: float  # highest frequency in Hz that they are meant for
    full: FullStructure

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the r coordinates."""
        return tuple(f"mode{number + 1}" for number in range(len(self.coordinates.squares)))

    def report(self, coupling: Coupling | None) -> ReductionReport:
        """Compare the coordinates with the full structure, with what couples its modes."""
        squares = self.coordinates.squares
        directions = self.full.directions.shape[1]
        exact = frequencies_of(self.full.modes.first(len(squares))[0])
        exact[: self.full.modes.free] = 0.0  # without rounding errors
        return ReductionReport(
            frequencies_of(squares),
            exact,
            self.band,
            self.full.modes.size,
            self.full.error(self.coordinates, self.band, coupling) if directions else math.nan,
            self.full.rounding,
        )


Accuracy = Annotated[
    float | None,
    "Keep as many more modes as receptances up to `up_to` need to be wrong by this at most, as "
    "`ReductionReport` measures it, at the values that parameters have where none are given.",
]


class Reduction(Documented, ABC):
    """A way to describe a structure by few modal coordinates."""

    title: ClassVar[str] = "reduction"

    boundary: Any = ()
    modes: int | None
    up_to: float | str | None
    accuracy: float | None

    def __post_init__(self) -> None:
        """Check that one of the two extents is given."""
        if (self.modes is None) == (self.up_to is None):
            raise InputError(
                f"a {self.title} needs modes, how many to keep, or up_to, the frequency in Hz up "
                "to which to keep them; give one of the two"
            )
        fewest = 1 if self.boundary == () else 0
        if self.modes is not None and (not is_whole(self.modes, fewest)):
            raise InputError(f"modes = {brief(self.modes)}; give a whole number >= {fewest}")
        if self.up_to is not None:
            value = parse_quantity(self.up_to, "Hz", "up_to")
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"up_to = {value:g} Hz; give a finite frequency > 0")
            object.__setattr__(self, "up_to", value)
        if self.accuracy is not None:
            self._check_accuracy(self.accuracy)

    def _check_accuracy(self, given: float) -> None:
        value = parse_quantity(given, "", "accuracy")
        if not 0 < value < 1:
            raise InputError(f"accuracy = {value:g}; give a relative error between 0 and 1")
        if self.up_to is None:
            raise InputError(
                f"accuracy = {value:g} says how many modes to keep, and modes = {self.modes} too; "
                "give up_to, the frequency in Hz up to which to be accurate, in place of modes"
            )
        object.__setattr__(self, "accuracy", value)

    def _fits(self, mass: Matrix, stiffness: Matrix, names: tuple[str, ...]) -> None:
        """Refuse matrices and counts that do not fit, before anything is computed."""
        require_symmetric(
            stiffness,
            "K",
            f"a {self.title} needs a symmetric one, so correct it or keep all coordinates",
        )
        size = mass.size - len(np.union1d(mass.empty, self._held(names)))
        if self.modes is not None and self.modes > size:
            raise InputError(
                f"{self.modes} modes are requested of {size} degrees of freedom; give at most "
                f"{size}"
            )

    def _held(self, names: tuple[str, ...]) -> Indices:
        """Return the positions of the boundary, shape (held,)."""
        for name in self.boundary:
            if name not in names:
                raise InputError(
                    f"the boundary has {brief(name)}, which is no degree of freedom of the "
                    f"structure; {suggest(str(name), names)}it has {listed(names)}",
                    "boundary",
                )
        if len(self.boundary) == len(names):
            raise InputError(
                "the boundary is the whole structure, so there is nothing to reduce; leave the "
                "reduction out"
            )
        return np.array([names.index(name) for name in self.boundary], dtype=np.int64)

    def _apply(self, full: FullStructure, names: tuple[str, ...]) -> Reduced:
        """Return a structure in few modal coordinates."""
        shapes = self._shapes(full, names)
        if self.up_to is None:
            assert self.modes is not None
            coordinates = shapes.coordinates(self.modes)
            kept = shapes.modes.first(self.modes)[0] if self.modes else full.modes.first(1)[0]
            return Reduced(coordinates, float(frequencies_of(kept)[-1]), full)
        band = float(self.up_to)
        count = shapes.modes.count_up_to(band)
        if self.accuracy is None:
            if not count and self.boundary == ():
                raise InputError(
                    f"the structure has no mode up to {band:g} Hz; raise up_to or give modes"
                )
            return Reduced(shapes.coordinates(count), band, full)
        return Reduced(self._accurate(full, shapes, max(count, 1)), band, full)

    def _accurate(self, full: FullStructure, shapes: Shapes, count: int) -> Coordinates:
        """Return the coordinates with the fewest modes, at least `count`, that are accurate."""
        assert self.accuracy is not None
        assert isinstance(self.up_to, float)
        if not full.directions.shape[1]:
            raise InputError(
                f"accuracy = {self.accuracy:g} is that at elements, contacts, forcing and watched "
                "displacements, and the structure has none; add one, or leave accuracy out"
            )
        best = math.inf
        for kept in range(count, min(shapes.modes.most, max(count, MATRICES.most_modes)) + 1):
            coordinates = shapes.coordinates(kept)
            error = full.error(coordinates, self.up_to)
            if error <= self.accuracy:  # at resonances of fewer coordinates
                error = full.error(coordinates, self.up_to, anew=True)
            if error <= self.accuracy:
                return coordinates
            best = min(best, error)
        fine = (
            ""
            if best > 1e3 * full.rounding
            else (
                ", and rounding of the stiffness matrix changes the lowest natural frequency by "
                f"{full.rounding:.2g}"
            )
        )
        raise InputError(
            f"receptances up to {self.up_to:g} Hz are wrong by {best:.2g} at least with up to "
            f"{kept} modes, more than accuracy = {self.accuracy:g}{fine}; give a larger accuracy "
            "or a lower up_to"
        )

    @abstractmethod
    def _shapes(self, full: FullStructure, names: tuple[str, ...]) -> Shapes:
        """Return the shapes from which the coordinates are made."""


class Shapes(ABC):
    """Shapes of a structure, of which modes are as many as are requested."""

    modes: LowestModes

    @abstractmethod
    def coordinates(self, count: int) -> Coordinates:
        """Return modal coordinates of what some modes and the other shapes span."""


class FreeShapes(Shapes):
    """LowestModes of the structure, and perhaps what they leave of static displacements."""

    def __init__(self, full: FullStructure, residual: bool) -> None:
        self.full, self.modes, self.residual = full, full.modes, residual

    def coordinates(self, count: int) -> Coordinates:
        """Return the modes, and after them the residual shapes, which are orthogonal to them."""
        squares, shapes = self.modes.first(count)
        others = self.full.residual_shapes(count) if self.residual else shapes[:, :0]
        if others.shape[1]:
            rest = self.full.coordinates(others)
            squares = np.append(squares, rest.squares)
            shapes = np.hstack([shapes, rest.shapes])
        return self.full.diagonal(squares, shapes)


class HeldShapes(Shapes):
    """Static shapes of a boundary, and modes with the boundary held."""

    def __init__(self, full: FullStructure, held: Indices) -> None:
        self.full, self.held = full, held
        self.free = np.setdiff1d(np.arange(full.modes.size), held)
        coupled = _block(full.stiffness, self.free, self.free)
        self.modes = LowestModes(coupled, _block(full.mass, self.free, self.free))
        loose = (
            "the boundary does not hold the rest of the structure, which can move without "
            "force; add degrees of freedom to the boundary"
        )
        if self.modes.free:
            raise InputError(loose)
        solve = solver(coupled, loose)
        coupling = _block(full.stiffness, self.free, held)
        self.static = -solve(coupling if isinstance(coupling, np.ndarray) else coupling.toarray())

    def coordinates(self, count: int) -> Coordinates:
        """Return modal coordinates of the static shapes and some modes."""
        fixed = self.modes.first(count)[1]
        shapes = np.zeros((self.full.modes.size, len(self.held) + count))
        shapes[self.held, np.arange(len(self.held))] = 1.0
        shapes[self.free] = np.hstack([self.static, fixed])
        return self.full.coordinates(shapes)


@dataclass(frozen=True)
class ModalReduction(Reduction):
    """The lowest undamped modes; they are exact.

    The coordinates are ``mode1 mode2 ...``; the largest displacement of each is 1, so they are in
    m. The compliance of the higher modes at forces that act at a point is lost.

    Examples
    --------
    >>> ModalReduction(up_to="200 Hz")
    ModalReduction(modes=None, up_to=200.0, accuracy=None)
    """

    title: ClassVar[str] = "modal reduction"

    modes: Annotated[int | None, "How many; or give `up_to`."] = None
    up_to: Annotated[float | str | None, "Keep the modes up to this frequency in Hz."] = None
    accuracy: Accuracy = None

    def _shapes(self, full: FullStructure, names: tuple[str, ...]) -> Shapes:
        return FreeShapes(full, residual=False)


@dataclass(frozen=True)
class FreeInterface(ModalReduction):
    """The lowest undamped modes, and what the others add where forces act.

    The modes are those of `ModalReduction`, exact. For each direction of an element, a contact or a
    force there is one coordinate more: the static displacement of the other modes (Rubin). So
    static forces there cause the exact displacement. There are more for the forces that C, G, H and
    parts with parameters exert in the modes. Of these static shapes the modal coordinates of the
    highest frequencies are made.

    References
    ----------
    S. Rubin, Improved component-mode representation for structural dynamic analysis, AIAA Journal
    13 (1975) 995-1006.

    Examples
    --------
    >>> FreeInterface(up_to="200 Hz", accuracy=1e-4)
    FreeInterface(modes=None, up_to=200.0, accuracy=0.0001)
    """

    title: ClassVar[str] = "free-interface reduction"

    def _shapes(self, full: FullStructure, names: tuple[str, ...]) -> Shapes:
        return FreeShapes(full, residual=True)


@dataclass(frozen=True)
class CraigBampton(Reduction):
    """Static shapes of boundary degrees of freedom, and modes of the others with it held.

    The coordinates ``mode1 mode2 ...`` are the modes of the structure in these shapes; the
    boundary's displacements are outputs by their names. Static loads at the boundary are exact;
    without modes it is Guyan's condensation.

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

    boundary: Annotated[
        Any, "Names of the degrees of freedom with elements, contacts and forces."
    ] = field()
    modes: Annotated[int | None, "How many modes with the boundary held; or give `up_to`."] = None
    up_to: Annotated[
        float | str | None,
        "Keep the modes with the boundary held up to this frequency in Hz; about 1.5 times the "
        "highest frequency of interest is usual.",
    ] = None
    accuracy: Accuracy = None

    def __post_init__(self) -> None:
        """Check the boundary, and that one of the two extents is given."""
        several = isinstance(self.boundary, Iterable) and not isinstance(self.boundary, str)
        given = tuple(self.boundary) if several else (self.boundary,)
        named = all(isinstance(item, str) for item in given)
        if not given or not named or len(set(given)) < len(given):
            raise InputError(
                f"boundary = {brief(self.boundary)}; give the names "
                "of the degrees of freedom with elements, contacts and forces, each once"
            )
        object.__setattr__(self, "boundary", given)
        super().__post_init__()

    def _shapes(self, full: FullStructure, names: tuple[str, ...]) -> Shapes:
        return HeldShapes(full, self._held(names))


def _block(matrix: Any, rows: Indices, columns: Indices) -> Any:
    dense = isinstance(matrix, np.ndarray)
    return matrix[np.ix_(rows, columns)] if dense else matrix[rows][:, columns]
