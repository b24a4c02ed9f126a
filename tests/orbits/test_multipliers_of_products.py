"""Eigenvalues of products whose moduli span more than the precision."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag

from slipfold.orbits.linearization import Conditions, Linearization
from slipfold.orbits.multipliers import CycleMultipliers, cycle_multipliers, product_eigenvalues
from slipfold.orbits.test_functions import degeneracy


def factors_of(blocks, count, seed):
    """Factors with the given diagonal blocks in bases that turn from one to the next."""
    rng = np.random.default_rng(seed)
    n = sum(len(block) for block in blocks)
    bases = [np.linalg.qr(rng.normal(size=(n, n)))[0] for _ in range(count)]
    result = []
    for j in range(count):
        matrix = block_diag(*blocks)
        owner = np.repeat(np.arange(len(blocks)), [len(block) for block in blocks])
        above = owner[:, None] < owner[None, :]
        matrix[above] = rng.normal(size=above.sum())
        result.append(bases[(j + 1) % count] @ matrix @ bases[j].T)
    return np.array(result)


def test_small_multipliers_keep_their_digits():
    values = np.array([3.0, 1.2, 0.5, 0.04])
    factors = factors_of([np.array([[value]]) for value in values], 24, 1)
    found = product_eigenvalues(factors)
    assert found.imag == pytest.approx(0)
    assert np.log(found.real) == pytest.approx(24 * np.log(values), rel=1e-11)
    plain = np.linalg.eigvals(np.linalg.multi_dot(factors[::-1]))
    assert abs(np.abs(plain).min() / values[-1] ** 24 - 1) > 1  # what the product itself gives


@pytest.mark.parametrize("angle", [0.1, 1.0, 3.0])
def test_pairs_keep_modulus_and_angle(angle):
    def turn(size):
        return size * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    found = product_eigenvalues(factors_of([turn(1.1), np.array([[0.7]]), turn(0.2)], 16, 2))
    moduli = np.array([1.1, 1.1, 0.7, 0.2, 0.2]) ** 16
    assert np.abs(found) == pytest.approx(moduli, rel=1e-10, abs=0)
    exact = np.exp(16j * angle)
    for value in found[[0, 3]]:
        unit = value / abs(value)
        assert min(abs(unit - exact), abs(unit - exact.conjugate())) < 1e-9


def test_the_largest_that_is_a_number_comes_first():
    found = product_eigenvalues(np.array(3 * [[[1e102, 1.0], [0.0, 0.5]]]))
    assert found[0] == pytest.approx(1e306)


def test_a_singular_factor_gives_a_zero():
    factors = factors_of([np.array([[1.5]]), np.array([[0.8]])], 8, 3)
    factors[3] = np.outer(factors[3][:, 0], [1.0, 0.5])
    found = product_eigenvalues(factors)
    assert abs(found[1]) < 1e-15
    assert np.isfinite(found).all()


def test_a_double_multiplier_of_a_cycle_keeps_its_digits():
    # Where another multiplier meets the trivial one the matrix is defective.
    rng = np.random.default_rng(4)
    count = 12
    bases = [np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(count)]
    inner = [np.triu(rng.normal(size=(3, 3)), 1) + np.diag([1.0, 1.0, 0.3])] * count
    matrices = np.array([bases[(j + 1) % count] @ inner[j] @ bases[j].T for j in range(count)])
    rates = np.array([basis[:, 0] for basis in bases])
    trivial, others = cycle_multipliers(matrices, rates)
    assert trivial == pytest.approx(1, abs=1e-13)
    assert others == pytest.approx([1.0, 0.3**12], rel=1e-12, abs=0)
    assert np.abs(np.linalg.eigvals(np.linalg.multi_dot(matrices[::-1])) - 1).min() > 1e-10


BLOCKS = [np.array([[6.0]]), np.array([[0.99]]), np.array([[0.97]]), np.array([[0.16]])]
"""Two neighboring moduli beside a large and a small one."""


@pytest.mark.parametrize("seed", range(6))
def test_neighboring_moduli_are_not_separated_by_few_sweeps(seed):
    found = product_eigenvalues(factors_of(BLOCKS, 8, seed))
    exact = np.array([6.0, 0.99, 0.97, 0.16]) ** 8
    assert np.abs(found) == pytest.approx(exact, rel=1e-11, abs=0)


def test_sweeps_end_where_only_rounding_is_left(monkeypatch):
    # A factor of condition 1e7 leaves more rounding, about 1e-8, than counts as invariant.
    factors, scale = factors_of(BLOCKS, 8, 1), np.diag([1.0, 1.0, 1.0, 1e-7])
    factors[3], factors[4] = np.linalg.inv(scale) @ factors[3], factors[4] @ scale
    calls, plain = [], np.linalg.qr
    monkeypatch.setattr(np.linalg, "qr", lambda matrix: calls.append(1) or plain(matrix))
    found = product_eigenvalues(factors)
    assert len(calls) <= 6 * len(factors)  # a few sweeps, not sixty
    assert np.abs(found) == pytest.approx(np.array([6.0, 0.99, 0.97, 0.16]) ** 8, rel=1e-7, abs=0)


def test_a_round_begins_where_perturbations_leave_the_digits():
    # Of 16 nodes in a plane beside the flow, at the first the eigenvectors are nearly parallel.
    turns = np.exp(1j * np.arange(1, 17))
    bases = np.array([[turns.real, -turns.imag], [turns.imag, turns.real]]).transpose(2, 0, 1)
    bases[:2] = bases[:2] @ [[[1, 1], [0, 1e-4]], [[1, 1], [0, 0.1]]]
    step = np.diag([1e4 ** (1 / 16), 1])
    blocks = np.tile(np.eye(3), (16, 1, 1))
    blocks[:, 1:, 1:] = np.roll(bases, -1, axis=0) @ step @ np.linalg.inv(bases)
    rates = np.append(np.tile([1.0, 0, 0], 16), [0, 0])
    conditions = Conditions(np.zeros(1), rates[None])
    part = Linearization(np.zeros((16, 3)), blocks, np.zeros((16, 3, 2)), conditions)

    first = CycleMultipliers()
    other = first.better(part)
    # Rounding moves the smaller eigenvalue by its part of the norm, over the angle between vectors.
    assert np.linalg.norm(other.matrix(part)) < 0.02 * np.linalg.norm(first.matrix(part))
    values = np.linalg.eigvals(other.matrix(part))
    assert sorted(values.real) == pytest.approx([1, 1e4], abs=1e-6, rel=1e-12)
    assert other.better(part) is None
    found = degeneracy("LP", other.matrix(part))
    before, behind, _ = other.propagated(found, part)
    # A change of any segment changes the function as differences say, wherever the round begins.
    for j in (0, 1, 9):
        ends, behind_it, before_it = [], behind[0, j, 1:], before[0, j, 1:]
        steepest = np.linalg.norm(behind_it) * np.linalg.norm(before_it)
        for change in (1e-4, -1e-4):
            changed = blocks.copy()
            changed[j, 1:, 1:] += change / steepest * np.outer(behind_it, before_it)
            matrix = other.matrix(replace(part, blocks=changed))
            ends.append(degeneracy("LP", matrix).value)
        assert (ends[0] - ends[1]) / 2e-4 == pytest.approx(steepest, rel=1e-2), j
