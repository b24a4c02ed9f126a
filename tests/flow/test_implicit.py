"""Motions in which something decays a million times faster than anything happens."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from helpers.dry_friction import belt
from slipfold.flow.equilibrium import with_duration
from slipfold.flow.flow import flow_of
from slipfold.flow.implicit_steps import IMPLICIT, StepsEnd, StiffFallback, implicit_trajectory

FORCE, DAMPING, SPRING = 300.0, 0.1, 100.0


def lugre(law, slip, z):
    level = law.mu_k + (law.mu_s - law.mu_k) * np.exp(-((slip / law.vs) ** 2))
    rate = slip - law.s0 * np.hypot(slip, law.e) * z / level
    return rate, law.s0 * z + law.s1 * rate + law.s2 * slip


def dahl(law, slip, z):
    return slip - law.s0 * np.hypot(slip, law.e) * z / law.mu_k, law.s0 * z


def jenkins(law, slip, z):
    stiffness = law.kt / law.mu_k
    along, width = stiffness * slip * z, stiffness * law.e
    loading = 0.5 * (along + np.hypot(along, width))
    knee = (abs(z) ** (law.exponent - 2) + 1e-4) / (1 + 1e-4)
    return stiffness * slip - loading * knee * z, law.mu_k * z


def bouc_wen(law, slip, z):
    limit = (law.A / (law.b + law.c)) ** (1 / law.exponent)
    turning = law.b * np.hypot(slip * z, law.e * limit) + law.c * slip * z
    return law.A * slip - abs(z) ** (law.exponent - 2) * z * turning, z


LAWS = {
    "LuGre": (sf.LuGre(mu_s=0.5, vs=0.2, s0=1e5), lugre),
    "Jenkins": (sf.Jenkins(kt=1e5), jenkins),
    "Dahl": (sf.Dahl(s0=1e5), dahl),
    "Bouc-Wen": (sf.BoucWen(A=1e5, b=2e5, c=2e5), bouc_wen),
}


def rubbing(law):
    """A mass that rubs on the ground at up to 78 m/s, back and forth."""
    return belt(law, 0.0, DAMPING, stiffness=SPRING, force=FORCE, f=1.0)


@pytest.fixture(scope="module", params=["LuGre", pytest.param("Jenkins", marks=pytest.mark.long)])
def law(request):
    return LAWS[request.param]


def by_scipy(law, duration):
    given, bristle = law

    def rates(time, state):
        rate, friction = bristle(given, -state[1], state[2])
        pull = FORCE * np.cos(2 * np.pi * time) - DAMPING * state[1] - SPRING * state[0]
        return [state[1], pull + friction, rate]

    return solve_ivp(rates, (0, duration), np.zeros(3), method="Radau", rtol=1e-10, atol=1e-13)


def assert_same_as_radau(law, duration):
    motion = sf.simulate(rubbing(law[0]), periods=1)
    other = by_scipy(law, duration)
    assert np.abs(other.y[1]).max() > 50
    scales = motion.model.state_scales()
    assert np.abs((motion.at(duration) - other.y[:, -1]) / scales).max() < 1e-9
    return motion


def test_friction_with_stiff_bristles_in_large_reversing_slip(law):
    motion = assert_same_as_radau(law, 0.4)
    assert motion.stopped is None
    assert "1 of 1 forcing periods took implicit steps" in motion.settlement.message
    (check,) = motion.checked.checks
    assert check.method == "implicit steps of another order"
    assert check.agrees
    assert check.difference < 1e-10


@pytest.mark.long
@pytest.mark.parametrize("name", LAWS)
def test_every_law_over_a_whole_period(name):
    assert_same_as_radau(LAWS[name], 1.0)


# -- steps -----------------------------------------------------------------------------------------


def stiff(period, states, **parameters):
    model = sf.System(parameters=parameters, states=states, forcing={"period": period})
    return StiffFallback(flow_of(model), flow_of(model).constants(model.vector))


@pytest.fixture(scope="module")
def follower():
    """What follows cos(W t) at once, and from its start exactly."""
    return stiff("2*pi/W", {"y": "k*(cos(W*t) - y) - W*sin(W*t)"}, k=1e6, W=2 * np.pi)


def test_it_ends_where_a_limit_is_met(follower):
    def watch(phases, states):
        return np.stack([states[:, 0] + 2.0, states[:, 0] - 0.5], axis=1)

    motion = implicit_trajectory(follower.field, np.array([1.0]), 0.0, 1.0, watch=watch)
    assert (motion.end, motion.limit) == (StepsEnd.MET, 1)
    assert motion.phase == pytest.approx(1 / 6, abs=1e-11)
    assert motion.polynomials.times[-1] == motion.phase


def test_beside_a_fast_decay_scales_are_those_of_the_motion():
    model = sf.System(
        parameters={"W": 1.0, "K": 1e8},
        states={"x": "v", "v": "cos(W*t) - z - 0.2*v - 0.2*x^3", "z": "K*(x + 0.1*x^2 - z)"},
        forcing={"period": "2*pi/W"},
    )
    assert sf.simulate(model, 60).settlement.period == 1


def test_steps_end_where_they_gain_hardly_anything():
    """Friction stops a block in the plane, whose direction of slip then has no meaning."""
    slowed = {name: f"-W*{name}/sqrt(u^2 + v^2)" for name in "uv"}
    motion = implicit_trajectory(stiff("1/W", slowed, W=1.0).field, np.array([0.3, 0.4]), 0.0, 1.0)
    assert (motion.end, motion.phase) == (StepsEnd.MANY, pytest.approx(0.5, rel=1e-2))
    assert len(motion.polynomials.times) < IMPLICIT.max_steps / 10


def test_decay_onto_the_motion_is_resolved(follower):
    motion = implicit_trajectory(follower.field, np.array([2.0]), 0.0, 1.0)
    phase = 3e-6
    exact = np.cos(2 * np.pi * phase) + np.exp(-1e6 * phase)
    assert motion.polynomials(np.array([phase]))[0, 0] == pytest.approx(exact, abs=1e-10)
    assert motion.state[0] == pytest.approx(1.0, abs=1e-11)


def test_the_interval_of_time_is_not_that_of_a_decay():
    states = {"x": "y", "y": "-x - 0.05*y", "z": "-3000*(z - x)"}
    model = sf.System(parameters={"a": 1.0}, states=states)
    paced, _ = with_duration(model, np.array([1.0, 0.0, 0.0]), None)
    assert 1 <= paced.values["duration"] <= 12  # the slow rate is 1/s
