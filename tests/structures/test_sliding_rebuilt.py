"""The paper's oscillator, rebuilt from matrices, spring and contact: the same numbers."""

import math
import pickle

import numpy as np
import pytest

from slipfold.branches import trace_response
from slipfold.models import SlidingOscillator
from slipfold.models.evaluation import evaluation_of
from slipfold.models.friction import Coulomb, LuGre, RationalStribeck
from slipfold.models.structures import (
    FrictionContact,
    GeometricSpring,
    ModulatedLoad,
    Structure,
)
from slipfold.orbits import periodic_orbit

RNG = np.random.default_rng(20260102)
STATES = RNG.normal(size=(20, 4)) * [0.4, 0.4, 30.0, 30.0]
PHASES = RNG.uniform(size=20)


def rebuilt(model, law=None):
    return Structure(
        M=np.diag([model.m2, model.m1]),
        C=np.diag([model.c2, model.c1]),
        K=np.diag([model.k2, model.k1]),
        names="x y",
        elements=GeometricSpring(("x", "y"), axis=(0, 1), k=model.kext, L=model.L),
        contacts=FrictionContact(
            ("x", "y"),
            law or Coulomb(mu_s=model.mu, mu_k=model.mu),
            ModulatedLoad(Ns=model.Ns, Nd=model.Nd),
            Vd=model.Vd,
            alpha=model.alpha,
        ),
        length_scale=model.L,
        f=model.f,
    )


@pytest.mark.parametrize(
    "values", [{}, {"Nd": 0.3, "f": 11.7, "alpha": 0.7, "mu": 0.35, "zeta1": 0.02, "L": 4e-3}]
)
def test_rates(values):
    paper = SlidingOscillator(**values)
    ours = rebuilt(paper)
    for state, phase in zip(STATES, PHASES, strict=True):
        expected = evaluation_of(paper).rates(paper, state, phase)
        found = evaluation_of(ours).rates(ours, state, phase)
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("law", [RationalStribeck(mu_s=0.4, d=1.5), LuGre(mu_s=0.5, mu_k=0.4)])
def test_rates_with_other_laws(law):
    paper = SlidingOscillator(friction=law, Nd=0.2)
    ours = rebuilt(SlidingOscillator(Nd=0.2), law)
    memory = RNG.normal(size=(20, len(paper.states) - 4)) * 1e-5
    for state, phase in zip(np.hstack([STATES, memory]), PHASES, strict=True):
        expected = evaluation_of(paper).rates(paper, state, phase)
        found = evaluation_of(ours).rates(ours, state, phase)
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12 * np.abs(expected).max())
    assert ours.state_scales() == pytest.approx(paper.state_scales(), rel=1e-15)


def test_static_point_and_modes():
    paper = SlidingOscillator()
    ours = rebuilt(paper)
    assert ours.static_point() == pytest.approx(paper.static_point(), abs=1e-14)
    assert ours.modes().eigenvalues == pytest.approx(paper.modes().eigenvalues, rel=1e-12)


def test_outputs_that_both_have():
    paper = SlidingOscillator(Nd=0.3)
    ours = rebuilt(paper)
    for name in ("N", "Vrel", "Vrel_ratio", "l", "Fx", "Fy", "power_plate", "power_friction",
                 "power_damping"):  # fmt: skip
        expected = paper.evaluate(name, STATES, PHASES / paper.f)
        assert ours.evaluate(name, STATES, PHASES / ours.f) == pytest.approx(expected, rel=1e-12)
    taken = paper.evaluate("power_structure", STATES, PHASES / paper.f)
    assert ours.evaluate("power_contacts", STATES, PHASES / ours.f) == pytest.approx(
        taken, rel=1e-12, abs=1e-14
    )


def test_orbit_and_multipliers():
    paper = periodic_orbit(SlidingOscillator(f=12.2, Nd=0.1))
    ours = periodic_orbit(rebuilt(paper.model))
    assert ours.nodes == pytest.approx(paper.nodes, abs=1e-10)
    assert ours.multipliers == pytest.approx(paper.multipliers, abs=1e-12)


def test_response_with_its_special_points():
    paper = SlidingOscillator()
    expected = trace_response(paper, "Nd", (0, 0.98))
    found = trace_response(rebuilt(paper), "Nd", (0, 0.98))
    assert [len(branch) for branch in found] == [len(branch) for branch in expected]
    for ours, theirs in zip(found, expected, strict=True):
        assert (ours.stopped.kind, ours.stopped.reason) == (
            theirs.stopped.kind,
            theirs.stopped.reason,
        )
        assert ours.stopped.value == pytest.approx(theirs.stopped.value, abs=1e-12)
        for a, b in zip(ours.special, theirs.special, strict=True):
            assert (a.type, a.criticality) == (b.type, b.criticality)
            assert a.value == pytest.approx(b.value, abs=1e-12)
            assert a.coefficient == pytest.approx(b.coefficient, rel=1e-9)
            assert a.orbit.multipliers == pytest.approx(b.orbit.multipliers, abs=1e-12)


def test_the_response_may_be_varied_in_the_spring():
    ours = rebuilt(SlidingOscillator(Nd=0.05))
    branch = trace_response(ours, "k", (1000, 900))[0]
    assert branch.stopped.kind == "span"
    orbit = periodic_orbit(SlidingOscillator(Nd=0.05, kext=900))
    assert branch.nodes[-1][0] == pytest.approx(orbit.state, abs=1e-9)


def test_equal_hashable_picklable_and_short():
    paper = SlidingOscillator(Nd=0.2)
    ours, again = rebuilt(paper), rebuilt(paper)
    assert ours == again
    assert hash(ours) == hash(again)
    assert ours.kind == ours.replace(Nd=0.1, k=5.0).kind
    assert ours.kind != rebuilt(paper.replace(f1=6.0)).kind
    assert pickle.loads(pickle.dumps(ours)) == ours
    assert repr(ours) == (
        f"Structure(x y, f=12.5, k=1000, L=0.005, Nd=0.2, Vd=0.6, alpha={math.pi / 3:.12g})"
    )


def test_parts_may_be_replaced():
    ours = rebuilt(SlidingOscillator(Nd=0.2))
    free = ours.replace(elements=(), Nd=0.1)
    assert free.Nd == 0.1
    assert free.Vd == 0.6
    assert "k" not in free.values
    other = ours.replace(elements=GeometricSpring(("x", "y"), (0, 1), k=5.0, L=5e-3))
    assert other == ours.replace(k=5.0)
