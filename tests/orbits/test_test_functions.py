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


@pytest.mark.parametrize("multiplier", [4.0, -4.0])
def test_nothing_happens_where_the_determinant_compared_with_vanishes(multiplier):
    others = [0.2, 0.1]
    before, at, after = (
        evaluate_tests(np.array([scale * multiplier, *others])) for scale in (1 - 1e-7, 1, 1 + 1e-7)
    )
    for name in before:
        assert before[name] == pytest.approx(at[name], abs=1e-6)
        assert after[name] == pytest.approx(at[name], abs=1e-6)


def test_multipliers_well_inside_the_circle_turn_the_functions_less_than_the_determinants():
    radii = np.linspace(0.1, 0.7, 10)
    found, alone = [], []
    for turn in np.linspace(0, 2 * np.pi, 50):
        upper = radii * np.exp(1j * (turn * np.arange(1, 11) + 0.3))
        values = np.concatenate([upper, upper.conj()])
        first, second = np.triu_indices(20, k=1)
        found.append(list(evaluate_tests(values).values()))
        products = [-values, values, values[first] * values[second]]
        alone.append([(1 - item).prod().real for item in products])
    varied, before = np.ptp(np.log(found), axis=0), np.ptp(np.log(alone), axis=0)
    assert np.all(varied < before)


def test_small_multipliers_change_the_functions_by_three_quarters_of_what_they_do_alone():
    """To first order: log (1 - p) is -p, and that of (1 - p / 4) is -p / 4."""
    radius = 1e-5
    values = radius * np.exp(1j * np.array([0.4, -0.4, 1.3, -1.3]))
    angle = np.arcsin(evaluate_tests(values)["fold"])
    slope = np.log(np.tan(angle)) / values.sum().real
    assert slope == pytest.approx(-0.75, abs=radius)


def test_huge_multipliers_do_not_overflow():
    tests = evaluate_tests(np.full(20, 1e100 + 0j))
    assert all(0.9 < abs(value) <= 1 for value in tests.values())


def test_many_sets_of_multipliers_are_ordered_as_each_alone():
    matrices = np.random.default_rng(3).normal(size=(20, 5, 5))
    together = floquet_multipliers(matrices)
    assert together.tolist() == [floquet_multipliers(item).tolist() for item in matrices]
    assert floquet_multipliers(np.zeros((2, 3, 3))).tolist() == [[0, 0, 0]] * 2
