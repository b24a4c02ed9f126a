"""Forces in the plane and on a line: direction, energy, limits; memory against closed forms."""

from dataclasses import replace

import heyoka as hy
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from slipfold import (
    BoucWen,
    Coulomb,
    CoulombViscous,
    CubicStribeck,
    Dahl,
    Iwan,
    Jenkins,
    LuGre,
    RationalStribeck,
    Regularized,
    Stribeck,
)
from slipfold.models.friction.law import ContactState

RNG = np.random.default_rng(20260104)
PLAIN = [
    Coulomb(),
    CoulombViscous(),
    Stribeck(s2=0.1),
    Stribeck(exponent=2),
    RationalStribeck(),
    CubicStribeck(vm=2.0),
]
SMOOTH = [
    Regularized(law, shape, e=0.05)
    for law in (Coulomb(), Stribeck())
    for shape in ("tanh", "atan", "sqrt")
]
BRISTLES = [Dahl(s0=1e3), LuGre(s0=1e3, s1=0.02, s2=0.1)]
SHARP = 1e-7
BOUC_WEN = BoucWen(A=1e3, b=3e3, c=1e3, e=SHARP)
JENKINS = Jenkins(mu_k=0.4, kt=300.0, e=SHARP, exponent=8)
IWAN = Iwan((JENKINS, Jenkins(mu_k=0.1, kt=50.0, e=SHARP, exponent=4)))
MEMORY = [*BRISTLES, BOUC_WEN, replace(BOUC_WEN, exponent=4), JENKINS, IWAN]


def memory_rates(law, slip, memory, normal=1.0, normal_rate=0.0):
    return law.memory_rates(ContactState(slip, memory, normal, normal_rate), law.values)


def turned(vector, angle):
    cos, sin = np.cos(angle), np.sin(angle)
    return (cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1])


def turned_memory(memory, angle):
    """Each vector of a memory turned; Iwan's has several."""
    pairs = zip(memory[::2], memory[1::2], strict=True)
    return tuple(part for pair in pairs for part in turned(pair, angle))


def some_memory(law, dimensions):
    return tuple(law.memory_scale * RNG.uniform(-0.7, 0.7, len(law.memory(dimensions))))


@pytest.mark.parametrize("law", [*PLAIN, *SMOOTH, *MEMORY], ids=repr)
def test_all_directions_are_alike(law):
    for angle in (0.3, 2.0, -1.1):
        slip, memory = (0.21, -0.13), some_memory(law, 2)
        straight = law.force(slip, 1.7, memory)
        rotated = turned_memory(memory, angle)
        assert law.force(turned(slip, angle), 1.7, rotated) == pytest.approx(
            turned(straight, angle), rel=1e-13
        )
        if memory:
            rates = memory_rates(law, slip, memory)
            assert memory_rates(law, turned(slip, angle), rotated) == pytest.approx(
                turned_memory(rates, angle), rel=1e-12
            )


@pytest.mark.parametrize("law", [*PLAIN, *SMOOTH], ids=repr)
def test_force_lies_along_the_slip_and_has_the_size_of_the_law(law):
    slip = np.array([0.3, 0.4])
    expected = 2.0 * law.coefficient(0.5) * slip / 0.5
    assert law.force(slip, 2.0) == pytest.approx(expected, rel=1e-13)
    assert law.force((-0.5,), 2.0) == pytest.approx((-2.0 * law.coefficient(0.5),), rel=1e-13)
    fields = law.force((np.array([0.3, -0.3]), np.array([0.4, 0.4])), 2.0)
    assert fields[0] == pytest.approx([expected[0], -expected[0]], rel=1e-13)


@pytest.mark.parametrize("law", [*PLAIN, *SMOOTH, *MEMORY], ids=repr)
def test_the_plane_holds_the_line(law):
    memory = some_memory(law, 1)
    for v in (0.2, -0.03):
        [force] = law.force((v,), 1.3, memory)
        beside = tuple(part for z in memory for part in (z, 0.0))
        assert law.force((v, 0.0), 1.3, beside) == pytest.approx((force, 0.0), rel=1e-13)
        if memory:
            rates = memory_rates(law, (v, 0.0), beside)
            straight = [part for rate in memory_rates(law, (v,), memory) for part in (rate, 0.0)]
            assert rates == pytest.approx(straight, rel=1e-13)


@given(st.floats(-2, 2), st.floats(-2, 2), st.sampled_from([*PLAIN, *SMOOTH]))
def test_slip_loses_energy(x, y, law):
    if np.hypot(x, y) > 1e-9:
        force = law.force((x, y))
        assert force[0] * x + force[1] * y >= 0


@pytest.mark.parametrize("law", [BRISTLES[0], *MEMORY[2:5]], ids=repr)
def test_slip_gives_no_less_than_the_contact_stores(law):
    # The stored energy over N is s0 z^2/2 for Dahl's law, z^2/(2 A) for Bouc-Wen's and, at N = 1,
    # (mu z)^2/(2 kt) for that of Jenkins.
    if isinstance(law, Jenkins):
        weight = law.mu_k**2 / law.kt
    else:
        weight = law.s0 if isinstance(law, Dahl) else 1 / law.A
    for _ in range(50):
        slip, memory = RNG.normal(size=2), some_memory(law, 2)
        power = np.dot(law.force(slip, 1.0, memory), slip)
        stored = weight * np.dot(memory, memory_rates(law, slip, memory))
        assert power - stored >= -1e-12


@pytest.mark.parametrize("shape", ["tanh", "atan", "sqrt"])
@pytest.mark.parametrize("law", PLAIN, ids=repr)
def test_regularized_law_tends_to_the_law(law, shape):
    slip = (0.06, -0.08)
    exact = np.array(law.force(slip))
    errors = [
        np.abs(np.array(Regularized(law, shape, e=e).force(slip)) - exact).max()
        for e in (1e-2, 1e-3, 1e-4)
    ]
    order = {"atan": 1, "sqrt": 2}.get(shape)
    if order is None:  # tanh: faster than any power
        assert errors[1] < 1e-14
    else:
        assert errors[1] / errors[2] == pytest.approx(10**order, rel=0.02)
    assert errors[2] < 1e-3


@pytest.mark.parametrize("law", SMOOTH, ids=repr)
@pytest.mark.parametrize("dimensions", [1, 2])
def test_regularized_law_is_smooth_at_rest(law, dimensions):
    rest = (0.0,) * dimensions
    assert law.force(rest) == rest
    slip = [hy.expression(f"v{i}") for i in range(dimensions)]
    force = law.force(slip)
    jacobian = hy.cfunc([hy.diff(f, v) for f in force for v in slip], vars=slip)(rest)
    level = law.law.stiction if not isinstance(law.law, Coulomb) else law.law.mu_k
    rise = 2 / np.pi if law.shape == "atan" else 1.0
    expected = level * rise / law.e * np.eye(dimensions)
    assert jacobian.reshape(dimensions, dimensions) == pytest.approx(expected, rel=1e-7, abs=1e-6)


@pytest.mark.parametrize("law", [*PLAIN, *SMOOTH], ids=repr)
def test_damping_is_the_derivative_of_the_force(law):
    angle, speed, normal = 0.7, 0.4, 1.9
    e = np.array([np.cos(angle), np.sin(angle)])
    step = 1e-30
    # The slip is the plate's velocity less the body's, so damping is dF/dslip.
    columns = [
        np.imag(law.force(tuple(speed * e + step * 1j * unit), normal)) / step for unit in np.eye(2)
    ]
    assert law.damping(speed, normal, angle) == pytest.approx(np.transpose(columns), rel=1e-12)


@pytest.mark.parametrize("law", MEMORY, ids=repr)
def test_steady_slip_has_the_coefficient_of_the_law(law):
    for slip in ((0.3, -0.2), (0.25,)):
        memory = law.steady_memory(slip)
        speed = np.linalg.norm(slip)
        assert memory_rates(law, slip, memory) == pytest.approx(np.zeros(len(memory)), abs=1e-8)
        expected = 1.5 * law.coefficient(speed) * np.array(slip) / speed
        assert law.force(slip, 1.5, memory) == pytest.approx(expected, rel=1e-11)


def pulled(law, velocity, end, start=None):
    """Force over N, and memory, on a line after some time at a velocity."""
    memory = [0.0] if start is None else start
    solution = solve_ivp(
        lambda t, z: memory_rates(law, (velocity,), tuple(z)),
        (0, end),
        memory,
        method="DOP853",
        rtol=1e-12,
        atol=1e-16,
    )
    z = solution.y[:, -1]
    return law.force((velocity,), 1.0, tuple(z))[0], z


def test_dahl_yields_exponentially():
    law = Dahl(mu_k=0.4, s0=1e3, e=SHARP)
    for v in (0.1, -0.1):
        force, _ = pulled(law, v, 4e-3)
        assert force == pytest.approx(np.sign(v) * 0.4 * (1 - np.exp(-1e3 * 4e-4 / 0.4)), rel=1e-9)


def test_lugre_bristles_bend_exponentially_and_are_damped():
    law = LuGre(mu_s=0.5, mu_k=0.3, vs=0.1, s0=1e3, s1=0.02, s2=0.1, e=SHARP)
    v, t = 0.1, 2e-3
    level = 0.3 + 0.2 * np.exp(-1)
    bent, fade = level / 1e3, np.exp(-1e3 * v * t / level)
    force, z = pulled(law, v, t)
    assert z[0] == pytest.approx(bent * (1 - fade), rel=1e-9)
    assert force == pytest.approx(1e3 * z[0] + 0.02 * v * fade + 0.1 * v, rel=1e-9)


def test_bouc_wen_rises_as_tanh_and_unloads_straight():
    # n = 2, b = c: z' = v (A - 2 b z^2) on loading, z' = A v on unloading.
    law = BoucWen(A=1e3, b=2e3, c=2e3, e=SHARP)
    force, z = pulled(law, 0.1, 5e-3)
    assert force == pytest.approx(0.5 * np.tanh(4e3 * 0.5 * 5e-4), rel=1e-9)
    less, _ = pulled(law, -0.1, 1e-3, z)
    assert less == pytest.approx(force - 1e3 * 1e-4, rel=1e-6)


def test_jenkins_of_the_textbook():
    # System 12.
    element = Jenkins(mu_k=1.0, kt=20.0)
    assert element.stiffness(0.2) == pytest.approx(3.910022189558, abs=1e-12)
    assert element.loss_stiffness(0.2) == pytest.approx(4.774648292757, abs=1e-12)
    assert element.energy(0.2) == pytest.approx(0.6, abs=1e-15)
    assert element.stiffness(0.04) == 20.0
    assert element.energy(0.04) == 0.0
    assert Jenkins(mu_k=0.5, kt=20.0).stiffness(0.2, normal=2.0) == element.stiffness(0.2)


def driven(law, amplitude):
    """Energy of a cycle, k' and k'' of a law on a line under a harmonic displacement, N = 1."""

    def rates(t, q):
        v = -amplitude * np.sin(t)
        [force] = law.force((v,), 1.0, tuple(q[3:]))
        work = [force * v, force * np.cos(t), -force * np.sin(t)]
        return [*work, *memory_rates(law, (v,), tuple(q[3:]))]

    # Slip before the turning point has left the memory of steady slip.
    start = [0, 0, 0, *law.steady_memory((1.0,))]
    run = solve_ivp(rates, (0, 2 * np.pi), start, "DOP853", rtol=1e-8, atol=1e-11, max_step=0.02)
    assert run.y[3:, -1] == pytest.approx(run.y[3:, 0], abs=1e-7)
    energy, along, across = run.y[:3, -1]
    return np.array([energy, along / (np.pi * amplitude), across / (np.pi * amplitude)])


def test_jenkins_under_a_harmonic_drive_tends_to_its_closed_forms():
    # System 12 of the textbook, as a model sees the element: the error falls with n^2.
    exact = np.array([0.6, 3.910022189558, 4.774648292757])
    errors = [
        driven(Jenkins(mu_k=1.0, kt=20.0, e=SHARP, exponent=n), 0.2) / exact - 1
        for n in (8, 16, 32)
    ]
    assert np.abs(errors[1]).max() < 1e-3
    assert errors[0] / errors[1] == pytest.approx([4, 4, 4], rel=0.15)
    assert errors[1] / errors[2] == pytest.approx([4, 4, 4], rel=0.1)


def returned(law, slip, normal, times, force):
    """Force of the sharp element by steps of stick, mapped back onto the disc |F| <= mu N."""
    forces = [np.asarray(force, dtype=float)]
    for t, step in zip(times[1:], np.diff(times), strict=True):
        trial = forces[-1] + law.kt * step * np.asarray(slip(t - step / 2))
        forces.append(trial * min(1.0, law.mu_k * normal(t) / np.linalg.norm(trial)))
    return np.array(forces)


@pytest.mark.parametrize(
    "slip",
    [lambda t: (np.cos(t),), lambda t: (np.cos(t), 0.4 * np.sin(2 * t + 0.5))],
    ids=["line", "plane"],
)
def test_jenkins_follows_the_normal_force(slip):
    # The normal force passes its minimum in stick and in slip; |F| = mu N bounds the force always.
    def normal(t):
        return 1.0 + 0.6 * np.sin(3 * t + 1.0)

    law = Jenkins(mu_k=0.5, kt=2.0, e=1e-6)
    times = np.linspace(0, 10, 20001)
    start = tuple(0.0 * part for part in slip(0.0))
    exact = returned(law, slip, normal, times, start)
    errors = []
    for exponent in (8, 32):
        knee = replace(law, exponent=exponent)
        run = solve_ivp(
            lambda t, z, knee=knee: memory_rates(
                knee, slip(t), tuple(z), normal(t), 1.8 * np.cos(3 * t + 1.0)
            ),
            (0, 10),
            start,
            "DOP853",
            t_eval=times,
            rtol=1e-8,
            atol=1e-10,
            max_step=0.02,
        )
        assert np.linalg.norm(run.y, axis=0).max() <= 1 + 1e-7  # the integrator's error
        force = law.mu_k * normal(times) * run.y
        errors.append(np.abs(force.T - exact).max())
    # The force itself is wrong by a share of order 1/n of its limit while it passes the knee.
    assert errors[0] < 0.1 * law.mu_k * 1.6
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.15)
