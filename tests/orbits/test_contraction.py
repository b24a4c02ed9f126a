"""The bound of multipliers: never below them, exact where coefficients are constant."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from slipfold.orbits.multipliers import growth_bound


@given(seed=st.integers(0, 10**6), size=st.integers(1, 6), segments=st.integers(1, 8))
def test_no_multiplier_exceeds_the_bound(seed, size, segments):
    blocks = np.random.default_rng(seed).normal(size=(segments, size, size)) / np.sqrt(size)
    product = np.linalg.multi_dot([*blocks[::-1], np.eye(size), np.eye(size)])
    largest = np.abs(np.linalg.eigvals(product)).max()
    assert np.log(largest) <= growth_bound(blocks) + 1e-8


@given(seed=st.integers(0, 10**6))
def test_it_is_exact_for_constant_coefficients_however_fast_they_turn(seed):
    rng = np.random.default_rng(seed)
    rates, turns = rng.uniform(0.01, 0.5, 3), rng.uniform(1, 100, 3)
    basis = rng.normal(size=(6, 6)) + 3 * np.eye(6)
    blocks = [np.array([[-d, w], [-w, -d]]) for d, w in zip(rates, turns, strict=True)]
    matrix = np.zeros((6, 6))
    for place, block in enumerate(blocks):
        matrix[2 * place : 2 * place + 2, 2 * place : 2 * place + 2] = block
    segment = expm(basis @ matrix @ np.linalg.inv(basis))
    assert growth_bound(np.array([segment] * 8)) == pytest.approx(-8 * rates.min(), abs=1e-6)


def test_singular_and_missing_derivatives_bound_nothing():
    assert growth_bound(np.full((2, 3, 3), np.nan)) == np.inf
    # A nilpotent mean has no basis of eigenvectors to speak of.
    jordan = np.array([[0.0, 1.0], [0.0, 0.0]])
    assert growth_bound(np.array([jordan, jordan])) >= -np.inf
