"""Jacobians of few segments, from which all nodes but the first are eliminated."""

import numpy as np
import pytest

from slipfold.orbits.linearization import Condensed, Linearization, Sparse


@pytest.mark.parametrize(("m", "n", "k"), [(8, 10, 1), (8, 9, 3), (3, 5, 2), (2, 7, 1)])
def test_it_is_the_whole_matrix(m, n, k):
    rng = np.random.default_rng(m * n)
    blocks, along = rng.normal(size=(m, n, n)) / np.sqrt(n), rng.normal(size=(m, n, k))
    lines, right = rng.normal(size=(k, m * n + k)), rng.normal(size=m * n + k)
    found = Condensed(blocks, along, lines, Condensed.reach(blocks, along))
    whole = Sparse(blocks, along, lines).matrix
    bound = 1e-12 * np.linalg.cond(whole)
    np.testing.assert_allclose(whole @ found.solve(right), right, atol=bound)
    np.testing.assert_allclose(whole.T @ found.solve_transposed(right), right, atol=bound)
    sign, logarithm = np.linalg.slogdet(whole)
    assert found.sign == sign
    kernel = np.linalg.solve(whole, np.eye(m * n + k)[-1])
    assert found.volume == pytest.approx(logarithm + np.log(np.linalg.norm(kernel)), abs=1e-9)
    np.testing.assert_allclose(found.tangent(), kernel / np.linalg.norm(kernel), atol=bound)


def test_growth_is_left_to_pivots():
    assert Condensed.reach(np.full((8, 2, 2), 10.0), np.zeros((8, 2, 1))) is None


def test_one_segment_is_a_full_matrix_however_large():
    # Its transition matrix and the identity lie in one place: a sparse matrix had both.
    rng = np.random.default_rng(5)
    blocks, along = rng.normal(size=(1, 70, 70)) / 20, rng.normal(size=(1, 70, 1))
    part = Linearization(np.zeros((1, 70)), blocks, along)
    tangent = part.bordered(np.eye(71)[-1]).tangent()
    assert np.abs(part.jacobian @ tangent).max() < 1e-12
    assert abs(tangent[-1]) > 0.01
