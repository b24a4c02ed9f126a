"""The systems of collocation's stages by the modes of what all derivatives share."""

import numpy as np
import pytest

from slipfold.collocation.points import gauss_points, radau_points
from slipfold.orbits.discretisations.stage_equations import Inverted, LinearPart

INTERVALS, STAGES, STATES = 4, 6, 14


def jacobians(generator, columns):
    common = generator.normal(size=(STATES, STATES))
    found = np.tile(common, (INTERVALS, STAGES, 1, 1))
    shape = (INTERVALS, STAGES, STATES, len(columns))
    found[..., columns] += generator.normal(size=shape)
    return found


@pytest.mark.parametrize("points", [gauss_points(STAGES), radau_points(STAGES)])
@pytest.mark.parametrize("columns", [[], [3], [3, 8]])
def test_modes_answer_as_the_whole_inverse_does(points, columns):
    generator = np.random.default_rng(len(columns))
    lengths = generator.uniform(0.05, 0.2, INTERVALS)
    linear, slopes = LinearPart(), jacobians(generator, columns)
    linear.equations(points, lengths, slopes)
    # The same at another period, by the modes that are known.
    found = linear.equations(points, lengths, 1.7 * slopes)
    whole = Inverted.of(points, lengths, 1.7 * slopes)
    assert not isinstance(found, Inverted)
    right = generator.normal(size=(INTERVALS, STAGES, STATES, 2))
    assert found.solve(right) == pytest.approx(whole.solve(right), abs=1e-11)
    assert found.moved == pytest.approx(whole.moved, abs=1e-11)
    assert found.last_moved == pytest.approx(whole.last_moved, abs=1e-11)
    changes = generator.normal(size=(INTERVALS, STATES))
    assert found.along(changes) == pytest.approx(whole.along(changes), abs=1e-11)


def test_columns_that_begin_to_change_are_taken_up():
    generator = np.random.default_rng(5)
    points, lengths = radau_points(STAGES), np.full(INTERVALS, 0.1)
    linear, slopes = LinearPart(), jacobians(generator, [])
    linear.equations(points, lengths, slopes)
    slopes[1, 2, :, 6] += 1.0
    found = linear.equations(points, lengths, slopes)
    assert not isinstance(found, Inverted)
    whole = Inverted.of(points, lengths, slopes)
    assert found.moved == pytest.approx(whole.moved, abs=1e-11)


@pytest.mark.parametrize("changed", [STATES, 4])
def test_where_much_changes_the_whole_is_inverted(changed):
    generator = np.random.default_rng(6)
    slopes = jacobians(generator, list(range(changed)))
    lengths = np.full(INTERVALS, 0.1)
    assert isinstance(LinearPart().equations(radau_points(STAGES), lengths, slopes), Inverted)


def test_eigenvectors_that_coincide_are_not_used():
    chain = np.eye(STATES, k=1)
    slopes = np.tile(chain, (INTERVALS, STAGES, 1, 1))
    lengths = np.full(INTERVALS, 0.1)
    assert isinstance(LinearPart().equations(radau_points(STAGES), lengths, slopes), Inverted)
