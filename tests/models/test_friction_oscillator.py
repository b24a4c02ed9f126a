"""The sliding oscillator under all friction laws, against equations written by hand."""

from dataclasses import dataclass

import numpy as np
import pytest

import slipfold as sf
from helpers.by_hand.sliding import BASE, end_of, rhs
from slipfold.models.friction.law import ContactState
from slipfold.models.model import evaluation_of
from slipfold.models.parametric import described

SINGLE = sf.Settings(largest_period=1)
RNG = np.random.default_rng(20260105)
VALUES = {"Nd": 0.3, "f": 11.7, "alpha": 0.7, "zeta1": 0.02}
PLAIN = [
    sf.Coulomb(mu_s=0.6, mu_k=0.35),
    sf.CoulombViscous(mu_s=0.6, mu_k=0.35, s2=0.1),
    sf.Stribeck(mu_s=0.6, mu_k=0.35, vs=0.4),
    sf.Stribeck(mu_s=0.6, mu_k=0.35, vs=0.4, s2=0.05, exponent=2),
    sf.RationalStribeck(mu_s=0.6, d=0.8),
    sf.CubicStribeck(mu_s=0.6, mu_m=0.4, vm=0.8),
    sf.Regularized(sf.Coulomb(mu_s=0.6, mu_k=0.35), "tanh", e=0.3),
    sf.Regularized(sf.Stribeck(mu_s=0.6, mu_k=0.35, vs=0.4), "atan", e=0.3),
    sf.Regularized(sf.RationalStribeck(mu_s=0.6, d=0.8), "sqrt", e=0.3),
]
MEMORY = [
    sf.Dahl(mu_k=0.4, s0=1e3),
    sf.LuGre(mu_s=0.6, mu_k=0.35, vs=0.4, s0=1e3, s1=0.05, s2=0.02),
    sf.BoucWen(A=1e3, b=3e3, c=1e3),
    sf.Jenkins(mu_k=0.4, kt=500.0, e=1e-4, exponent=8),
    sf.Iwan(
        (sf.Jenkins(mu_k=0.1, kt=300.0, e=1e-4), sf.Jenkins(mu_k=0.3, kt=500.0, e=1e-4, exponent=4))
    ),
]


def slip_of(state, p):
    plate = p["Vd"] * np.array([np.cos(p["alpha"]), np.sin(p["alpha"])])
    return plate - p["L"] * np.asarray(state)[2:4]


def normal_of(time, p):
    return p["Ns"] + p["Nd"] * np.cos(2 * np.pi * p["f"] * time)


def rates_by_hand(time, state, p, law):
    """Equations of motion with the force of a law; the law itself is tested elsewhere."""
    free = rhs(time, np.asarray(state)[:4], {**p, "mu": 0.0})
    slip, memory = slip_of(state, p), tuple(state[4:])
    normal, turn = normal_of(time, p), 2 * np.pi * p["f"]
    normal_rate = -turn * p["Nd"] * np.sin(turn * time)
    force = law.force(tuple(slip), normal, memory)
    masses = [p[f"k{i}"] / (2 * np.pi * p[f"f{i}"]) ** 2 for i in (2, 1)]
    pushed = [f / (m * p["L"]) for f, m in zip(force, masses, strict=True)]
    free[2:] += pushed
    contact = ContactState(tuple(slip), memory, normal, normal_rate)
    return np.array([*free, *law.memory_rates(contact, law.values)])


def some_states(model, count=10):
    size = [0.4, 0.4, 30.0, 30.0, *[model.friction.memory_scale] * (len(model.states) - 4)]
    return RNG.normal(size=(count, len(size))) * size


@pytest.mark.parametrize("law", [None, *PLAIN, *MEMORY], ids=repr)
def test_rates_are_the_equations_written_by_hand(law):
    model = sf.SlidingOscillator(friction=law, **VALUES)
    p, law = {**BASE, **model.values}, model.friction
    for state in some_states(model):
        time = RNG.uniform(0, 5)
        found = evaluation_of(model).rates(model, state, time * model.f)
        assert found == pytest.approx(rates_by_hand(time, state, p, law), rel=1e-10, abs=1e-8)


@pytest.mark.parametrize("law", [None, *PLAIN, *MEMORY], ids=repr)
def test_outputs_follow_the_law(law):
    model = sf.SlidingOscillator(friction=law, **VALUES)
    p, law = {**BASE, **model.values}, model.friction
    for state in some_states(model):
        time = RNG.uniform(0, 5)
        slip, normal = slip_of(state, p), normal_of(time, p)
        velocity = p["L"] * state[2:4]
        force = np.array(law.force(tuple(slip), normal, tuple(state[4:])))
        expected = {
            "N": normal,
            "x": state[0],
            "Vrel": np.hypot(*slip),
            "Vrel_ratio": np.hypot(*slip) / p["Vd"],
            "l": np.hypot(1 + state[1], state[0]),
            "power_damping": np.dot([model.c2, model.c1], velocity**2),
            "Fx": force[0],
            "Fy": force[1],
            "friction_direction": np.arctan2(force[1], force[0]),
            "power_plate": force @ (slip + velocity),
            "power_friction": force @ slip,
            "power_structure": force @ velocity,
            "power_pulsation": (1 - p["Ns"] / normal) * (force @ velocity),
        }
        for name, value in expected.items():
            assert model.evaluate(name, state, time) == pytest.approx(value, rel=1e-9, abs=1e-12)
    losses = next(item for item in model.outputs() if item.name == "power_friction").doc
    assert ("stored" in losses) == (law in MEMORY)


@pytest.mark.parametrize("law", [None, *PLAIN], ids=repr)
def test_friction_adds_the_damping_of_the_law(law):
    model = sf.SlidingOscillator(friction=law, alpha=0.7, Ns=1.3)
    law, point = model.friction, model.static_point()
    free = sf.SlidingOscillator(mu=0, alpha=0.7, Ns=1.3)
    found = evaluation_of(model).jacobian(model, point) - evaluation_of(free).jacobian(free, point)
    masses = np.array([[model.m2], [model.m1]])
    expected = -law.damping(model.Vd, 1.3, 0.7)
    assert found[2:, 2:] * masses == pytest.approx(expected, rel=1e-9, abs=1e-11)
    assert found[:, :2] == pytest.approx(np.zeros((4, 2)), abs=1e-11)


def test_parameters_of_the_law_are_parameters_of_the_model():
    model = sf.SlidingOscillator(friction=sf.Stribeck(mu_s=0.6, vs="0.4 m/s"), mu_k=0.2, Nd=0.1)
    assert model.vs == 0.4
    assert (model.mu_s, model.mu_k) == (0.6, 0.2)
    assert model.parameter("vs").unit == "m/s"
    assert model.friction == sf.Stribeck(mu_s=0.6, mu_k=0.2, vs=0.4)
    assert "mu" not in model.values
    assert repr(model) == (
        "SlidingOscillator(friction=Stribeck(mu_s=0.6, mu_k=0.2, vs=0.4, s2=0.0, exponent=1), "
        "Nd=0.1)"
    )
    assert eval(repr(model), vars(sf)) == model


def test_a_contact_that_never_sticks_has_no_limit_there():
    for law in [*PLAIN, *MEMORY]:
        names = [limit.name for limit in sf.SlidingOscillator(friction=law).limits]
        assert ("stick" in names) == law.sticks
        assert {"lost contact", "spring collapse"} < {*names, "stick"}


@dataclass(frozen=True)
class Clashing(sf.FrictionLaw):
    title = "clashing"
    alpha: float = described(sf.Parameter("alpha", 0.5))

    def formula(self, speed, p):
        return p["alpha"]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"friction": 0.3}, "friction = 0.3 is not a friction law; give one such as Coulomb"),
        ({"friction": sf.Stribeck}, "is not a friction law"),
        ({"friction": Clashing()}, "Clashing calls something 'alpha', and so does sliding"),
        ({"friction": sf.Stribeck(), "mu": 0.3}, "sliding has no parameter 'mu'"),
        ({"friction": sf.Stribeck(), "Nd": 1.0}, "give Nd < Ns"),
    ],
)
def test_bad_input_gets_one_sentence(values, message):
    with pytest.raises(sf.InputError) as error:
        sf.SlidingOscillator(**values)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


# -- responses, against an integrator that shares no code ------------------------------------------


def stribeck_by_hand(time, state, p):
    """Analytic, so that complex steps differentiate it."""
    wx, wy = slip_of(state, p)
    speed = np.sqrt(wx**2 + wy**2)
    mu = p["mu_k"] + (p["mu_s"] - p["mu_k"]) * np.exp(-speed / p["vs"]) + p["s2"] * speed
    return rhs(time, state, {**p, "mu": mu})


def carried(rates, state, p):
    """State after one forcing period, by SciPy."""
    end = 1 / p["f"]
    return end_of(lambda s, q: end * rates(s * end, q, p), 1.0, np.asarray(state), atol=1e-14)


def test_response_in_the_speed_of_falling_friction():
    law = sf.Stribeck(mu_s=0.55, mu_k=0.4, vs=0.2, s2=0.02)
    model = sf.SlidingOscillator(friction=law, Nd=0.04)
    diagram = sf.response(model, vary="vs", span=(0.1, 0.6), f=12.5, settings=SINGLE)
    branch = diagram.branches[0]
    assert branch.stopped.kind == "span"
    scales = model.state_scales()
    for index in (0, len(branch) // 2, len(branch) - 1):
        orbit = branch.orbit(index)
        p = {**BASE, **orbit.model.values}
        state = orbit.nodes[0]
        mismatch = (carried(stribeck_by_hand, state, p) - state) / scales
        assert mismatch == pytest.approx(np.zeros(4), abs=1e-9)
    [point] = [item for item in branch.special if item.type == "PD"]
    p = {**BASE, **point.model.values}
    assert p["vs"] == point.value
    step = 1e-30
    columns = [
        np.imag(carried(stribeck_by_hand, point.state + 1j * step * unit, p)) / step
        for unit in np.eye(4)
    ]
    found = np.linalg.eigvals(np.transpose(columns))
    assert np.abs(found + 1).min() < 1e-7
    assert np.sort(np.abs(found)) == pytest.approx(np.sort(np.abs(point.multipliers)), abs=1e-7)


def test_elastic_coulomb_friction_tends_to_coulombs_as_it_stiffens():
    # In steady slip the force is on its limit, so the knee plays no part, and the deflection of the
    # contact delays the change of its direction by a time of order mu N/(kt Vd).
    values = {"Nd": 0.03, "f": 12.5}
    scales = sf.SlidingOscillator().state_scales()
    exact = sf.periodic_orbit(sf.SlidingOscillator(mu=0.5, **values)).nodes[0] / scales
    found = {}
    for kt, exponent in ((500.0, 4), (1000.0, 4), (1000.0, 2)):
        law = sf.Jenkins(mu_k=0.5, kt=kt, e=1e-4, exponent=exponent)
        orbit = sf.periodic_orbit(sf.SlidingOscillator(friction=law, **values))
        found[kt, exponent] = orbit.nodes[0][:4] / scales
    errors = [np.abs(found[kt, 4] - exact).max() for kt in (500.0, 1000.0)]
    assert errors[0] < 0.01
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.1)
    assert found[1000.0, 2] == pytest.approx(found[1000.0, 4], abs=0.01 * errors[1])
