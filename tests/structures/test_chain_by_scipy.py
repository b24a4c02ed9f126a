"""Chains with elements and contacts against a version written by hand, integrated by SciPy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slipfold import (
    BoucWen,
    ConstantLoad,
    ContactLoad,
    Coulomb,
    CubicSpring,
    FrictionContact,
    GapSpring,
    GeometricSpring,
    HarmonicForce,
    LinearSpring,
    LuGre,
    ModulatedLoad,
    PolynomialSpring,
    ProportionalDamping,
    Stribeck,
    Structure,
    periodic_orbit,
)
from slipfold.flow.simulate import simulate
from slipfold.models.model import evaluation_of


def chain(size):
    k = 100.0 * (2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1))
    k[-1, -1] = 100.0
    return np.eye(size), k


def test_ten_masses_with_a_cubic_spring_and_a_belt():
    m, k = chain(10)
    model = Structure(
        m,
        ProportionalDamping(alpha_M=0.3, beta_K=0.002),
        k,
        elements=CubicSpring({"q5": 1, "q4": -1}, k3=40.0),
        contacts=FrictionContact(
            "q10", Stribeck(mu_s=0.4, mu_k=0.3, vs=0.5), ModulatedLoad(Ns=5, Nd=1), Vd=2.0
        ),
        forcing=HarmonicForce("q3", F=2.0, name="shaker"),
        f=0.4,
    )
    c = 0.3 * m + 0.002 * k

    def rhs(time, state):
        q, v = state[:10], state[10:]
        force = -k @ q - c @ v
        stretch = q[4] - q[3]
        force[4] -= 40.0 * stretch**3
        force[3] += 40.0 * stretch**3
        slip = 2.0 - v[9]
        mu = 0.3 + 0.1 * np.exp(-abs(slip) / 0.5)
        force[9] += (5 + np.cos(2 * np.pi * 0.4 * time)) * mu * np.sign(slip)
        force[2] += 2.0 * np.cos(2 * np.pi * 0.4 * time)
        return np.concatenate([v, force])

    orbit = periodic_orbit(model)
    time, states = orbit.sample(64)
    found = solve_ivp(rhs, (0, 2.5), orbit.state, "DOP853", t_eval=time, rtol=1e-12, atol=1e-13)
    expected = pytest.approx(states, abs=1e-9)
    assert np.asarray(found.y.T) == expected
    # It repeats, so it is the steady response and not only a motion of the same equations.
    end = solve_ivp(rhs, (0, 2.5), orbit.state, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    assert end == pytest.approx(orbit.state, abs=1e-9)
    power = {name: orbit.output(name)[1].mean() for name in
             ("power_forcing", "power_contacts", "power_damping")}  # fmt: skip
    given = power["power_forcing"] + power["power_contacts"]
    assert given == pytest.approx(power["power_damping"], rel=1e-10)


def full_house():
    m, k = chain(4)
    return Structure(
        m + 0.2 * (np.eye(4, k=1) + np.eye(4, k=-1)),
        ProportionalDamping(0.1, 0.001),
        k,
        names="a b c d",
        elements=[
            LinearSpring({"a": 1, "c": -1}, k=7.0, c=0.2, name="link"),
            CubicSpring("b", k3=9.0),
            PolynomialSpring("c", {1: -3.0, 2: 4.0, 5: 11.0}),
            GapSpring("d", k=30.0, gap=0.2, e=0.05, name="stop"),
            GapSpring("a", k=20.0, gap=0.1, e=0.05, side="both", name="both"),
            GeometricSpring(("a", "b"), (1, 2), k=50.0, L=0.8, stretch=1.1, name="tie"),
            GeometricSpring("d", (0, 1), k=50.0, L=0.8, name="across"),
        ],
        contacts=[
            FrictionContact(
                ("a", "b"), Coulomb(), ContactLoad("c", Ns=8, kn=12, cn=0.1), Vd=3.0, alpha=0.4
            ),
            FrictionContact("d", LuGre(), ConstantLoad(2.0, normal="c"), name="belt"),
        ],
        forcing=HarmonicForce("d", F=2.0, harmonic=2),
        length_scale=0.5,
        f=0.7,
    )


def test_elements_by_hand():
    model = full_house()
    a, b, c, d = 0.3, -0.2, 0.1, 0.25  # meters
    state = np.zeros(len(model.states))
    state[:4] = np.array([a, b, c, d]) / 0.5

    def stop(w):
        return 0.5 * (w + np.hypot(w, 0.05))

    force = -model.stiffness_matrix @ [a, b, c, d]
    force += np.array([-7 * (a - c), 0, 7 * (a - c), 0])
    force[1] -= 9 * b**3
    force[2] -= -3 * c + 4 * c**2 + 11 * c**5
    force[3] -= 30 * stop(d - 0.2)
    force[0] -= 20 * (stop(a - 0.1) - stop(-a - 0.1))
    arrow = np.array([a, b]) + 0.88 * np.array([1, 2]) / np.sqrt(5)
    length = np.linalg.norm(arrow)
    force[:2] -= 50 * (length - 0.8) * arrow / length
    length = np.hypot(d, 0.8)
    force[3] -= 50 * (length - 0.8) * d / length
    normal = 8 - 12 * c
    force[:2] += 0.5 * normal * np.array([np.cos(0.4), np.sin(0.4)])
    force[2] += normal + 2.0
    law = LuGre()
    force[3] += 2.0 * law.force((1.0,), 1.0, (0.0,))[0]
    force[3] += 2.0 * np.cos(2 * np.pi * 2 * 0.3)
    expected = np.linalg.solve(model.mass_matrix, force) / 0.5
    found = evaluation_of(model).rates(model, state, 0.3)
    assert found[4:8] == pytest.approx(expected, rel=1e-12)
    assert found[8] == pytest.approx(1.0, rel=1e-12)
    assert model.evaluate("N", state) == pytest.approx(normal)
    assert model.evaluate("l_tie", state) == pytest.approx(np.linalg.norm(arrow) / 0.8)


@pytest.mark.parametrize(
    "parts",
    [
        {"elements": CubicSpring("q1", k3=2.0)},
        {"elements": PolynomialSpring("q1", {2: 1.0, 5: 3.0})},
        {"contacts": FrictionContact("q1", BoucWen(A=20, b=20, c=20, exponent=8), 0.5)},
    ],
    ids=["cubic", "polynomial", "Bouc-Wen"],
)
def test_motions_begin_at_rest(parts):
    # Where the base of a power is zero its series is that of a product, not of a quotient.
    model = Structure([[1.0]], [[0.1]], [[1.0]], forcing=HarmonicForce("q1", F=1.0), **parts, f=0.2)
    rest = np.zeros(len(model.states))
    functions = evaluation_of(model)
    found = solve_ivp(
        lambda time, state: functions.rates(model, state, (0.2 * time) % 1),
        (0, 10), rest, "DOP853", rtol=1e-12, atol=1e-14,
    )  # fmt: skip
    assert simulate(model, 2, rest).states[-1] == pytest.approx(found.y[:, -1], abs=1e-8)


def after_a_period(rhs, state, period):
    found = solve_ivp(rhs, (0, period), state, "DOP853", rtol=1e-12, atol=1e-15)
    return found.y[:, -1]


def test_a_contact_in_the_plane_pressed_by_its_own_stiffness():
    k = np.diag([50.0, 60.0, 400.0])
    k[0, 2] = k[2, 0] = -20
    model = Structure(
        np.eye(3), 0.3 * np.eye(3), k, names="x y z",
        contacts=FrictionContact(
            ("x", "y"), Stribeck(mu_s=0.5, mu_k=0.3, vs=0.3),
            ContactLoad("z", Ns=6, kn=200, cn=0.5), Vd=1.5, alpha="30deg",
        ),
        forcing=HarmonicForce("z", F=1.0), f=1.4,
    )  # fmt: skip
    orbit = periodic_orbit(model)
    plate = 1.5 * np.array([np.cos(np.pi / 6), 0.5])

    def rhs(time, state):
        u, v = state[:3], state[3:]
        normal = 6 - 200 * u[2] - 0.5 * v[2]
        slip = plate - v[:2]
        speed = np.hypot(*slip)
        force = -k @ u - 0.3 * v
        force[:2] += (0.3 + 0.2 * np.exp(-speed / 0.3)) * normal * slip / speed
        force[2] += normal + np.cos(2 * np.pi * 1.4 * time)
        return np.concatenate([v, force])

    assert after_a_period(rhs, orbit.state, 1 / 1.4) == pytest.approx(orbit.state, abs=1e-11)
    assert orbit.output("N")[1].min() > 3
