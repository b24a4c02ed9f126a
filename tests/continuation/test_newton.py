"""Newton's method where little or nothing is left to do."""

from types import SimpleNamespace

import numpy as np
import pytest

from slipfold.continuation.newton import correct


class Circle:
    """Points of the unit circle, followed by its angle."""

    def defect(self, z):
        return np.array([(z @ z - 1) / 2])

    def linearise(self, z):
        matrix = np.array([z])

        def bordered(row):
            whole = np.vstack([matrix, row])
            return SimpleNamespace(solve=lambda right: np.linalg.solve(whole, right))

        return SimpleNamespace(defect=self.defect(z), is_finite=True, bordered=bordered)

    def residual(self, defect):
        return float(abs(defect[0]))


@pytest.mark.parametrize("off", [0.0, 1e-200, 1e-17, 1e-9, 1e-3])
def test_a_guess_that_is_exact_is_the_solution(off):
    # Its derivatives are expected, so that the first steps are chord steps: of length zero.
    circle, guess = Circle(), np.array([1.0, 0.0])
    beside, row = np.array([1.0 + off, 0.0]), np.array([0.0, 1.0])
    found = correct(circle, beside, row, expected=circle.linearise(guess))
    assert found.converged, found.failure
    assert found.z == pytest.approx(guess, abs=1e-15)


def test_expected_derivatives_of_an_exact_guess_are_divided_by_nothing():
    """Found where a branch of two masses came to a point twice."""
    circle = Circle()
    flat = SimpleNamespace(solve=lambda right: 0.0 * right)  # no step, whatever is left
    expected = SimpleNamespace(bordered=lambda row: flat)
    with np.errstate(all="raise"):
        found = correct(circle, np.array([1.0, 0.1]), np.array([0.0, 1.0]), expected=expected)
    assert found.converged, found.failure
    assert found.z[0] == pytest.approx(np.sqrt(0.99), abs=1e-14)
