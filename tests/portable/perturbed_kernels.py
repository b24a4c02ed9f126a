"""Linear algebra that answers as another processor's LAPACK might.

LAPACK promises factors of a matrix a few units in the last place away from the one it is given. It
promises no basis of a null space or of the vectors of equal values, no sign or phase of a vector,
and no order of eigenvalues. Here each of these is chosen at random: a function of the seed and of
the matrix alone, so that the same question has the same answer, in any order and in any stack.
"""

import zlib
from collections import Counter
from contextlib import ExitStack, contextmanager
from functools import wraps

import numpy as np
import scipy.linalg
import scipy.sparse.linalg

ULPS = 2
"""Every element of a matrix is off by up to so many rounding units."""
EQUAL = 2
"""Values of an n by n matrix A are equal within so many n eps |A|, which is less than LAPACK's
error bound."""
PARALLEL = 1e-3
"""Eigenvectors with a singular value below this are those of a defective matrix: no basis."""

EPS = np.finfo(float).eps


class Perturbed:
    """NumPy's and SciPy's functions as called, with answers that differ by the seed."""

    def __init__(self, seed):
        self.salt = np.uint64(zlib.crc32(str(seed).encode()))
        self.counts = Counter()

    def off(self, matrix):
        """The matrix with each element off by up to ULPS; zero stays zero."""
        matrix = np.array(matrix, dtype=complex if np.iscomplexobj(matrix) else float, order="C")
        numbers = matrix.view(float)
        place = np.arange(np.prod(numbers.shape[-2:], dtype=int), dtype=np.uint64)
        place = place.reshape(numbers.shape[-2:])
        return (numbers * (1 + ULPS * EPS * self.random(numbers, place))).view(matrix.dtype)

    def random(self, numbers, place):
        """Random numbers between -1 and 1, the same for the same number at the same place."""
        bits = numbers.view(np.uint64) + (place + self.salt) * np.uint64(0x9E3779B97F4A7C15)
        bits = (bits ^ (bits >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return (bits >> np.uint64(11)) / 2.0**52 - 1

    def generator(self, matrix):
        return np.random.default_rng([int(self.salt), zlib.crc32(matrix.tobytes())])

    def off_first(self, function):
        """What LAPACK solves is a matrix a few units in the last place away."""

        @wraps(function)
        def answer(matrix, *more, **options):
            return function(self.off(matrix), *more, **options)

        return answer

    def off_sparse(self, function):
        @wraps(function)
        def answer(matrix, *more, **options):
            matrix = matrix.copy()
            matrix.data = self.off(matrix.data[None])[0]
            return function(matrix, *more, **options)

        return answer

    def unordered(self, function):
        """Eigenvalues in any order, but that conjugate ones of a real matrix stay together."""

        @wraps(function)
        def eigvals(matrix, *more, **options):
            matrix = self.off(matrix)
            values = function(matrix, *more, **options)
            number = np.arange(values.shape[-1], dtype=np.uint64)
            keys = self.random(np.ascontiguousarray(values.real), number)
            if np.isrealobj(matrix):
                second = values.imag[..., 1:] < 0
                keys[..., 1:][second] = keys[..., :-1][second]
            return np.take_along_axis(values, keys.argsort(axis=-1, kind="stable"), axis=-1)

        return eigvals

    def eig(self, function):
        @wraps(function)
        def eig(matrix):
            matrix = self.off(matrix)
            values, vectors = answer = function(matrix)
            values, vectors = values.copy(), vectors.copy()
            for i in np.ndindex(matrix.shape[:-2]):
                values[i], vectors[i] = self._turned(matrix[i], values[i], vectors[i])
            return type(answer)(values, vectors)

        return eig

    def _turned(self, matrix, values, vectors):
        random = self.generator(matrix)
        paired = np.isrealobj(matrix) and np.iscomplexobj(values)
        first = [i for i in range(len(values)) if not (paired and values[i].imag < 0)]
        first = random.permutation(first).astype(int)
        near = EQUAL * len(matrix) * EPS * np.linalg.norm(matrix, 1)
        left = list(first)
        while left:
            real = paired and values[left[0]].imag == 0
            same = [
                i
                for i in left
                if abs(values[i] - values[left[0]]) <= near
                and (paired and values[i].imag == 0) == real
            ]
            left = [i for i in left if i not in same]
            basis = vectors[:, same]
            if len(same) > 1 and SVD(basis)[1][-1] < PARALLEL:
                continue
            self.counts["equal eigenvalues"] += len(same) > 1
            turn = orthogonal(random, len(same), np.iscomplexobj(values) and not real)
            basis = basis @ turn
            vectors[:, same] = basis / np.linalg.norm(basis, axis=0)
        order = []
        for i in first:
            order += [i]
            if paired and values[i].imag > 0:
                order += [i + 1]
                vectors[:, i + 1] = vectors[:, i].conj()
        return values[order], vectors[:, order]

    def eigh(self, function):
        @wraps(function)
        def eigh(matrix, *more, **options):
            matrix = self.off(matrix)
            answer = function(matrix, *more, **options)
            if options.get("eigvals_only"):
                return answer
            values, vectors = answer[0], answer[1].copy()
            for i in np.ndindex(matrix.shape[:-2]):
                random = self.generator(matrix[i])
                for same in self._runs(values[i], "equal eigenvalues", len(matrix[i])):
                    vectors[i][:, same] @= orthogonal(random, len(same), np.iscomplexobj(vectors))
            return (values, vectors) if type(answer) is tuple else type(answer)(values, vectors)

        return eigh

    def svd(self, function):
        @wraps(function)
        def svd(matrix, full_matrices=True, compute_uv=True):
            matrix = self.off(matrix)
            if not compute_uv:
                return function(matrix, compute_uv=False)
            # Null vectors beside those that are requested are as good.
            left, values, right = answer = function(matrix)
            left, right = left.copy(), right.copy()
            for i in np.ndindex(matrix.shape[:-2]):
                self._turned_pairs(matrix[i], left[i], values[i], right[i])
            if not full_matrices:
                left, right = left[..., : values.shape[-1]], right[..., : values.shape[-1], :]
            return type(answer)(left, values, right)

        return svd

    def _turned_pairs(self, matrix, left, values, right):
        random, kind = self.generator(matrix), np.iscomplexobj(matrix)
        near = EQUAL * max(matrix.shape) * EPS * max(values, default=0.0)
        rank = int((values > near).sum())
        for same in self._runs(values[:rank], "equal singular values", max(matrix.shape)):
            turn = orthogonal(random, len(same), kind)
            left[:, same] = left[:, same] @ turn
            right[same] = turn.conj().T @ right[same]
        for basis in (left.T, right):
            count = len(basis) - rank
            self.counts["null space"] += count > 1
            basis[rank:] = orthogonal(random, count, kind) @ basis[rank:]

    def _runs(self, values, name, size):
        """Places of equal ones among values in order."""
        near = EQUAL * size * EPS * np.abs(values).max(initial=0.0)
        start = 0
        for i in range(1, len(values) + 1):
            if i == len(values) or abs(values[i] - values[start]) > near:
                self.counts[name] += i - start > 1
                yield list(range(start, i))
                start = i

    def qr(self, function):
        @wraps(function)
        def qr(matrix, mode="reduced"):
            matrix = self.off(matrix)
            if mode == "r":
                return qr(matrix)[1]
            left, right = answer = function(matrix, mode)
            left, right = left.copy(), right.copy()
            for i in np.ndindex(matrix.shape[:-2]):
                random, kind = self.generator(matrix[i]), np.iscomplexobj(matrix)
                rank = min(matrix.shape[-2:])
                signs = np.array([orthogonal(random, 1, kind)[0, 0] for _ in range(rank)])
                left[i][:, :rank] *= signs
                right[i][:rank] *= signs.conj()[:, None]
                rest = left[i].shape[1] - rank
                self.counts["null space"] += rest > 1
                left[i][:, rank:] @= orthogonal(random, rest, kind)
            return type(answer)(left, right)

        return qr

    def eigsh(self, function):
        """Lanczos iteration: its factors are `splu`'s, the signs of its vectors are free."""

        @wraps(function)
        def eigsh(matrix, *more, **options):
            values, vectors = function(matrix, *more, **options)
            return values, vectors * np.sign(self.generator(values).normal(size=len(values)))

        return eigsh

    def lu_solve(self, function):
        """The solution with factors that are off."""

        @wraps(function)
        def lu_solve(factors, *more, **options):
            return function((self.off(factors[0]), factors[1]), *more, **options)

        return lu_solve

    def replaced(self):
        """Module, name and wrapper of each function that the project or its tests call."""
        numpy = np.linalg
        yield from ((numpy, name, self.off_first) for name in SOLVERS)
        yield from ((numpy, name, getattr(self, name)) for name in ("svd", "eig", "eigh", "qr"))
        yield numpy, "eigvals", self.unordered
        yield from ((scipy.linalg, name, self.off_first) for name in SCIPY)
        yield scipy.linalg, "eigh", self.eigh
        yield scipy.linalg, "eigvals", self.unordered
        yield scipy.linalg, "lu_solve", self.lu_solve
        yield scipy.sparse.linalg, "splu", self.off_sparse
        yield scipy.sparse.linalg, "eigsh", self.eigsh


SOLVERS = (
    *("solve", "inv", "pinv", "det", "slogdet", "cholesky", "lstsq"),
    *("cond", "matrix_rank", "svdvals", "eigvalsh"),
)
SCIPY = ("expm", "lu_factor", "solve_discrete_lyapunov")


def orthogonal(random, count, unitary=False):
    """A random orthogonal or unitary matrix: for one vector a sign or a phase."""
    matrix = random.normal(size=(count, count))
    if unitary:
        matrix = matrix + 1j * random.normal(size=(count, count))
    if count == 1:
        return matrix / np.abs(matrix)
    return QR(matrix)[0] * np.where(random.random(count) < 0.5, -1, 1)


QR, SVD = np.linalg.qr, np.linalg.svd


@contextmanager
def perturbed(seed):
    """Replace the functions for a while; yields how often a basis could be chosen."""
    kernels = Perturbed(seed)
    with ExitStack() as stack:
        for module, name, wrapper in kernels.replaced():
            function = getattr(module, name)
            stack.callback(setattr, module, name, function)
            setattr(module, name, wrapper(function))
        yield kernels.counts
