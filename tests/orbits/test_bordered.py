"""The bordered Jacobian solved by elimination against the whole matrix."""

import numpy as np
import pytest

from slipfold.orbits.linearisation import Conditions, Eliminated, Linearisation, Sparse


@pytest.mark.parametrize(
    ("m", "n", "k"),
    [(8, 4, 1), (8, 3, 3), (1, 3, 1), (16, 5, 1), (16, 9, 1), (8, 20, 1), (3, 2, 2)],
)
def test_elimination_gives_what_the_whole_matrix_gives(m, n, k):
    generator = np.random.default_rng(m + n + k)
    size = m * n + k
    gradients = generator.normal(size=(k - 1, size)) if k > 1 else None
    linearisation = Linearisation(
        generator.normal(size=(m, n)),
        generator.normal(size=(m, n, n)) / np.sqrt(n),
        generator.normal(size=(m, n, k)),
        Conditions(generator.normal(size=k - 1), gradients),
    )
    right = generator.normal(size=size)
    row = generator.normal(size=size)
    for bordered in (Eliminated(linearisation, row), linearisation.bordered(row)):
        assert_like_the_whole(bordered, right)
        assert np.array_equal(bordered.matrix, np.vstack([linearisation.jacobian, row]))


def assert_like_the_whole(bordered, right):
    size = len(right)
    assert bordered.solve(right) == pytest.approx(
        np.linalg.solve(bordered.matrix, right), rel=1e-9, abs=1e-11
    )
    assert bordered.solve_transposed(right) == pytest.approx(
        np.linalg.solve(bordered.matrix.T, right), rel=1e-9, abs=1e-11
    )
    last = np.linalg.solve(bordered.matrix, np.eye(size)[-1])
    assert bordered.tangent() == pytest.approx(last / np.linalg.norm(last), abs=1e-11)
    sign, logarithm = np.linalg.slogdet(bordered.matrix)
    assert bordered.sign == sign
    assert bordered.volume == pytest.approx(logarithm + np.log(np.linalg.norm(last)), abs=1e-10)


def test_a_singular_matrix_gives_nan():
    linearisation = Linearisation(np.zeros((2, 1)), np.ones((2, 1, 1)), np.zeros((2, 1, 1)))
    for bordered in (linearisation.bordered(np.zeros(3)), Eliminated(linearisation, np.zeros(3))):
        assert np.isnan(bordered.solve(np.ones(3))).all()


@pytest.mark.parametrize(("size", "kind"), [(0.5, Eliminated), (2.0, Sparse)])
def test_along_a_mesh_what_grows_is_not_eliminated(size, kind):
    m, n = 40, 10
    blocks = np.tile(size * np.eye(n), (m, 1, 1))
    linearisation = Linearisation(np.zeros((m, n)), blocks, np.ones((m, n, 1)))
    assert type(linearisation.bordered(np.ones(m * n + 1))) is kind


def test_factors_of_a_mesh_stay_thin_whatever_grows_on_it():
    m, n, k = 200, 2, 2
    random = np.random.default_rng(0)
    growth = np.exp(np.where(np.arange(m) < m // 2, 3.0, -3.0) * random.random(m))
    turned = np.linalg.qr(np.eye(n) + 0.1 * random.normal(size=(m, n, n)))[0]
    ratios = np.stack([growth, np.ones(m)], axis=1)
    blocks = turned @ (ratios[:, :, None] * turned.transpose(0, 2, 1))
    along = random.normal(size=(m, n, k))
    bordered = Sparse(blocks, along, random.normal(size=(k, m * n + k)) / np.sqrt(m * n))
    # Blocks of n by 2 n, and full columns and rows of k, before and after elimination.
    factors = bordered._factors
    assert factors.L.nnz + factors.U.nnz < 2 * m * n * (3 * n + 2 * k)
    right = random.normal(size=m * n + k)
    assert bordered.matrix @ bordered.solve(right) == pytest.approx(right, abs=1e-9)
    assert bordered.matrix.T @ bordered.solve_transposed(right) == pytest.approx(right, abs=1e-9)
    sign, logarithm = np.linalg.slogdet(bordered.matrix)
    length = np.linalg.norm(bordered.solve(np.eye(m * n + k)[-1]))
    assert bordered.sign == sign
    assert bordered.volume == pytest.approx(logarithm + np.log(length), abs=1e-9)
