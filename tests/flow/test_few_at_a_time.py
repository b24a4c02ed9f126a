"""Derivatives carried a few at a time are those carried all at once."""

import numpy as np
import pytest

import slipfold as sf
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
