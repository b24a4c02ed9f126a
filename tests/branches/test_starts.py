"""Responses that begin where a user says: near a state, or at what a motion settles on."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from slipfold.flow.scales import measured
from slipfold.models.registry import model_named

FOLDS = [1.269601955546, 1.115700251771]
"""Of Duffing's oscillator at the built-in values, from its upper branch on."""

UPPER, LOWER = {"q": 1.33, "v": 2.54}, {"q": -0.45}
"""States near its two stable responses at W = 1.2."""


def values(branch, kind):
    return [item.value for item in branch.special if item.type == kind]


def test_where_nothing_holds_the_quiet_state_the_response_is_what_a_motion_settles_on(monkeypatch):
    def refused(*_):
        pytest.fail("the forcing need not be raised")

    monkeypatch.setattr("slipfold.orbits.first_orbits.continue_to", refused)
    model = model_named("vanderpol", w=1.0)
    settled = sf.simulate(model, 60).states[-1]
    branch = sf.response(model, "w", (1.0, 1.01)).branches[0]
    assert branch.states[0] == pytest.approx(settled, abs=1e-6)
    assert branch.stable[0]


def test_what_a_motion_does_not_settle_on_is_followed_from_the_quiet_state():
    model = model_named("vanderpol", w=1.2)  # beyond its torus bifurcation at 1.0867
    (branch,) = sf.response(model, "w", (1.2, 1.0)).branches
    assert values(branch, "NS") == pytest.approx([1.086728948108], abs=1e-10)
    assert branch.stable[-1]
    assert not branch.stable[0]


@pytest.mark.parametrize("start", [UPPER, LOWER])
def test_coexisting_responses_are_reached_by_their_states(start):
    diagram = sf.response(model_named("duffing"), "W", (1.2, 1.25), start=start)
    (branch,) = diagram.branches
    expected = sf.periodic_orbit(model_named("duffing", W=1.2), state=start)
    assert branch.states[0] == pytest.approx(expected.state, abs=1e-9)
    assert expected.stable


def test_a_tank_is_followed_though_an_empty_one_has_no_derivative():
    tank = sf.System(
        parameters={"a": 1, "F": 0.3, "W": 1}, forcing={"period": "2*pi/W"},
        states={"h": "a - sqrt(h) + F*cos(W*t)"},
    )  # fmt: skip
    with pytest.raises(sf.InputError, match="give a start near one, or start the span elsewhere"):
        sf.response(tank, "F", (0.3, 0.9))
    (branch,) = sf.response(tank, "F", (0.3, 0.9), start={"h": 1}).branches
    assert branch.parameter[-1] == 0.9
    orbit = sf.periodic_orbit(tank, state=sf.simulate(tank, 40, {"h": 1}).states[-1])
    assert orbit.state == pytest.approx(branch.states[0], abs=1e-9)
    assert np.sqrt(orbit.sample(64)[1]).mean() == pytest.approx(1, abs=1e-9)  # inflow is outflow


def test_a_trajectory_that_runs_away_is_not_the_size_of_a_motion():
    soft, weak = (
        sf.System(
            parameters={"F": force}, forcing={"period": "2*pi"},
            states={"x": "v", "v": f"-0.2*v - x + {bent} + F*cos(t)"},
        )
        for force, bent in ((0.1, "2*x^3/(1 + x^2)"), (1, "0.3 - 2*x*tanh(10*x)"))
    )  # fmt: skip
    sizes = (
        measured(model, start=at) for model, at in ((soft, np.array([2.0, 0.0])), (weak, None))
    )
    assert max(item.state_scales().max() for item in sizes) <= 1
    orbit = sf.periodic_orbit(soft, state=[2, 0])
    end = solve_ivp(
        lambda t, y: [y[1], np.cos(t) / 10 - y[1] / 5 - y[0] + 2 * y[0] ** 3 / (1 + y[0] ** 2)],
        (0, 2 * np.pi), orbit.state, rtol=1e-10, atol=1e-12,
    ).y[:, -1]  # fmt: skip
    assert end == pytest.approx(orbit.state, abs=1e-8)
    assert (orbit.model.state_scales() == measured(soft).state_scales()).all()


def test_a_branch_is_followed_in_both_directions_from_inside_the_span():
    diagram = sf.response(model_named("duffing"), "W", (0.5, 2.0), start={"W": 1.2, **UPPER})
    (branch,) = diagram.branches
    assert values(branch, "LP") == pytest.approx(FOLDS, abs=1e-10)
    assert branch.parameter[[0, -1]] == pytest.approx([0.5, 2.0])
    assert branch.started.reason == "reached the end of the span at W = 0.5"


def test_a_state_near_an_orbit_of_period_two_finds_it():
    near = sf.periodic_orbit(sf.SlidingOscillator(f=12.5, Nd=0.3), period=2).state * 1.001
    names = ("x", "y", "vx", "vy")
    start = {"Nd": 0.3, **dict(zip(names, near.tolist(), strict=True))}
    (branch,) = sf.response(sf.SlidingOscillator(f=12.5), "Nd", (0.2, 0.4), start=start).branches
    assert branch.period == 2


@pytest.mark.parametrize("settled", [True, False])
def test_a_cycle_is_followed(settled):
    start = {"mu": 1.0, "x": 2.0}
    model = model_named("vanderpol-free")
    diagram = sf.response(model, "mu", (0.5, 2), start=start, settled=settled)
    (branch,) = diagram.branches
    assert branch.kind == "periodic"
    at = int(np.abs(branch.parameter - 1).argmin())
    assert branch.durations[at] == pytest.approx(6.663286859323, rel=1e-10)


@pytest.mark.parametrize("side", [-1, 1])
def test_one_of_several_equilibria_is_followed(side):
    start = {"x": 7.0 * side, "y": 7.0 * side, "z": 19.0}
    (branch,) = sf.response(model_named("lorenz"), "rho", (20, 2), start=start).branches
    exact = side * np.sqrt(8 / 3 * (branch.parameter - 1))
    assert branch.states[:, 0] == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_start_of_a_forced_model_says_which_well(side):
    wells = sf.System(
        parameters={"F": 0.05},
        states={"q": {"rate": "v", "start": side}, "v": "F*cos(1.2*t) + q - q^3 - 0.2*v"},
        forcing={"period": "2*pi/1.2", "amplitude": "F"},
    )
    diagram = sf.response(wells, "F", (0.05, 0.1))
    settled = sf.response(wells, "F", (0.05, 0.1), settled=True)
    for branch in (diagram.branches[0], settled.branches[0]):
        assert np.sign(branch.states[:, 0]) == pytest.approx(side)
    assert np.sign(sf.simulate(wells, 300).states[-1, 0]) == side
    assert np.sign(sf.periodic_orbit(wells, state={"v": 0.0}).state[0]) == side


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"start": {"z": 1}}, "no state 'z'"),
        ({"start": {"Nd": 0.6}}, "Nd = 0.6 is outside the span from 0 to 0.5"),
        ({"start": {"x": "wide"}}, "x"),
        ({"start": {"Nd": 0.1}, "settled": True}, "does not settle on what could be followed"),
    ],
)
def test_starts_that_cannot_be_used_are_refused(arguments, words):
    with pytest.raises(sf.InputError, match=words):
        sf.response(sf.SlidingOscillator(f=12.5), "Nd", (0, 0.5), **arguments)


GIVEN = {"parameters": {"p": 1.0}, "forcing": {"period": "2*pi"}}
FREE = {
    "a position": ({"x": "v", "v": "p - 0.1*v + cos(t)"}, "no rate depends on x, so"),
    "two positions": (
        {"x": "v", "y": "w", "v": "y - x - 0.1*v + p*cos(t)", "w": "x - y"},
        "no rate depends on x + y, so",
    ),
    "a sum": (
        {"s": "0.5*r - 2*p*s*i", "i": "2*p*s*i - i + cos(t)/9", "r": "i - cos(t)/9 - 0.5*r"},
        "s + i + r never changes, so",
    ),
}


def test_states_that_something_determines_are_not_named():
    rates = {"x": "v", "v": "-1e9*x - p*v", "T": "cos(t) - 1e-4*tanh(T/1e-3)"}
    assert sf.System(name="held", states=rates, **GIVEN).advice == ""


@pytest.mark.parametrize("case", FREE)
def test_states_that_nothing_determines_are_named(case):
    rates, reason = FREE[case]
    model = sf.System(name="free", states=rates, **GIVEN)
    with pytest.raises(sf.InputError, match=reason.replace("+", ".")):
        sf.response(model, vary="p", span=(0.5, 2))
