"""The systems of collocation's stages by the modes of what all derivatives share."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.collocation_points import gauss_points, radau_points
from slipfold.flow import flow_of
from slipfold.flow.stage_equations import Inverted, Jacobians, LinearPart

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
    linear.equations(points, lengths, Jacobians.of(slopes))
    # The same at another period, by the modes that are known.
    found = linear.equations(points, lengths, Jacobians.of(1.7 * slopes))
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
    linear.equations(points, lengths, Jacobians.of(slopes))
    slopes[1, 2, :, 6] += 1.0
    found = linear.equations(points, lengths, Jacobians.of(slopes))
    assert not isinstance(found, Inverted)
    whole = Inverted.of(points, lengths, slopes)
    assert found.moved == pytest.approx(whole.moved, abs=1e-11)


@pytest.mark.parametrize("changed", [STATES, 4])
def test_where_much_changes_the_whole_is_inverted(changed):
    generator = np.random.default_rng(6)
    slopes = jacobians(generator, list(range(changed)))
    lengths = np.full(INTERVALS, 0.1)
    assert isinstance(
        LinearPart().equations(radau_points(STAGES), lengths, Jacobians.of(slopes)), Inverted
    )


def test_eigenvectors_that_coincide_are_not_used():
    chain = np.eye(STATES, k=1)
    slopes = np.tile(chain, (INTERVALS, STAGES, 1, 1))
    lengths = np.full(INTERVALS, 0.1)
    assert isinstance(
        LinearPart().equations(radau_points(STAGES), lengths, Jacobians.of(slopes)), Inverted
    )


def test_columns_that_change_and_what_is_common_make_the_whole():
    generator = np.random.default_rng(8)
    whole = jacobians(generator, [3, 8])
    some = Jacobians(whole[0, 0], np.array([3, 8, 9]), whole[..., [3, 8, 9]])
    vectors = generator.normal(size=(INTERVALS, STAGES, STATES))
    assert (some.whole == whole).all()
    assert some.changed.tolist() == [3, 8]
    assert some.times(vectors) == pytest.approx(np.einsum("jkab,jkb->jka", whole, vectors))


def test_of_a_large_structure_only_what_changes_is_evaluated_everywhere():
    generator = np.random.default_rng(9)
    contact = sf.FrictionContact("q7", sf.Stribeck(), load=2.0, Vd=1.0)
    model = sf.Structure(
        np.eye(7),
        sf.ProportionalDamping(0.1, 0.001),
        2 * np.eye(7) - np.eye(7, k=1) - np.eye(7, k=-1),
        elements=sf.CubicSpring("q2", k3=10.0),
        contacts=contact,
        forcing=sf.HarmonicForce("q1", F=2.0),
        f=0.6,
    )
    flow = flow_of(model)
    states, phases = generator.normal(size=(5, 14)), np.linspace(0, 1, 5)
    given = states, phases, flow.constants_of(model)
    first, columns, found = flow.changing_jacobians(*given)
    whole = flow.jacobians(*given)
    assert [model.states[i].name for i in columns] == ["q2", "vq7"]
    assert (found == whole[..., columns]).all()
    assert (first == whole[0]).all()
    assert (np.delete(whole, columns, axis=2) == np.delete(first, columns, axis=1)).all()
