"""The paper's oscillator, rebuilt from matrices, spring and contact: the same numbers."""

import numpy as np
import pytest

from slipfold import (
    Coulomb,
    FrictionContact,
    GeometricSpring,
    ModulatedLoad,
    SlidingOscillator,
    Structure,
)
from slipfold.bifurcations.branches.response import trace_response

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
