"""Derivatives carried a few at a time are those carried all at once."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.flow import flow_of
from slipfold.flow.equations import build_equations
from slipfold.flow.flow import Flow
from slipfold.models import model_named
from slipfold.models.evaluation import COLUMNS, WHOLE

START, END = np.array([0.0, 0.3, 0.7]), np.array([0.25, 0.65, 1.2])


def chain(size, contacts=()):
    stiffness = 100.0 * (2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1))
    return sf.Structure(
        np.eye(size),
        sf.ProportionalDamping(0.1, 0.001),
        stiffness,
        elements=sf.CubicSpring(f"q{size}", k3=10.0),
        contacts=contacts,
        forcing=sf.HarmonicForce("q1", F=2.0),
    )


def a_few(monkeypatch):
    monkeypatch.setattr("slipfold.flow.flow.carried_whole", lambda _: False)


@pytest.mark.parametrize("model", [model_named("duffing"), chain(3)])
def test_both_ways_agree(model, monkeypatch):
    flow = Flow(build_equations(model))
    constants = flow.constants(model.vector)
    n = flow.dimension
    assert n <= WHOLE
    assert n % COLUMNS
    rng = np.random.default_rng(5)
    # Vectors of size one: what they bend is then no smaller than what is integrated with it.
    states, vectors = 0.1 * rng.normal(size=(3, n)), rng.normal(size=(3, n))
    directions = constants.rates[:, :2]
    each = np.stack([directions, 2 * directions, -directions])
    for along in (directions, each):
        whole = flow.linearise(states, START, END, constants, along)
        bent = flow.curve(states, START, END, constants, along, vectors)
        with monkeypatch.context() as patch:
            a_few(patch)
            few = flow.linearise(states, START, END, constants, along)
            few_bent = flow.curve(states, START, END, constants, along, vectors)
        for one, other in zip((*whole, *bent), (*few, *few_bent), strict=True):
            assert other == pytest.approx(one, rel=1e-11, abs=1e-11 * np.abs(one).max())


def test_trajectories_with_their_own_constants(monkeypatch):
    a_few(monkeypatch)
    model = model_named("duffing")
    flow = flow_of(model)
    vectors = np.array([model.vector, model.replace(W=1.3).vector, model.replace(F=0.4).vector])
    together = flow.constants(vectors)
    states = np.array([[0.1, 0.2], [0.3, -0.1], [1.0, 0.0]])
    found = flow.linearise(states, START, END, together, together.rates[:, :, :1])
    for i in range(3):
        alone = flow.constants(vectors[i])
        one = flow.linearise(states[[i]], START[[i]], END[[i]], alone, alone.rates[:, :1])
        for all_of, single in zip(found, one, strict=True):
            assert all_of[i] == pytest.approx(single[0], rel=1e-12, abs=1e-13)


def test_a_singularity_is_not_a_number(monkeypatch):
    a_few(monkeypatch)
    model = sf.SlidingOscillator()
    flow = flow_of(model)
    constants = flow.constants(model.vector)
    collapsed = np.array([[0.0, -1.0, 0.0, 0.0]])
    for result in flow.linearise(collapsed, START[:1], END[:1], constants, constants.rates[:, :1]):
        assert np.isnan(result).all()


def test_a_chain_of_twenty_masses_as_collocation_has_it():
    # More states than are carried at once: the whole way from compiling to multipliers.
    contact = sf.FrictionContact("q20", sf.Stribeck(), load=2.0, Vd=1.0)
    orbit = sf.periodic_orbit(chain(20, contact).replace(f=0.6))
    check = orbit.check()
    assert check.passed, check
    assert check.multipliers < 1e-11
