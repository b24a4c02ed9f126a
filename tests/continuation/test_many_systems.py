"""Newton's method for many systems of equations side by side."""

import numpy as np
import pytest

from slipfold.newton import Rule, correct_many, solve_each


def roots_of(targets):
    """Steps towards the positive roots of z^2 = target."""

    def steps(some, z):
        return solve_each(2 * z[:, :, None], targets[some, None] - z**2)

    return steps


def test_each_system_is_solved_as_if_it_were_alone():
    targets, guesses = np.array([1.0, 2.0, 300.0, 5.0]), np.array([[1.1], [1.4], [17.0], [2.0]])
    rule = Rule(close=1e-6)
    together = correct_many(roots_of(targets), guesses, rule)
    assert together.z.ravel() == pytest.approx(np.sqrt(targets), rel=1e-14)
    for i in range(len(targets)):
        alone = correct_many(roots_of(targets[[i]]), guesses[[i]], rule)
        assert alone.z[0] == together.z[i]
        assert alone.moved[0] == together.moved[i]


def test_what_is_lost_says_why_and_keeps_nobody_waiting():
    targets = np.array([2.0, 2.0, 2.0, -1.0])
    guesses = np.array([[1.4], [0.0], [np.nan], [0.3]])
    asked = []

    def steps(some, z):
        asked.append(some.tolist())
        return roots_of(targets)(some, z)

    found = correct_many(steps, guesses, Rule(close=1e-6, longest=2.0))
    assert found.found.tolist() == [True, False, False, False]
    assert list(found.failures[1:3]) == ["Newton's method diverged", "no guess"]
    assert asked[0] == [0, 1, 3]
    assert asked[-1] != asked[0]
    assert np.isnan(found.z[1:]).all()
    assert np.isinf(found.moved[1:]).all()


def test_derivatives_that_are_not_renewed_are_reckoned_with():
    """Where each step leaves 0.3 of the distance, a short one does not mean that it is over."""

    def steps(some, z):
        return -0.7 * z

    guess = np.array([[1e-3]])
    hasty = correct_many(steps, guess, Rule(close=1e-6, iterations=30))
    sure = correct_many(steps, guess, Rule(close=1e-6, remaining=1e-12, iterations=30))
    assert abs(hasty.z[0, 0]) > 1e-8
    assert abs(sure.z[0, 0]) < 2e-12


def test_a_singular_system_takes_none_of_the_others_with_it():
    matrices = np.array([np.eye(2), np.zeros((2, 2)), 2 * np.eye(2)])
    right = np.ones((3, 2))
    solved = solve_each(matrices, right)
    assert solved[[0, 2]] == pytest.approx(np.array([[1.0, 1.0], [0.5, 0.5]]), rel=4e-15)
    assert np.isnan(solved[1]).all()
    assert solve_each(matrices, np.ones((3, 2, 3))).shape == (3, 2, 3)
