"""Test functions against determinants of the monodromy matrix itself."""

import numpy as np
import pytest

from slipfold.orbits.test_functions import evaluate_tests, floquet_multipliers


def bialternate(matrix):
    """M (.) M by its minors, which need no eigenvalue (Kuznetsov, section 10.2)."""
    first, second = np.triu_indices(len(matrix), k=1)
    rows, columns = matrix[first], matrix[second]
    return rows[:, first] * columns[:, second] - rows[:, second] * columns[:, first]


@pytest.mark.parametrize("n", [2, 3, 4, 7])
@pytest.mark.parametrize("size", [0.3, 1.0, 30.0])
def test_signs_are_those_of_the_determinants(n, size):
    generator = np.random.default_rng(n)
    for matrix in size * generator.standard_normal((50, n, n)) / np.sqrt(n):
        tests = evaluate_tests(floquet_multipliers(matrix))
        identity, pairs = np.eye(n), bialternate(matrix)
        expected = {
            "PD": np.linalg.det(identity + matrix),
            "fold": np.linalg.det(identity - matrix),
            "NS": np.linalg.det(np.eye(len(pairs)) - pairs),
        }
        assert {name: np.sign(value) for name, value in tests.items()} == {
            name: np.sign(value) for name, value in expected.items()
        }
        assert max(map(abs, tests.values())) <= 1


@pytest.mark.parametrize(("name", "at"), [("PD", -1.0), ("fold", 1.0)])
def test_a_multiplier_that_crosses_the_circle_changes_one_sign_only(name, at):
    for others in ([0.3], [0.5 + 0.6j, 0.5 - 0.6j, 7.0]):
        inside, on, outside = (
            evaluate_tests(np.array([scale * at, *others])) for scale in (1 - 1e-9, 1.0, 1 + 1e-9)
        )
        assert on[name] == 0
        assert inside[name] * outside[name] < 0
        assert abs(inside[name] + outside[name]) < 1e-6 * abs(inside[name])


def test_a_pair_that_crosses_the_circle_changes_the_sign_of_the_function_of_tori():
    inside, outside = (
        evaluate_tests(radius * np.exp([0.7j, -0.7j]))["NS"] for radius in (1 - 1e-9, 1 + 1e-9)
    )
    assert inside > 0 > outside


def test_huge_multipliers_do_not_overflow():
    tests = evaluate_tests(np.full(20, 1e100 + 0j))
    assert all(0.9 < abs(value) <= 1 for value in tests.values())
