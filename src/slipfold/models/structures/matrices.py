"""Matrices of a structure: checked, completed, compared by content; their modes."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Indices
from slipfold.errors import InputError
from slipfold.models.quantities import Expression
from slipfold.models.structures.matrix_files import read_matrix
from slipfold.text import listed


class MATRICES:
    """Bounds of size, symmetry, regularity and rounding of matrices."""

    dense: int = 600  # largest size at which full arrays are used; beyond it sparse ones
    modal: int = 80  # largest size of equations with modes, which take longer to compile
    # Difference between an entry and its mirror image, over the largest entry, that is rounding
    asymmetry: float = 1e-9
    # Size of entries of the inverse mass times a matrix, over the largest in the row, likewise
    rounding: float = 1e-15
    # Size of an entry in modal coordinates over the sum of the sizes of its terms, likewise: a
    # hundred roundings, since the shapes have errors, too
    projected: float = 2e-14
    # Smallest eigenvalue of a mass matrix with unit diagonal at which it is regular
    singular: float = 1e-13
    singular_sparse: float = 1e-11  # the same by Lanczos' method, which is less exact
    equal: float = 1e-10  # relative difference of squared frequencies that are one
    condition: float = 1e14  # of a matrix with unit diagonal, beyond which it is singular
    lanczos: int = 200  # its steps: they find an eigenvalue 0 beside a least one of 1e-3
    # Shift of the search for sparse modes, over a typical squared frequency: with it the matrix to
    # factor is regular though rigid-body modes have no stiffness
    shift: float = 1e-12
    missed: int = 4  # modes, besides those found, that are looked for at a time
    # Ratio of the largest squared frequency to the smallest at which rounding errors matter
    wide: float = 1e5
    # Ratio of them at which the smallest is known to four digits at best, so that it is refused
    hidden: float = 1e12
    steep: float = 1e8  # ratio of them that may be why no motion is found
    # Frequency over the largest one below which a motion is free: it has no relative error
    free: float = 1e-6
    coupled: float = 1e-9  # damping between two modes, over the mean of their own, that is rounding
    # Singular value of a matrix in units of the masses, over the largest, that is rounding: weak
    # dampers beside strong ones are few roundings times the number of degrees of freedom larger
    rank: float = 1e-13
    joined: int = 8  # rank of a matrix that couples modes, or rows, up to which it is a few forces
    most_modes: int = 120  # that are tried for an accuracy: orbits of more take minutes each


UNITS = {
    "SI": (1.0, 1.0),
    "mm-t-s": (1e-3, 1e3),
    "mm-kg-s": (1e-3, 1.0),
    "in-lbf-s": (0.0254, 4.4482216152605 / 0.0254),
}
"""Length in m and mass in kg of systems of units with time in s, as matrices are given in them."""

_ROTATION = re.compile(r"(r|rot|th|theta)[xyz](\d+|_\w+)?")


def lengths_of(units: str, names: Sequence[str]) -> Array:
    """Return the units of degrees of freedom in m, 1 for rotations such as ``rx17``, shape (n,)."""
    return np.array([1.0 if _ROTATION.fullmatch(name) else UNITS[units][0] for name in names])


@dataclass(frozen=True)
class Matrix:
    """A square matrix by its entries that are not zero; immutable, hashed by content."""

    size: int  # number of rows n
    # Places of the entries, row by row, shape (nonzeros,)
    rows: NDArray[np.int64] = field(compare=False)
    columns: NDArray[np.int64] = field(compare=False)
    entries: Array = field(compare=False)  # their values in SI units, shape (nonzeros,)
    digest: bytes = field(init=False, repr=False)
    completed: str = field(default="", compare=False)  # the triangle that was given: lower, upper
    units: str = field(default="", compare=False)  # those in which it was given, if not SI
    # Formulas of parameters with the matrices that they multiply, which are added to it
    terms: tuple[tuple[str, Matrix], ...] = ()

    def __post_init__(self) -> None:
        """Freeze the entries and note their digest, by which matrices are compared."""
        parts = (self.rows, self.columns, self.entries)
        for part in parts:
            part.setflags(write=False)
        text = b"".join(part.tobytes() for part in parts)
        object.__setattr__(self, "digest", hashlib.sha256(text).digest())

    def __repr__(self) -> str:
        """Size and number of entries."""
        return f"Matrix({self.size} x {self.size}, {len(self.entries)} entries)"

    def dense(self) -> Array:
        """Return a new full array, shape (n, n)."""
        result = np.zeros((self.size, self.size))
        result[self.rows, self.columns] = self.entries
        return result

    def array(self) -> Any:
        """Return the matrix for calculations: full if small, SciPy sparse if large."""
        if self.size <= MATRICES.dense:
            return self.dense()
        # SciPy takes a while to load, and small structures do without it.
        from scipy.sparse import csr_array

        return csr_array((self.entries, (self.rows, self.columns)), shape=(self.size, self.size))

    @cached_property
    def one_sided(self) -> bool:
        """Whether there are entries off the diagonal, none of them with a mirror image."""
        off = self.rows != self.columns
        rows, columns = self.rows[off], self.columns[off]
        # Most matrices are complete, which their first entry shows.
        if not len(rows) or np.any((rows == columns[0]) & (columns == rows[0])):
            return False
        mirrored = np.isin(columns * self.size + rows, rows * self.size + columns)
        return not mirrored.any()

    @property
    def triangle(self) -> str:
        """``"lower"`` or ``"upper"`` for one triangle of what may be a symmetric matrix, or empty.

        Where there are entries off the diagonal, those on it are positive.
        """
        below, above = self.rows >= self.columns, self.rows <= self.columns
        coupled = np.union1d(self.rows[below != above], self.columns[below != above])
        if not (np.all(self.diagonal[coupled] > 0) or not self.diagonal.any()):
            return ""
        return "lower" if below.all() else "upper" if above.all() else ""

    @property
    def diagonal(self) -> Array:
        """The entries on the diagonal, shape (n,)."""
        result = np.zeros(self.size)
        on = self.rows == self.columns
        result[self.rows[on]] = self.entries[on]
        return result

    @property
    def empty(self) -> Indices:
        """Rows without entries: displacements without mass, if it is a mass matrix."""
        return np.flatnonzero(np.bincount(self.rows, minlength=self.size) == 0)

    def part(self, kept: Indices) -> Matrix:
        """Return the matrix of some rows and columns, in ascending order."""
        places = np.full(self.size, -1)
        places[kept] = np.arange(len(kept))
        rows, columns = places[self.rows], places[self.columns]
        inside = (rows >= 0) & (columns >= 0)
        return Matrix(len(kept), rows[inside], columns[inside], self.entries[inside])

    def mirrored(self, sign: float = 1.0) -> Matrix:
        """Return the symmetric matrix of which this is one half, or the skew-symmetric one."""
        off = self.rows != self.columns
        rows = np.concatenate([self.rows, self.columns[off]])
        columns = np.concatenate([self.columns, self.rows[off]])
        entries = np.concatenate([self.entries, sign * self.entries[off]])
        order = np.lexsort((columns, rows))
        given = self.triangle or "one"
        return Matrix(self.size, rows[order], columns[order], entries[order], completed=given)

    def converted(self, units: str, lengths: Array) -> Matrix:
        """Return the matrix in SI units, by those of the degrees of freedom in m.

        Shapes: lengths (n,).
        """
        length, mass = UNITS[units]
        factor = mass * length**2  # of energies, with time in s
        entries = self.entries * factor / (lengths[self.rows] * lengths[self.columns])
        terms = tuple((text, one.converted(units, lengths)) for text, one in self.terms)
        return replace(self, entries=entries, units=units, terms=terms)

    @cached_property
    def asymmetry(self) -> tuple[float, int, int]:
        """Largest difference between mirrored entries over the largest entry, and where it is."""
        return self.mirrored_difference(1.0)

    @property
    def symmetric(self) -> bool:
        """Whether the matrix and those that are added to it are symmetric but for rounding."""
        return all(part.asymmetry[0] <= MATRICES.asymmetry for part in self.parts)

    @property
    def parts(self) -> tuple[Matrix, ...]:
        """The constant matrix and those that formulas multiply."""
        return (self, *(matrix for _, matrix in self.terms))

    def mirrored_difference(self, sign: float) -> tuple[float, int, int]:
        """Largest difference of entries from so many times their images, over the largest entry."""
        a = self.array()
        difference = abs(a - sign * a.T)
        row, column = divmod(int(difference.argmax()), self.size)
        largest = np.abs(self.entries).max(initial=0.0)
        size = float(difference[row, column])
        return (size / largest if largest else 0.0), row, column

    def pair(self, row: int, column: int) -> str:
        """Write an entry and its mirror image."""
        entries = self.array()
        if row == column:
            return f"row {row + 1}, column {column + 1} is {entries[row, column]:.6g}, not 0"
        return (
            f"row {row + 1}, column {column + 1} is {entries[row, column]:.6g}, "
            f"row {column + 1}, column {row + 1} is {entries[column, row]:.6g}"
        )


def as_matrix(value: Any, name: str, triangles: str | None = None) -> Matrix:
    """Make a matrix of an array, a SciPy sparse array or a file. Shapes: value (n, n).

    Programs write one triangle, so that of a file is completed; one that somebody typed may be
    complete, as a circulatory stiffness is. A mapping has matrices by the formulas of parameters
    that multiply them.
    """
    if isinstance(value, Matrix):
        return value
    if isinstance(value, Mapping):
        return _sum_of(value, name, triangles)
    filed = isinstance(value, str | Path)
    if filed:
        value = read_matrix(Path(value), name)
    matrix = _of_entries(value, name)
    if triangles == "whole" or name == "H" or not matrix.one_sided:
        return matrix
    if triangles == "symmetric" or (filed and matrix.triangle):
        return matrix.mirrored(-1.0 if name == "G" else 1.0)
    _, row, column = matrix.asymmetry
    raise InputError(
        f"{name} has one entry of each mirrored pair only: {matrix.pair(row, column)}; give "
        'triangles = "symmetric" if this is one triangle of a symmetric matrix, or triangles = '
        '"whole" if the matrix is complete'
    )


def _sum_of(given: Mapping[Any, Any], name: str, triangles: str | None) -> Matrix:
    """Return the sum of matrices that formulas multiply; constant ones are added up."""
    if not given:
        raise InputError(
            f'{name} is an empty mapping; give matrices by formulas, such as {{"omega": G}}'
        )
    parts = {str(key): as_matrix(value, name, triangles) for key, value in given.items()}
    first, *others = sizes = {text: matrix.size for text, matrix in parts.items()}
    for text in others:
        if sizes[text] != sizes[first]:
            raise InputError(
                f"{name} has {sizes[text]} rows where {text} multiplies it and {sizes[first]} "
                f"where {first} does; give matrices of one size"
            )
    constants = {text: factor_value(text, {}) for text in parts if not factor_names(text)}
    constant = sum((value * parts[text].array() for text, value in constants.items()), 0.0)
    terms = tuple((text, matrix) for text, matrix in parts.items() if text not in constants)
    if not constants:
        none = np.empty(0, dtype=np.int64)
        return Matrix(sizes[first], none, none, np.empty(0), terms=terms)
    return replace(_of_entries(constant, name), terms=terms)


def factor_names(text: str) -> list[str]:
    """Return the names of the parameters in a formula that multiplies a matrix."""
    from slipfold.models.formulas.functions import CONSTANTS
    from slipfold.models.formulas.grammar import FormulaError, names_in, parse_formula

    try:
        return [name for name in names_in(parse_formula(text)) if name not in CONSTANTS]
    except FormulaError as error:
        raise InputError(
            f"{text[:80]!r} cannot multiply a matrix: {error.message}; give a formula of "
            'parameters, such as "omega" or "2*pi*f", or 1 for a constant matrix'
        ) from None


def factor_value(text: str, values: Mapping[str, Expression]) -> Expression:
    """Return the value of a formula that multiplies a matrix, of numbers or symbols."""
    from slipfold.models.formulas.functions import CONSTANTS
    from slipfold.models.formulas.grammar import parse_formula
    from slipfold.models.formulas.values import value_of

    return value_of(parse_formula(text), {**CONSTANTS, **values})


def finite_factor(text: str, values: Mapping[str, float]) -> float:
    """Return the value of a formula that multiplies a matrix; raise where it has no finite one."""
    value = float(factor_value(text, values))
    if not np.isfinite(value):
        places = listed([f"{name} = {values[name]:g}" for name in factor_names(text)])
        raise InputError(
            f"{text!r} multiplies a matrix and has no finite value at {places}, where the error of "
            "a reduction is not known; give another value"
        )
    return value


def require_skew(matrix: Matrix, name: str) -> None:
    """Raise if a matrix and those that are added to it are not skew-symmetric."""
    for one in matrix.parts:
        difference, row, column = one.mirrored_difference(-1.0)
        if difference > MATRICES.asymmetry:
            raise InputError(
                f"{name} is not skew-symmetric: {one.pair(row, column)}; put its symmetric part "
                "into C"
            )


def _of_entries(value: Any, name: str) -> Matrix:
    if hasattr(value, "tocsr"):  # SciPy sparse, whichever of its classes
        _check_shape(value.shape, name)
        sparse = value.tocsr(copy=True)
        sparse.sum_duplicates()  # sorts each row, too
        rows = np.repeat(np.arange(value.shape[0]), np.diff(sparse.indptr))
        columns, entries = sparse.indices.astype(np.int64), _numbers(sparse.data, name)
        size = int(value.shape[0])
    else:
        full = _numbers(value, name)
        _check_shape(full.shape, name)
        rows, columns = np.nonzero(full)
        size, entries = len(full), full[rows, columns]
    finite = np.isfinite(entries)
    if not finite.all():
        bad = int(np.argmin(finite))
        raise InputError(
            f"{name} has the entry {entries[bad]} in row {rows[bad] + 1}, column "
            f"{columns[bad] + 1}; give finite numbers"
        )
    kept = entries != 0
    if not kept.all():
        rows, columns, entries = rows[kept], columns[kept], entries[kept]
    return Matrix(size, rows, columns, entries)


def require_symmetric(matrix: Matrix, name: str, why: str) -> None:
    """Raise if a matrix and those that are added to it are not symmetric."""
    for one in matrix.parts:
        difference, row, column = one.asymmetry
        if difference > MATRICES.asymmetry:
            raise InputError(
                f"{name} is not symmetric: {one.pair(row, column)}, which differ by more than "
                f"{MATRICES.asymmetry:g} of the largest entry; {why}"
            )


def check_mass(matrix: Matrix, names: Sequence[str]) -> None:
    """Raise if a mass matrix is not symmetric and, but for empty rows, positive definite."""
    require_symmetric(matrix, "M", "a mass matrix is, so correct the entries")
    diagonal, massless = matrix.diagonal, matrix.empty
    if len(massless) == matrix.size:
        which = "the constant part of M" if matrix.terms else "M"
        raise InputError(f"{which} is zero; give at least one degree of freedom a mass > 0")
    wrong = diagonal <= 0
    wrong[massless] = False
    if np.any(wrong):
        position = int(np.argmax(wrong))
        raise InputError(
            f"M is not positive definite: the mass of {names[position]} is "
            f"{diagonal[position]:g} kg, and other entries of its row are not zero; give it a "
            "mass > 0, or an empty row, so that it is condensed statically"
        )
    if np.all(matrix.rows == matrix.columns):
        return
    moving = np.setdiff1d(np.arange(matrix.size), massless)
    if not _is_positive(matrix.part(moving), diagonal[moving]):
        raise InputError(
            "M is singular or not positive definite: some displacement has no mass or a negative "
            "one; correct the entries, or condense massless displacements out of the matrices"
        )


def _is_positive(matrix: Matrix, diagonal: Array) -> bool:
    scale = 1 / np.sqrt(diagonal)
    scaled = matrix.entries * scale[matrix.rows] * scale[matrix.columns]
    even = Matrix(matrix.size, matrix.rows, matrix.columns, scaled).array()
    if matrix.size <= MATRICES.dense:
        return bool(np.linalg.eigvalsh(even)[0] > MATRICES.singular)
    return _lowest_value(even) > MATRICES.singular_sparse


def _lowest_value(matrix: Any) -> float:
    """Return the lowest eigenvalue by Lanczos' method.

    With a unit diagonal the eigenvalues of masses of finite elements lie so near each other that
    some products find the lowest; factors of the matrix would fill the memory.
    """
    from scipy.linalg import eigvalsh_tridiagonal

    current = np.random.default_rng(0).normal(size=matrix.shape[0])
    current /= np.linalg.norm(current)
    diagonal, beside, last, size = [], [], np.zeros(0), 0.0
    for _ in range(min(MATRICES.lanczos, len(current))):
        new = matrix @ current
        if size:
            new -= size * last
        diagonal.append(float(current @ new))
        new -= diagonal[-1] * current
        size = float(np.linalg.norm(new))
        beside.append(size)
        if size < MATRICES.rounding:  # these vectors hold the lowest one
            break
        last, current = current, new / size
    return float(eigvalsh_tridiagonal(diagonal, beside[:-1])[0])


def _check_shape(shape: tuple[int, ...], name: str) -> None:
    if len(shape) != 2 or shape[0] != shape[1] or not shape[0]:
        raise InputError(
            f"{name} has the shape {' x '.join(map(str, shape)) or 'of a number'}; give a square "
            "matrix with one row and one column a degree of freedom"
        )


def _numbers(value: Any, name: str) -> Array:
    try:
        numbers = np.asarray(value)
    except ValueError:  # rows of different lengths
        numbers = np.empty(0, dtype=object)
    if numbers.dtype.kind == "c":
        if np.any(numbers.imag):
            raise InputError(
                f"{name} is complex; give a real matrix, and structural damping as viscous or "
                "modal damping"
            )
        numbers = numbers.real
    if numbers.dtype.kind not in "fiub":
        raise InputError(
            f"{name} is not a matrix of numbers but {type(value).__name__}; give an array, a SciPy "
            "sparse array, or the path of a file such as K.mtx"
        )
    return numbers.astype(float)


def is_diagonal(matrix: Array) -> bool:
    """Whether all entries beside the diagonal are zero."""
    return not np.any(matrix - np.diag(np.diag(matrix)))


def lowest_modes(stiffness: Any, mass: Any, count: int | None = None) -> tuple[Array, Array]:
    """Return the lowest undamped modes; displacements without mass follow the others.

    The matrices are symmetric or Hermitian.

    Shapes: stiffness, mass (n, n); returns squares (count,), shapes (n, count).
    """
    moving = np.flatnonzero(abs(mass).sum(axis=1))
    if isinstance(mass, np.ndarray) or count is None or count >= len(moving) - 1:
        full, mass = _full(stiffness), _full(mass)
        if len(moving) == len(mass):
            squares, shapes = _full_modes(full, mass)
        else:
            static = static_shapes(full, moving)
            squares, shapes = _full_modes(full[moving] @ static, mass[np.ix_(moving, moving)])
            shapes = static @ shapes
    else:
        squares, shapes = _sparse_modes(stiffness, mass, count)
    squares, shapes = squares[:count], shapes[:, :count]
    # One sign and size for every mode, so that the same matrices give the same equations.
    largest = np.abs(shapes).argmax(axis=0)
    return squares, shapes / shapes[largest, np.arange(shapes.shape[1])]


def frequencies_of(squares: Array) -> Array:
    """Return frequencies in Hz by squared circular ones, zero for negative ones."""
    return np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)


def solver(matrix: Any, what: str) -> Callable[[Array], Array]:
    """Return a function that solves linear equations with a matrix. Shapes: matrix (n, n)."""
    if isinstance(matrix, np.ndarray):
        scale = 1 / np.sqrt(np.maximum(np.abs(np.diag(matrix)), np.finfo(float).tiny))
        if matrix.size and np.linalg.cond(matrix * scale[:, None] * scale) > MATRICES.condition:
            raise InputError(what)
        return lambda right: np.asarray(np.linalg.solve(matrix, right))
    from scipy.sparse.linalg import splu

    try:
        factors = splu(matrix.tocsc())
    except RuntimeError:
        raise InputError(what) from None
    return lambda right: np.asarray(factors.solve(right))


def static_shapes(stiffness: Array, moving: Indices) -> Array:
    """Return all displacements by those of some degrees of freedom, on which alone forces act.

    Shapes: stiffness (n, n); returns (n, len(moving)).
    """
    rest = np.setdiff1d(np.arange(len(stiffness)), moving)
    shapes = np.zeros((len(stiffness), len(moving)), dtype=stiffness.dtype)
    shapes[moving, np.arange(len(moving))] = 1.0
    if len(rest):
        solve = solver(
            stiffness[np.ix_(rest, rest)],
            "degrees of freedom without mass can move without force, so that no static solution "
            "gives their displacements; give them a mass or a stiffness",
        )
        shapes[rest] = -solve(stiffness[np.ix_(rest, moving)])
    return shapes


def _full(matrix: Any) -> Array:
    return matrix if isinstance(matrix, np.ndarray) else matrix.toarray()


def _full_modes(stiffness: Array, mass: Array) -> tuple[Array, Array]:
    # To standard form by the Cholesky factor of the mass: M = G G^H.
    factor = np.linalg.cholesky((mass + mass.conj().T) / 2)
    half = np.linalg.solve(factor, (stiffness + stiffness.conj().T) / 2)
    standard = np.linalg.solve(factor, half.conj().T)
    squares, vectors = np.linalg.eigh((standard + standard.conj().T) / 2)
    return squares, np.linalg.solve(factor.conj().T, vectors)


def _sparse_modes(stiffness: Any, mass: Any, count: int) -> tuple[Array, Array]:
    stiffness, mass = stiffness.tocsc(), mass.tocsc()
    shift = MATRICES.shift * abs(stiffness.diagonal()).sum() / abs(mass.diagonal()).sum()
    squares, shapes = _modes_from(shift, stiffness, mass, count)
    if squares[0] > 100 * shift:
        return squares, shapes
    # Rigid-body modes, or a fine mesh: the shift follows the modes, so that they stand apart.
    return _modes_from(max(1e-2 * squares[-1], shift), stiffness, mass, count)


def _modes_from(shift: float, stiffness: Any, mass: Any, count: int) -> tuple[Array, Array]:
    """Return the lowest modes by Lanczos's method, with all of equal frequency.

    From one start it finds a single mode of each frequency, and others by rounding only. What is
    orthogonal to the modes found is searched until none below them is left.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh, splu

    solve, size = splu((stiffness + shift * mass).tocsc()).solve, mass.shape[0]
    others = np.count_nonzero(abs(mass).sum(axis=1)) - count
    squares, shapes = np.empty(0), np.empty((size, 0), dtype=stiffness.dtype)
    random = np.random.default_rng(0)  # in which equal parts move differently

    def without_known(forces: Array) -> Array:
        answer = solve(forces)
        return np.asarray(answer - shapes @ (shapes.conj().T @ (mass @ answer)))

    inverse = LinearOperator((size, size), without_known, dtype=stiffness.dtype)
    while True:
        wanted = min(MATRICES.missed, others) if len(squares) else count
        start = random.standard_normal(size).astype(stiffness.dtype)
        more, found = eigsh(stiffness, wanted, mass, sigma=-shift, OPinv=inverse, v0=start)
        # One of equal frequency that is left out is found again with another rounding
        complete = len(squares) > 0 and more.min() >= squares[-1] * (1 - MATRICES.equal)
        order = np.argsort(np.append(squares, more))[:count]
        squares, found = np.append(squares, more)[order], np.hstack([shapes, found])[:, order]
        factor = np.linalg.cholesky(found.conj().T @ (mass @ found))
        shapes = np.linalg.solve(factor, found.conj().T).conj().T
        if complete:
            return squares, shapes
