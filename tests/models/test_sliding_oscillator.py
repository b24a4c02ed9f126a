"""Numbers of the sliding oscillator against the design page."""

import numpy as np
import pytest

from helpers.by_hand.sliding import rhs
from slipfold import SlidingOscillator
from slipfold.models.model import evaluation_of
from slipfold.models.registry import model_named

MODEL = SlidingOscillator(Nd=0.3, f=11.7, alpha=0.7, mu=0.35, zeta1=0.02)


def test_masses_and_damping_of_the_design_page():
    model = SlidingOscillator()
    assert model.m1 == pytest.approx(0.215048899292, rel=1e-11)
    assert model.m2 == pytest.approx(0.211481936609, rel=1e-11)
    assert model.c1 == pytest.approx(0.0992315466752, rel=1e-11)
    # The page prints 0.0998259410607; 4 pi zeta2 m2 f2 is 0.09982594106758, seven units higher.
    assert model.c2 == pytest.approx(0.0998259410607, rel=1e-10)
    assert model.c2 == pytest.approx(2 * model.zeta2 * np.sqrt(model.k2 * model.m2), rel=1e-14)


def test_static_point_and_eigenvalues_of_the_design_page():
    model = SlidingOscillator()
    point = model.static_point()
    assert point == pytest.approx([0.117402977126, 0.061106649797, 0, 0], abs=1e-12)
    expected = np.array([-1.898259036 + 44.811184307j, -0.530528347 + 78.291272945j])
    assert model.modes().eigenvalues == pytest.approx(expected, abs=1e-9)
    assert model.modes().stable
    steady = model_named("steady-sliding")
    assert steady == model.steady()
    found = np.linalg.eigvals(evaluation_of(steady).jacobian(steady, steady.static_point()))
    assert np.sort_complex(found)[[1, 3]] == pytest.approx(expected, abs=1e-8)


def test_vertical_frequency_without_friction_of_the_design_page():
    assert SlidingOscillator(mu=0).modes().frequency == pytest.approx([6.59, 12.45965249], abs=1e-8)


def test_static_point_balances_the_forces():
    for model in (MODEL, MODEL.replace(Ns=5.0, Vd=2.0), MODEL.replace(kext=0)):
        point = model.static_point()
        p = {**model.values, "Nd": 0.0}
        assert rhs(0.0, point, p) == pytest.approx(np.zeros(4), abs=1e-9)
