"""Perturbed linear algebra is LAPACK's by every rule that holds, and nothing that is free stays."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

from portable.perturbed_kernels import EPS, perturbed

SEEDS = range(5)
ROUNDED = 100 * EPS


def randoms(seed, shape, kind):
    random = np.random.default_rng(seed)
    matrix = random.normal(size=shape)
    return matrix + 1j * random.normal(size=shape) if kind is complex else matrix


def of_rank(seed, shape, rank, kind):
    """A stack of matrices with singular values 2, 1, 1, ..., 1, 0, ..., 0."""
    *stack, m, n = shape
    left = np.linalg.qr(randoms(seed, (*stack, m, m), kind))[0][..., :rank]
    right = np.linalg.qr(randoms(seed + 1, (*stack, n, n), kind))[0][..., :rank, :]
    return left * [2.0, 1.0, 1.0, 1.0][:rank] @ right


def adjoint(matrix):
    return np.swapaxes(matrix, -1, -2).conj()


def assert_orthonormal(rows):
    assert np.abs(rows @ adjoint(rows) - np.eye(rows.shape[-2])).max(initial=0) < ROUNDED


shapes = st.tuples(st.integers(1, 2), st.integers(1, 5), st.integers(1, 5))
kinds = st.sampled_from([float, complex])
seeds = st.integers(0, 1000)


@given(seeds, shapes, kinds, st.booleans(), st.integers(0, 4))
def test_singular_vectors_are_those_of_the_matrix(seed, shape, kind, full, rank):
    matrix = of_rank(seed, shape, min(rank, *shape[1:]), kind)
    plain = np.linalg.svd(matrix, full_matrices=full)
    with perturbed(seed):
        left, values, right = np.linalg.svd(matrix, full_matrices=full)
    assert [part.shape for part in plain] == [left.shape, values.shape, right.shape]
    assert np.abs(values - plain.S).max() < ROUNDED
    count = values.shape[-1]
    again = left[..., :count] * values[..., None, :] @ right[..., :count, :]
    assert np.abs(again - matrix).max() < ROUNDED
    assert_orthonormal(right)
    assert_orthonormal(adjoint(left))


@given(seeds, st.integers(1, 6), kinds)
def test_eigenvectors_are_those_of_the_matrix(seed, n, kind):
    basis = np.linalg.qr(randoms(seed, (n, n), kind))[0]
    matrix = basis * np.array([2.0, 1, 1, -1, -1, 0.5])[:n] @ adjoint(basis)
    general = randoms(seed, (2, n, n), kind)
    with perturbed(seed):
        symmetric, vectors = np.linalg.eigh(matrix)
        assert np.abs(vectors * symmetric @ adjoint(vectors) - matrix).max() < ROUNDED
        assert_orthonormal(adjoint(vectors))
        for each in (matrix, general):
            values, vectors = np.linalg.eig(each)
            assert np.abs(each @ vectors - vectors * values[..., None, :]).max() < 5 * ROUNDED
            assert np.linalg.norm(vectors, axis=-2) == pytest.approx(1)
            if kind is float:
                for row in np.atleast_2d(values):
                    first = np.flatnonzero(row.imag > 0)
                    assert (row[first + 1] == row[first].conj()).all()


@given(seeds, shapes, kinds, st.sampled_from(["reduced", "complete"]))
def test_factors_of_qr_are_those_of_the_matrix(seed, shape, kind, mode):
    matrix = randoms(seed, shape, kind)
    with perturbed(seed):
        left, right = np.linalg.qr(matrix, mode)
        assert np.abs(np.linalg.qr(matrix, "r")) == pytest.approx(
            np.abs(np.linalg.qr(matrix)[1]), abs=ROUNDED
        )
    assert np.abs(left @ right - matrix).max() < ROUNDED
    assert (np.tril(right, -1) == 0).all()
    assert_orthonormal(adjoint(left))


def differ(function):
    """How far the plain answer and those for some seeds are apart, each from each."""
    answers = [function()]
    for seed in SEEDS:
        with perturbed(seed):
            answers.append(function())
    return [np.abs(a - b).max() for i, a in enumerate(answers) for b in answers[:i]]


def test_what_is_free_is_chosen_anew_by_each_seed():
    matrix = of_rank(3, (5, 5), 3, float)
    symmetric = adjoint(matrix) @ matrix
    assert np.median(differ(lambda: np.linalg.svd(matrix)[2][1:3])) > 1e-2  # equal ones
    assert np.median(differ(lambda: np.linalg.svd(matrix)[2][3:])) > 1e-2  # null vectors
    assert np.median(differ(lambda: np.linalg.svd(matrix)[0][:, 3:])) > 1e-2
    assert np.median(differ(lambda: np.linalg.eigh(symmetric)[1][:, :2])) > 1e-2
    assert np.median(differ(lambda: np.linalg.eig(symmetric)[1])) > 1e-2
    assert np.median(differ(lambda: np.linalg.qr(matrix[:, :2], "complete")[0][:, 2:])) > 1e-2
    assert np.median(differ(lambda: np.linalg.qr(matrix)[0])) > 1e-2  # signs
    assert np.median(differ(lambda: np.linalg.eigvals(matrix))) > 1e-2  # the order


SQUARE = randoms(1, (4, 4), float)


@pytest.mark.parametrize(
    "function",
    [
        lambda: np.linalg.solve(SQUARE, np.ones(4)),
        lambda: np.linalg.inv(SQUARE),
        lambda: np.linalg.pinv(SQUARE),
        lambda: np.linalg.det(SQUARE),
        lambda: np.linalg.slogdet(SQUARE)[1],
        lambda: np.linalg.cholesky(SQUARE @ SQUARE.T),
        lambda: np.linalg.lstsq(SQUARE[:, :2], np.ones(4))[0],
        lambda: np.linalg.svd(SQUARE, compute_uv=False),
        lambda: np.sort(np.linalg.eigvals(SQUARE)),
        lambda: scipy.linalg.expm(SQUARE),
        lambda: scipy.linalg.lu_factor(SQUARE)[0],
        lambda: scipy.linalg.lu_solve(LU, np.ones(4)),
        lambda: scipy.sparse.linalg.splu(scipy.sparse.csc_array(SQUARE)).solve(np.ones(4)),
    ],
)
def test_last_digits_differ(function):
    apart = differ(function)
    assert max(apart) > 0
    assert max(apart) < 1e3 * EPS  # SQUARE is well conditioned


LU = scipy.linalg.lu_factor(SQUARE)


def test_a_run_is_perturbed_if_its_option_says_so(pytestconfig):
    replaced = np.linalg.svd is not np.linalg._linalg.svd
    assert replaced == (pytestconfig.getoption("perturb_kernels") is not None)
