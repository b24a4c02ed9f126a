"""How far a matrix is from a bifurcation: zero there, smooth through it, with its derivative."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import block_diag

from slipfold.orbits.test_functions import degeneracy

KINDS = ("LP", "PD", "NS")


def similar(rng, *blocks):
    """A matrix with these diagonal blocks, in coordinates that are not orthogonal."""
    diagonal = block_diag(*blocks)
    n = len(diagonal)
    basis = np.linalg.qr(rng.normal(size=(n, n)))[0] * np.exp(rng.uniform(-1, 1, n))
    basis = basis @ np.linalg.qr(rng.normal(size=(n, n)))[0]
    return basis @ diagonal @ np.linalg.inv(basis)


def rotation(angle, radius=1.0):
    return radius * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def others(rng, count, largest):
    """Multipliers well away from the circle, one of them large."""
    values = rng.uniform(0.1, 0.7, count) * rng.choice([-1, 1], count)
    if count and largest > 1:
        values[0] = largest * rng.choice([-1, 1])
    return [np.array([[value]]) for value in values]


def critical_block(kind, angle):
    if kind == "NS":
        return rotation(angle)
    return np.array([[1.0 if kind == "LP" else -1.0]])


SEEDS = st.integers(0, 2**32 - 1)
SIZES = st.integers(2, 6)
LARGEST = st.sampled_from([0.0, 3.0, 1e2, 1e5])
ANGLES = st.floats(0.05, np.pi - 0.05)


def relative_gap(found, expected):
    return abs(found - expected) / (1 + abs(expected))


@pytest.mark.parametrize("kind", KINDS)
@given(seed=SEEDS, n=SIZES, largest=LARGEST, angle=ANGLES)
def test_zero_at_the_bifurcation_with_its_derivative(kind, seed, n, largest, angle):
    rng = np.random.default_rng(seed)
    block = critical_block(kind, angle)
    rest, state = others(rng, n - len(block), largest), rng.bit_generator.state
    assert abs(degeneracy(kind, similar(rng, block, *rest)).value) < 1e-12
    # A little beside it: there the sign of the number is not that of a rounding error.
    rng.bit_generator.state = state
    matrix = similar(rng, block * (1 + 1e-6), *rest)
    found = degeneracy(kind, matrix)
    # A change of the matrix as large as the matrix would change the number by order one.
    change = rng.normal(size=(n, n)) * np.linalg.norm(matrix) / n
    slope = np.einsum("ra,ab,rb->", found.left, change, found.right)
    estimates = [
        (degeneracy(kind, matrix + h * change).value - degeneracy(kind, matrix - h * change).value)
        / (2 * h)
        for h in (2e-7, 1e-7)
    ]
    assert relative_gap((4 * estimates[1] - estimates[0]) / 3, slope) < 1e-4


@pytest.mark.parametrize("kind", KINDS)
@given(seed=SEEDS, n=SIZES, angle=ANGLES)
def test_smooth_through_zero(kind, seed, n, angle):
    rng = np.random.default_rng(seed)
    rest, turn = others(rng, n - (2 if kind == "NS" else 1), 3.0), rng.normal(size=(n, n))
    basis = np.linalg.qr(turn)[0]

    def value(shift):
        block = critical_block(kind, angle) * (1 + shift)
        return degeneracy(kind, basis @ block_diag(block, *rest) @ basis.T).value

    shifts = np.linspace(-0.02, 0.02, 9)
    values = np.array([value(shift) for shift in shifts])
    signs = np.sign(values[[0, -1]])
    assert signs[0] == -signs[1] != 0
    # A polynomial through some is right at the others, on either side: no corner at zero.
    fit = np.polynomial.Polynomial.fit(shifts[::2], values[::2], 4)
    assert fit(shifts[1::2]) == pytest.approx(values[1::2], abs=1e-7)


@pytest.mark.parametrize("kind", ["LP", "PD"])
@given(seed=SEEDS, n=st.integers(2, 6))
def test_sign_is_that_of_the_determinant(kind, seed, n):
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(n, n))
    shifted = matrix + (-1 if kind == "LP" else 1) * np.eye(n)
    found = degeneracy(kind, matrix)
    assert np.sign(found.value) == np.sign(np.linalg.det(shifted))
    size = np.sqrt(1 + np.linalg.norm(matrix) ** 2)
    assert abs(found.value) == pytest.approx(np.linalg.svdvals(shifted)[-1] / size, rel=1e-9)


# -- torus: two multipliers at once ------------------------------------------------------------


def companion(trace, determinant):
    return np.array([[trace, -determinant], [1.0, 0.0]])


@given(seed=SEEDS, n=SIZES, largest=LARGEST, target=st.sampled_from([1.0, -1.0]))
def test_torus_is_smooth_where_the_pair_meets_on_the_real_axis(seed, n, largest, target):
    # The determinant of the pair's block alone decides, whether its multipliers are complex or
    # real: at R1 and R2 they meet.
    rng = np.random.default_rng(seed)
    rest = others(rng, n - 2, largest)
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    for offset in (-3e-2, -1e-4, -1e-8, 0.0, 1e-8, 1e-4, 3e-2):
        for excess in (-1e-3, 0.0, 1e-3):
            block = companion(2 * target + offset, 1 + excess)
            matrix = turn @ block_diag(block, *rest) @ turn.T
            found = degeneracy("NS", matrix)
            size = np.sqrt(1 + np.linalg.norm(matrix) ** 2)
            # Of a large matrix the entries are known to 1e-16 of the largest.
            assert found.value == pytest.approx(excess / size, abs=1e-11)
