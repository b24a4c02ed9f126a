"""The bordered Jacobian solved by elimination against the whole matrix."""

import numpy as np
import pytest

from slipfold.orbits.linearisation import Conditions, Eliminated, Linearisation
from slipfold.orbits.sparse_matrix import Sparse


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
