"""Every built-in system and a chain by shooting and by collocation."""

from dataclasses import replace

import numpy as np
import pytest

import slipfold as sf
from helpers.toy_models import chain
from slipfold import Settings
from slipfold.bifurcations.branches.response import trace_response
from slipfold.models.registry import model_named

FORCED = [
    ("sliding", {"f": 12.5, "Nd": 0.2}, 1, None),
    ("sliding", {"f": 12.2, "Nd": 0.15}, 2, None),
    ("duffing", {"W": 1.2}, 1, None),
    ("mathieu", {"h": 0.1}, 2, (0.3, 0.1)),
    ("vanderpol", {}, 1, (2.0, 0.5)),
]

CYCLES = [
    ("vanderpol-free", {"mu": 1}),
    ("vanderpol-free", {"mu": 8}),
    ("stuart-landau", {}),
    ("lure", {"a": 0.7}),
    ("roessler", {"a": 0.1, "c": 4}),
    ("lorenz", {"rho": 160}),
    ("lorenz", {"rho": 350}),
    ("pin-on-disc", {"mu": 0.4}),
]

BRANCHES = [  # with the cycles of every kind and what bifurcates on them
    ("duffing", {}, "W", (0.9, 1.4), {"LP"}),
    ("sliding", {"f": 12.5}, "Nd", (0.0, 0.1), {"PD"}),
    ("squeal", {}, "mu", (0.5, 0.8), {"HB", "LP"}),
    ("freire", {}, "n", (-0.56, -0.62), {"HB", "LP", "BP"}),
    ("stribeck", {}, "vd", (2.0, 0.9), {"HB"}),
]


def assert_same(orbit):
    check = orbit.check()
    assert check.passed, check
    # What is requested is 1e-8; both methods can do better than that.
    assert check.states < 1e-10
    assert check.duration < 1e-10


@pytest.mark.parametrize(("name", "values", "period", "state"), FORCED)
def test_forced_orbits(name, values, period, state):
    orbit = sf.periodic_orbit(model_named(name, **values), period, state)
    assert_same(orbit)
    assert orbit.check().multipliers < 1e-11


@pytest.mark.parametrize(("name", "values"), CYCLES)
def test_cycles(name, values):
    orbit = sf.periodic_orbit(model_named(name, **values))
    assert_same(orbit)
    assert orbit.check().multipliers < 1e-11


@pytest.mark.parametrize(("name", "values", "vary", "span", "types"), BRANCHES)
def test_branches_and_their_bifurcations(name, values, vary, span, types):
    model = model_named(name, **values)
    branches = trace_response(model, vary, span, settings=Settings(largest_period=1))
    special = [point for branch in branches for point in branch.special]
    assert types <= {point.type for point in special}
    for point in special:
        assert_same(point.orbit)
        target = point.critical_multiplier
        found = point.orbit.check().collocated.multipliers
        assert np.abs(found - target).min() < 1e-7, point.type
    for branch in branches:
        for index in {1, len(branch) // 2, len(branch) - 2}:
            assert_same(branch.orbit(index))


def test_a_chain_of_ten_masses_with_a_friction_contact():
    assert_same(sf.periodic_orbit(chain(10, sf.Stribeck(), speed=1.0)))


def test_what_is_no_orbit_does_not_pass():
    orbit = sf.periodic_orbit(model_named("duffing"))
    moved = replace(orbit, nodes=orbit.nodes + 1e-6)
    assert not moved.check().passed
    assert moved.check().states == pytest.approx(1e-6, rel=1e-6)
    other = replace(orbit, multipliers=orbit.multipliers * (1 + 1e-7))
    assert not other.check().passed
    assert other.check().multipliers == pytest.approx(
        1e-7 * np.abs(orbit.multipliers).max(), rel=1e-3
    )
    assert other.check(tolerance=1e-6).passed
    cycle = sf.periodic_orbit(model_named("stuart-landau"))
    slow = replace(cycle, model=cycle.model.replace(duration=cycle.model.duration * (1 + 1e-6)))
    assert slow.check().duration == pytest.approx(1e-6, rel=1e-3)


def test_what_is_no_fold_does_not_pass_for_one():
    # At a fold the position along the branch is taken from the orbit, the rest is not.
    model = model_named("duffing")
    (branch,) = trace_response(model, "W", (0.9, 1.4))
    fold = next(point for point in branch.special if point.type == "LP").orbit
    assert fold.check().passed
    beyond = replace(fold, model=fold.model.replace(W=fold.model.W * (1 + 1e-6)))
    assert not beyond.check().passed


def test_equilibria():
    model = model_named("roessler", c=3)
    equilibrium, *_ = trace_response(model, "a", (0.1, 0.2), settings=Settings(largest_period=1))
    assert equilibrium.kind == "equilibrium"
    for index, a in enumerate(equilibrium.parameter):
        check = equilibrium.orbit(index).check()
        assert check.passed
        assert check.multipliers < 1e-10
        y = (-3 + np.sqrt(9 - 4 * a * 0.2)) / (2 * a)
        assert check.collocated.states[0] == pytest.approx([-a * y, y, -y], rel=1e-12)


def test_the_report_is_a_sentence():
    orbit = sf.periodic_orbit(model_named("duffing"))
    assert str(orbit.check()).startswith("collocation on ")
    assert str(orbit.check()).endswith("within 1e-08")
    assert "not within" in str(replace(orbit, nodes=orbit.nodes + 1e-3).check())
