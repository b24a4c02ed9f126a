"""Matrices of a structure: from arrays and files, checked, compared by content; their modes."""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.parametric import Parametric, described, structural
from slipfold.models.quantities import Parameter, nonnegative
from slipfold.models.units import parse_quantity
from slipfold.text import listed


def read_matrix(path: Path, name: str) -> Any:
    """Read one matrix from a file."""
    ending = "".join(path.suffixes[-2:]).lower() if path.suffix == ".gz" else path.suffix.lower()
    if ending not in _READERS:
        raise InputError(
            f"{path} ends in {ending or 'nothing'}, which is not known for matrices; give a file "
            f"that ends in {', '.join(_READERS)}"
        )
    if not path.is_file():
        raise InputError(
            f"{path} does not exist or is not a file; give the path of a matrix {name}"
        )
    try:
        content = _READERS[ending](path)
        return content[_chosen(content, path, name)] if isinstance(content, dict) else content
    except InputError:
        raise
    except NotImplementedError as error:
        raise InputError(
            f"{path} is a MATLAB file of version 7.3, which cannot be read; save it in MATLAB with "
            "the option -v7"
        ) from error
    # Damaged files make the readers fail in many ways; a message says more than a traceback.
    except Exception as error:
        why = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise InputError(
            f"{path} cannot be read as a {ending} file ({why}); save the matrix {name} again"
        ) from error


def _read_npz(path: Path) -> Any:
    # NumPy leaves a file that it opened and cannot read open.
    with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
        if "format" in archive.files:
            from scipy.sparse import load_npz

            return load_npz(path)
        return dict(archive)


def _read_mat(path: Path) -> Any:
    from scipy.io import loadmat

    return {name: value for name, value in loadmat(path).items() if not name.startswith("__")}


def _read_market(path: Path) -> Any:
    from scipy.io import mmread

    return mmread(path)


_READERS: dict[str, Callable[[Path], Any]] = {
    ".npz": _read_npz,
    ".npy": partial(np.load, allow_pickle=False),
    ".mat": _read_mat,
    ".mtx": _read_market,
    ".mtx.gz": _read_market,
}


def _chosen(names: Collection[str], path: Path, name: str) -> str:
    """Return the name of the matrix among the variables of a file."""
    if len(names) == 1:
        return next(iter(names))
    long_name = {"M": "mass", "C": "damping", "K": "stiffness"}.get(name, name)
    lowered = {item.lower(): item for item in names}
    for wanted in (name, name.lower(), long_name, lowered.get(long_name, "")):
        if wanted in names:
            return wanted
    raise InputError(
        f"{path} holds no {name}, but {listed(names) or 'nothing'}; call the matrix {name} or "
        f"{long_name} there, or give the array itself"
    )


@dataclass(frozen=True)
class MatrixSettings:
    """Bounds of size, symmetry, regularity and rounding of matrices."""

    dense: int = 600  # largest size at which full arrays are used; beyond it sparse ones
    modal: int = 80  # largest size of equations with modes, which take longer to compile
    # Difference between an entry and its mirror image, over the largest entry, that is rounding
    asymmetry: float = 1e-9
    # Size of entries of the inverse mass times a matrix, over the largest in the row, likewise
    rounding: float = 1e-15
    # Smallest eigenvalue of a mass matrix with unit diagonal at which it is regular
    singular: float = 1e-13
    # Shift of the search for sparse modes, over a typical squared frequency: with it the matrix to
    # factor is regular though rigid-body modes have no stiffness
    shift: float = 1e-12
    # Ratio of the largest squared frequency to the smallest at which rounding errors matter
    wide: float = 1e5
    # Frequency over the largest one below which a motion is free: it has no relative error
    free: float = 1e-6


MATRICES = MatrixSettings()


@dataclass(frozen=True)
class Matrix:
    """A square matrix by its entries that are not zero; immutable, hashed by content."""

    size: int  # number of rows n
    # Places of the entries, row by row, shape (nonzeros,)
    rows: NDArray[np.int64] = field(compare=False)
    columns: NDArray[np.int64] = field(compare=False)
    entries: Array = field(compare=False)  # their values in SI units, shape (nonzeros,)
    digest: bytes = field(init=False, repr=False)

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

    @property
    def one_sided(self) -> bool:
        """Whether there are entries off the diagonal, none of them with a mirror image."""
        off = self.rows != self.columns
        rows, columns = self.rows[off], self.columns[off]
        mirrored = np.isin(columns * self.size + rows, rows * self.size + columns)
        return len(rows) > 0 and not mirrored.any()

    def mirrored(self) -> Matrix:
        """Return the symmetric matrix of which this is one half, the diagonal included."""
        off = self.rows != self.columns
        rows = np.concatenate([self.rows, self.columns[off]])
        columns = np.concatenate([self.columns, self.rows[off]])
        entries = np.concatenate([self.entries, self.entries[off]])
        order = np.lexsort((columns, rows))
        return Matrix(self.size, rows[order], columns[order], entries[order])

    @property
    def asymmetry(self) -> tuple[float, int, int]:
        """Largest difference between mirrored entries over the largest entry, and where it is."""
        a = self.array()
        difference = abs(a - a.T)
        position = int(difference.argmax())
        row, column = divmod(position, self.size)
        largest = np.abs(self.entries).max(initial=0.0)
        size = float(difference[row, column])
        return (size / largest if largest else 0.0), row, column


def as_matrix(value: Any, name: str, triangles: str | None = None) -> Matrix:
    """Make a matrix of an array, a SciPy sparse array or a file. Shapes: value (n, n)."""
    if isinstance(value, Matrix):
        return value
    if isinstance(value, str | Path):
        value = read_matrix(Path(value), name)
    if hasattr(value, "tocoo"):  # SciPy sparse, whichever of its classes
        sparse = value.tocoo(copy=True)
        shape: tuple[int, ...] = sparse.shape
        _check_shape(shape, name)
        sparse.sum_duplicates()
        rows, columns = (np.asarray(part, dtype=np.int64) for part in (sparse.row, sparse.col))
        entries = _numbers(sparse.data, name)
    else:
        full = _numbers(value, name)
        _check_shape(full.shape, name)
        rows, columns = np.nonzero(full)
        shape, entries = full.shape, full[rows, columns]
    finite = np.isfinite(entries)
    if not finite.all():
        bad = int(np.argmin(finite))
        raise InputError(
            f"{name} has the entry {entries[bad]} in row {rows[bad] + 1}, column "
            f"{columns[bad] + 1}; give finite numbers"
        )
    kept = np.flatnonzero(entries)
    order = kept[np.lexsort((columns[kept], rows[kept]))]
    matrix = Matrix(shape[0], rows[order], columns[order], entries[order])
    if triangles == "whole" or not matrix.one_sided:
        return matrix
    if triangles == "symmetric":
        return matrix.mirrored()
    _, row, column = matrix.asymmetry
    shown = matrix.array()
    raise InputError(
        f"{name} has one entry of each mirrored pair only: row {row + 1}, column {column + 1} is "
        f"{shown[row, column]:.6g}, row {column + 1}, column {row + 1} is "
        f'{shown[column, row]:.6g}; give triangles = "symmetric" if this is one triangle of a '
        'symmetric matrix, or triangles = "whole" if the matrix is complete'
    )


def require_symmetric(matrix: Matrix, name: str, why: str) -> None:
    """Raise if a matrix is not symmetric."""
    difference, row, column = matrix.asymmetry
    if difference > MATRICES.asymmetry:
        entries = matrix.array()
        raise InputError(
            f"{name} is not symmetric: row {row + 1}, column {column + 1} is "
            f"{entries[row, column]:.6g}, its mirror image {entries[column, row]:.6g}; {why}"
        )


def check_mass(matrix: Matrix, names: tuple[str, ...]) -> None:
    """Raise if a mass matrix is not symmetric and positive definite."""
    require_symmetric(matrix, "M", "a mass matrix is, so correct the entries")
    diagonal = np.zeros(matrix.size)
    on = matrix.rows == matrix.columns
    diagonal[matrix.rows[on]] = matrix.entries[on]
    if np.any(diagonal <= 0):
        position = int(np.argmax(diagonal <= 0))
        raise InputError(
            f"M is singular or not positive definite: the mass of {names[position]} is "
            f"{diagonal[position]:g} kg; give every degree of freedom a mass > 0, or condense "
            "those without out of the matrices"
        )
    if np.all(on):
        return
    if not _is_positive(matrix, diagonal):
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
    from scipy.sparse.linalg import splu

    try:
        # Without pivoting the signs of U's diagonal are those of the eigenvalues.
        factors = splu(
            even.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError:  # exactly singular
        return False
    return bool(factors.U.diagonal().min() > MATRICES.singular)


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
            "sparse array, or the path of a .npz, .npy, .mat or Matrix Market file"
        )
    return numbers.astype(float)


@dataclass(frozen=True)
class Damping(Parametric, ABC):
    """A rule that makes a damping matrix of mass and stiffness."""

    title: ClassVar[str] = "damping"

    @abstractmethod
    def _terms(self, mass: Array, stiffness: Array) -> tuple[tuple[str | None, Array], ...]:
        """Return the parts of the damping matrix with the parameter that multiplies each."""


@dataclass(frozen=True)
class ProportionalDamping(Damping):
    r"""Rayleigh damping: :math:`C = \alpha_M M + \beta_K K`.

    A mode of the frequency :math:`\omega` has the damping ratio :math:`\tfrac12 (\alpha_M/\omega +
    \beta_K \omega)`.

    Examples
    --------
    >>> ProportionalDamping(beta_K=1e-4).values
    {'alpha_M': 0.0, 'beta_K': 0.0001}
    """

    title: ClassVar[str] = "proportional damping"

    alpha_M: float = described(
        nonnegative("alpha_M", 0.0, "1/s", "damping over mass", r"$\alpha_M$")
    )
    beta_K: float = described(
        nonnegative("beta_K", 0.0, "s", "damping over stiffness", r"$\beta_K$")
    )

    def _terms(self, mass: Array, stiffness: Array) -> tuple[tuple[str | None, Array], ...]:
        """Mass and stiffness."""
        return (("alpha_M", mass), ("beta_K", stiffness))


_RATIO = nonnegative("zeta", 0.01, "", "damping ratio of all modes", r"$\zeta$")


def _checked_ratios(ratios: Any, title: str) -> float | tuple[float, ...]:
    several = isinstance(ratios, list | tuple | np.ndarray)
    checked = tuple(
        _RATIO.check(parse_quantity(item, "", f"damping ratio {position}"))
        for position, item in enumerate(ratios if several else [ratios], 1)
    )
    return checked if several else checked[0]


@dataclass(frozen=True)
class ModalDamping(Damping):
    r"""Damping by the ratios of the modes, with modes of unit modal mass.

    .. math::

        C = M \Bigl(\sum_i 2 \zeta_i \omega_i \phi_i \phi_i^T\Bigr) M

    Examples
    --------
    >>> ModalDamping(0.01).values
    {'zeta': 0.01}
    """

    title: ClassVar[str] = "modal damping"

    ratios: Any = structural(
        "one damping ratio for all modes, which becomes the parameter ``zeta``; or one a mode, "
        "lowest first, shape (n,)",
        read=_checked_ratios,
    )

    def _pairs(self) -> Iterator[tuple[Parameter, float]]:
        if not isinstance(self.ratios, tuple):
            yield _RATIO, self.ratios

    @property
    def kind(self) -> Self:
        """The damping with the default ratio if it is one for all modes."""
        return self if isinstance(self.ratios, tuple) else replace(self, ratios=0.01)

    def _terms(self, mass: Array, stiffness: Array) -> tuple[tuple[str | None, Array], ...]:
        """Return the damping matrix, for a ratio of 1 if it is one for all modes."""
        size = len(mass)
        single = not isinstance(self.ratios, tuple)
        if not single and len(self.ratios) != size:
            raise InputError(
                f"{len(self.ratios)} damping ratios are given for {size} modes; give one a mode, "
                "or one for all"
            )
        if _is_diagonal(mass) and _is_diagonal(stiffness):
            # Each coordinate is a mode; the matrix stays diagonal to the last digit.
            squares = np.diag(stiffness) / np.diag(mass)
            ratios = np.ones(size) if single else np.empty(size)
            if not single:
                ratios[np.argsort(squares, kind="stable")] = self.ratios
            matrix = np.diag(2 * ratios * np.sqrt(np.maximum(squares, 0)) * np.diag(mass))
            return (("zeta" if single else None, matrix),)
        squares, shapes = lowest_modes(stiffness, mass)
        moved = mass @ shapes
        modal = np.sum(shapes * moved, axis=0)
        ratios = np.ones(size) if single else np.array(self.ratios)
        weights = 2 * ratios * np.sqrt(np.maximum(squares, 0)) / modal
        return (("zeta" if single else None, (moved * weights) @ moved.T),)


def _is_diagonal(matrix: Array) -> bool:
    return not np.any(matrix - np.diag(np.diag(matrix)))


def lowest_modes(stiffness: Any, mass: Any, count: int | None = None) -> tuple[Array, Array]:
    """Return the lowest undamped modes.

    Shapes: stiffness, mass (n, n); returns squares (count,), shapes (n, count).
    """
    size = mass.shape[0]
    if isinstance(mass, np.ndarray):
        squares, shapes = _full_modes(stiffness, mass)
    elif count is None or count >= size - 1:
        squares, shapes = _full_modes(stiffness.toarray(), mass.toarray())
    else:
        squares, shapes = _sparse_modes(stiffness, mass, count)
    squares, shapes = squares[:count], shapes[:, :count]
    # One sign and size for every mode, so that the same matrices give the same equations.
    largest = np.abs(shapes).argmax(axis=0)
    return squares, shapes / shapes[largest, np.arange(shapes.shape[1])]


def solver(matrix: Any, what: str) -> Callable[[Array], Array]:
    """Return a function that solves linear equations with a matrix. Shapes: matrix (n, n)."""
    if isinstance(matrix, np.ndarray):
        if matrix.size and np.linalg.cond(matrix) > 1e14:
            raise InputError(what)
        return lambda right: np.asarray(np.linalg.solve(matrix, right), dtype=float)
    from scipy.sparse.linalg import splu

    try:
        factors = splu(matrix.tocsc())
    except RuntimeError:
        raise InputError(what) from None
    return lambda right: np.asarray(factors.solve(right))


def _full_modes(stiffness: Array, mass: Array) -> tuple[Array, Array]:
    # To standard form by the Cholesky factor of the mass: M = G G^T.
    factor = np.linalg.cholesky((mass + mass.T) / 2)
    half = np.linalg.solve(factor, (stiffness + stiffness.T) / 2)
    standard = np.linalg.solve(factor, half.T)
    squares, vectors = np.linalg.eigh((standard + standard.T) / 2)
    return squares, np.linalg.solve(factor.T, vectors)


def _sparse_modes(stiffness: Any, mass: Any, count: int) -> tuple[Array, Array]:
    from scipy.sparse.linalg import eigsh

    def modes_from(shift: float) -> tuple[Array, Array]:
        start = np.ones(mass.shape[0])
        squares, shapes = eigsh(stiffness, count, mass, sigma=-shift, which="LM", v0=start)
        order = np.argsort(squares)
        return squares[order], shapes[:, order]

    stiffness, mass = stiffness.tocsc(), mass.tocsc()
    shift = MATRICES.shift * abs(stiffness.diagonal()).sum() / mass.diagonal().sum()
    squares, shapes = modes_from(shift)
    if squares[0] > 100 * shift:
        return squares, shapes
    # Rigid-body modes, or a fine mesh: the shift follows the modes, so that they stand apart.
    return modes_from(max(1e-2 * squares[-1], shift))
