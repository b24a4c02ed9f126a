"""Physics of the sliding oscillator against the design page and a version written by hand."""

import numpy as np
import pytest

from helpers.by_hand.sliding import BASE, rhs
from slipfold import SlidingOscillator
from slipfold.models.model import evaluation_of

RNG = np.random.default_rng(20260101)
STATES = RNG.normal(size=(20, 4)) * [0.4, 0.4, 30.0, 30.0]
TIMES = RNG.uniform(0, 5, size=20)
MODEL = SlidingOscillator(Nd=0.3, f=11.7, alpha=0.7, mu=0.35, zeta1=0.02)


def outputs_by_hand(state, time, p):
    x, y, vx, vy = p["L"] * np.asarray(state)
    plate = p["Vd"] * np.array([np.cos(p["alpha"]), np.sin(p["alpha"])])
    velocity = np.array([vx, vy])
    slip = plate - velocity
    speed = np.hypot(*slip)
    normal = p["Ns"] + p["Nd"] * np.cos(2 * np.pi * p["f"] * time)
    force = p["mu"] * normal * slip / speed
    m1, m2 = p["k1"] / (2 * np.pi * p["f1"]) ** 2, p["k2"] / (2 * np.pi * p["f2"]) ** 2
    c1, c2 = (4 * np.pi * p[f"zeta{i}"] * m * p[f"f{i}"] for i, m in ((1, m1), (2, m2)))
    pulsing = 1 - p["Ns"] / normal
    return {
        "x": state[0],
        "N": normal,
        "Vrel": speed,
        "Vrel_ratio": speed / p["Vd"],
        "l": np.hypot(1 + y / p["L"], x / p["L"]),
        "Fx": force[0],
        "Fy": force[1],
        "friction_direction": np.arctan2(force[1], force[0]),
        "power_plate": force @ plate,
        "power_friction": force @ slip,
        "power_structure": force @ velocity,
        "power_pulsation": pulsing * (force @ velocity),
        "power_damping": c1 * vy**2 + c2 * vx**2,
    }


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
    assert model.modes().eigenvalues == pytest.approx(
        [-1.898259036 + 44.811184307j, -0.530528347 + 78.291272945j], abs=1e-9
    )
    assert model.modes().stable


def test_vertical_frequency_without_friction_of_the_design_page():
    assert SlidingOscillator(mu=0).modes().frequency == pytest.approx([6.59, 12.45965249], abs=1e-8)


def test_friction_adds_its_damping_and_leaves_the_stiffness():
    model = SlidingOscillator()
    point = model.static_point()
    with_it = evaluation_of(model).jacobian(model, point)
    without = evaluation_of(model).jacobian(model.replace(mu=0), point)
    e = np.array([np.cos(model.alpha), np.sin(model.alpha)])
    expected = -model.mu * model.Ns / model.Vd * (np.eye(2) - np.outer(e, e))
    masses = np.array([[model.m2], [model.m1]])
    assert (with_it - without)[2:, 2:] * masses == pytest.approx(expected, abs=1e-12)
    assert (with_it - without)[:, :2] == pytest.approx(np.zeros((4, 2)), abs=1e-12)
    assert model.modes(friction=False).damping_ratio[0] < model.modes().damping_ratio[0] / 6


def test_static_point_balances_the_forces():
    for model in (MODEL, MODEL.replace(Ns=5.0, Vd=2.0), MODEL.replace(kext=0)):
        point = model.static_point()
        p = {**model.values, "Nd": 0.0}
        assert rhs(0.0, point, p) == pytest.approx(np.zeros(4), abs=1e-9)


def test_rates_are_the_equations_of_the_design_page():
    functions = evaluation_of(MODEL)
    p = {**BASE, **MODEL.values}
    for state, time in zip(STATES, TIMES, strict=True):
        assert functions.rates(MODEL, state, time * MODEL.f) == pytest.approx(
            rhs(time, state, p), rel=1e-11, abs=1e-9
        )


@pytest.mark.parametrize("name", list(outputs_by_hand(np.ones(4), 0.0, BASE)))
def test_outputs_are_what_their_names_say(name):
    found = MODEL.evaluate(name, STATES, TIMES)
    expected = [
        outputs_by_hand(state, time, MODEL.values)[name]
        for state, time in zip(STATES, TIMES, strict=True)
    ]
    assert found == pytest.approx(np.array(expected), rel=1e-11, abs=1e-13)
