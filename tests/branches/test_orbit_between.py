"""Orbits of a branch between its points."""

from dataclasses import replace

import numpy as np
import pytest

import slipfold as sf
from slipfold.bifurcations.branches.orbit_between import orbit_between, orbits_at, passes


@pytest.fixture(scope="module")
def known():
    return sf.response(sf.SlidingOscillator(), "Nd", (0, 0.9), f=12.5)


def test_an_orbit_between_points_closes_and_lies_between_them(known):
    branch = known.branches[1]
    for i in (3, 10, len(branch) - 2):
        place = 0.3 * branch.arclength[i] + 0.7 * branch.arclength[i + 1]
        orbit = orbit_between(branch, place)
        assert orbit.residual < 1e-10
        low, high = sorted(branch.parameter[i : i + 2])
        assert low < orbit.model.Nd < high


def test_a_special_point_may_have_fewer_nodes_than_the_points_beside_it(known):
    branch = known.branches[1]
    turn, *others = branch.special
    fewer = replace(branch, special=(replace(turn, nodes=turn.nodes[::2]), *others))
    after = np.searchsorted(branch.arclength, turn.arclength)
    for beside in branch.arclength[after - 1 : after + 1]:
        place = 0.5 * (turn.arclength + beside)
        value = [orbit_between(each, place).model.Nd for each in (branch, fewer)]
        assert value[1] == pytest.approx(value[0], rel=1e-6)


def test_a_value_asked_for_is_met_exactly(known):
    branch = known.branches[1]
    place = 0.5 * (branch.arclength[8] + branch.arclength[9])
    near = orbit_between(branch, place)
    value = near.model.Nd + 1e-3
    orbit = orbit_between(branch, place, value)
    assert orbit.model.Nd == pytest.approx(value, rel=1e-15)
    assert orbit.residual < 1e-10
    assert np.abs(orbit.nodes - near.nodes).max() / near.model.state_scales().max() < 0.1


@pytest.fixture(scope="module")
def squeal():
    return sf.response(sf.built_in_models()["squeal"](), "mu", (0, 1.2)).branches


@pytest.mark.parametrize("which", [0, 1], ids=["equilibria", "cycles"])
def test_autonomous_models_have_orbits_between_points_too(squeal, which):
    branch = squeal[which]
    low, high = branch.parameter[2:4]
    place, value = 0.5 * (branch.arclength[2] + branch.arclength[3]), 0.3 * low + 0.7 * high
    orbit = orbit_between(branch, place, value)
    assert orbit.model.mu == pytest.approx(value, rel=1e-14)
    again = sf.simulate(orbit.model, 1, orbit.state).states[-1]
    np.testing.assert_allclose(again, orbit.state, atol=1e-9)
    assert len(orbit.multipliers) == 4
    if branch.kind == "periodic":
        assert np.abs(orbit.multipliers - 1).min() < 1e-6
        low, high = sorted(branch.durations[2:4])
        assert low <= orbit.duration <= high


def test_a_branch_may_end_on_a_bound_that_excludes_its_end() -> None:
    (branch, *_) = sf.response(sf.SlidingOscillator(f=12.5), "Nd", (0, 0.02)).branches
    ended = replace(branch, parameter=np.append(branch.parameter[:-1], 1.0))  # where Nd = Ns
    assert not list(passes(ended, 0.5))
    assert len(list(orbits_at(ended, 0.01))) == 1
