"""What a wrong integrator, a wrong orbit or a wrong multiplier leads to does not agree."""

from dataclasses import replace

import heyoka as hy
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from helpers.dry_friction import belt
from slipfold import Jenkins, Settings, SlidingOscillator, System, periodic_orbit, response
from slipfold.flow.settlement import Settlement
from slipfold.flow.simulate import simulate
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import evaluation_of
from slipfold.models.registry import model_named
from slipfold.results.checks import orbit_difference as checks
from slipfold.results.checks.checked import Check, Checked
from slipfold.results.checks.orbit_difference import (
    Difference,
    orbit_difference,
    orbit_differences,
    pieces_of,
    retraced_difference,
)
from slipfold.results.checks.trajectories import check_trajectory

STEEP = """
name = "steep"
title = "oscillator with steep friction"
[parameters]
eps = {{ value = 0.05, above = 0, doc = "width" }}
w = {{ value = 0.8, above = 0, doc = "frequency" }}
[states]
x = {{ rate = "v", doc = "displacement" }}
v = {{ rate = "cos(w*t) - x - 0.5*{law}", doc = "velocity" }}
[forcing]
period = "2*pi/w"
"""
PERIOD = 2 * np.pi / 0.8
X, V, EPS = hy.expression("x"), hy.expression("v"), hy.par[0]
LAWS = {
    "tanh(v/eps)": hy.tanh(V / EPS),
    "erf(v/eps)": hy.erf(V / EPS),
    "2/(1 + exp(-v/eps)) - 1": 2.0 * hy.sigmoid(V / EPS) - 1.0,
    "exp(-(x/eps)^2)": hy.exp(-((X / EPS) ** 2.0)),
}


def motion(model, states):
    return Trajectory(model, states, Settlement(False, None, np.nan, None, "not settled"))


def stepped_over(law, eps, periods):
    """States as Taylor's method alone has them: it sees nothing that is flat where it is."""
    force = hy.cos(0.8 * hy.time) - X - 0.5 * LAWS[law]
    integrator = hy.taylor_adaptive([(X, V), (V, force)], [0.0, 0.0], pars=[eps], tol=1e-13)
    return integrator.propagate_grid(PERIOD * np.arange(periods + 1.0))[-1]


@pytest.mark.parametrize(
    ("law", "eps"),
    [("tanh(v/eps)", 0.05), ("erf(v/eps)", 0.1), ("exp(-(x/eps)^2)", 0.2)]
    + [(law, eps) for law in ("tanh(v/eps)", "erf(v/eps)") for eps in (0.01, 1e-4, 1e-5)]
    + [("2/(1 + exp(-v/eps)) - 1", 0.01)],
)
def test_steps_over_steep_functions_are_found(law, eps):
    model = System.from_toml(STEEP.format(law=law)).replace(eps=eps)
    wrong = check_trajectory(motion(model, stepped_over(law, eps, 60)))
    assert not wrong.agree
    assert max(check.difference for check in wrong.disagreeing) > 1e-3
    assert "does not agree" in str(wrong)
    assert check_trajectory(simulate(model, 60)).agree


def test_a_coarse_integration_is_found():
    model = SlidingOscillator(f=12.5, Nd=0.05)
    right = simulate(model, 20)
    assert check_trajectory(right).agree

    def rates(time, state):
        return evaluation_of(model).rates(model, np.asarray(state), (time * 12.5) % 1)

    coarse = [np.zeros(4)]
    for index in range(20):
        span = (index / 12.5, (index + 1) / 12.5)
        coarse.append(solve_ivp(rates, span, coarse[-1], rtol=1e-4, atol=1e-6).y[:, -1])
    found = check_trajectory(motion(model, np.array(coarse)))
    assert not found.agree
    assert 1e-7 < found.disagreeing[0].difference < 0.1


@pytest.fixture(scope="module", params=["forced", "cycle"])
def orbit(request):
    if request.param == "forced":
        return periodic_orbit(SlidingOscillator(f=12.5, Nd=0.05))
    return periodic_orbit(model_named("vanderpol-free"))


def difference(orbit):
    return orbit_difference(orbit, pieces_of(orbit))


def test_what_only_coarse_pieces_miss_is_no_difference(orbit, monkeypatch):
    (right,) = checks._differences([orbit], [pieces_of(orbit)], np.zeros(len(orbit.state)))
    answers = iter([[right._replace(states=Difference(1e-6))], [right]])
    monkeypatch.setattr(checks, "_differences", lambda *_: next(answers))
    assert difference(orbit).excess < 1


def test_an_orbit_beside_the_right_one_does_not(orbit):
    scales = orbit.model.state_scales()
    beside = replace(orbit, nodes=orbit.nodes + 1e-6 * scales * np.arange(1, len(scales) + 1))
    # Newton's step leads back, but along a cycle's motion, which is a phase.
    assert 10 < difference(beside).excess < 1e4
    assert retraced_difference(beside).value > 1e-8


def test_a_stiff_orbit_beside_the_right_one_does_not():
    # The state of the contact follows the slip at once; of the others eight digits are checked.
    model = belt(Jenkins(kt=3e4), 0.0, 0.1, stiffness=100.0, force=30, f=1.0)
    right, scales = periodic_orbit(model), model.state_scales()
    assert retraced_difference(right).excess < 1
    found = retraced_difference(replace(right, nodes=right.nodes + 1e-7 * scales * [1, 0, 0]))
    assert (found.method, found.allowed, found.excess > 1) == ("implicit steps", 1e-8, True)


def test_wrong_multipliers_do_not(orbit):
    wrong = orbit.multipliers.copy()
    wrong[-1] += 1e-6
    found = difference(replace(orbit, multipliers=wrong))
    size = max(1.0, float(np.abs(wrong).max()))
    assert found.value == pytest.approx(1e-6 / size, rel=1e-3)
    assert found.value > found.allowed


def test_orbits_compared_together_differ_as_each_alone_does(orbit):
    rows = np.arange(1, 1 + len(orbit.state)) * orbit.model.state_scales()
    nodes = [orbit.nodes, orbit.nodes + 1e-6 * rows, orbit.nodes * np.nan, orbit.nodes + 1e200]
    others = [replace(orbit, nodes=own) for own in [*nodes, orbit.sample(16)[1]]]
    pieces = [pieces_of(orbit) + 8 * i for i in range(len(others))]
    for known in (others, others[:2] + others[4:]):
        own = [pieces[others.index(item)] for item in known]
        together = orbit_differences(known, own)
        for item, count, found in zip(known, own, together, strict=True):
            alone = orbit_difference(item, count)
            assert (found.value, found.what) == (pytest.approx(alone.value, 1e-6), alone.what) or (
                max(found.value, alone.value) < 1e-11
            )
            assert (found.excess > 1) == (alone.excess > 1)


def test_a_wrong_multiplier_at_a_fold_does_not():
    diagram = response(model_named("duffing"), vary="W", span=(1.0, 1.6))
    fold = next(item.orbit for branch in diagram.branches for item in branch.special)
    assert difference(fold).excess < 1
    wrong = fold.multipliers * (1 + 1e-6)
    assert difference(replace(fold, multipliers=wrong)).excess > 10


def test_a_bubble_that_collapses_eight_times_agrees_on_short_pieces():
    # Rayleigh and Plesset: 5 um in water at 300 kHz. By SciPy's DOP853 it closes within 2e-9, and
    # its multiplier is -4957.93842.
    inside = "(p + 2*s/R0)*(R0/R)^4.2 - 2*s/R - 0.004*U/R"
    rate = f"(({inside} - p + Pa*sin(2*pi*f*t))/998 - 1.5*U^2)/R"
    model = System(
        parameters={"Pa": 1.2e5, "f": 3e5, "R0": 5e-6, "p": 101325, "s": 0.0725},
        states={"R": {"rate": "U", "scale": 5e-6, "start": 5e-6}, "U": {"rate": rate, "scale": 10}},
        forcing={"period": "1/f"},
    )
    orbit = periodic_orbit(model, 8, state={"R": 1.05180804e-5, "U": -1.08966315})
    assert orbit.multipliers.real.min() == pytest.approx(-4957.93842, rel=1e-7)
    assert difference(orbit).excess < 1
    assert difference(replace(orbit, nodes=orbit.nodes * (1 + 1e-5))).excess > 10


def test_a_wrong_duration_does_not():
    cycle = periodic_orbit(model_named("vanderpol-free"))
    longer = cycle.model.replace(duration=cycle.duration * (1 + 1e-6))
    assert 1e-7 < difference(replace(cycle, model=longer)).value < 1e-5


@pytest.fixture(scope="module")
def beside_homoclinic():
    """Folds of Chua's circuit (AUTO-07p's demo chu) on the way to a homoclinic orbit."""
    model = System(
        name="Chua",
        parameters={"alpha": 6.5, "beta": 14.3, "K": 10, "a0": -1 / 7, "a1": 2 / 7},
        formulas={
            "up": "2*(x + 1)*atan(K*(x + 1))/pi",
            "down": "2*(x - 1)*atan(K*(x - 1))/pi",
            "h": "a1*x + (a0 - a1)*(up - down)/2",
        },
        states={
            "x": {"rate": "alpha*(y - h)", "start": 1.5},
            "y": "x - y + z",
            "z": {"rate": "-beta*y", "start": -1.5},
        },
    )
    diagram = response(model, vary="alpha", span=(6.5, 16), settings=Settings(largest_period=1))
    folds = [point.orbit for point in diagram.branches[1].special if point.type == "LP"]
    assert len(folds) >= 6
    return folds


def test_sensitive_multipliers_agree_as_far_as_they_can_be_known(beside_homoclinic):
    first = [difference(fold) for fold in beside_homoclinic[:3]]
    assert all(item.excess <= 1 for item in first)
    assert first[0].allowed < 1e-6


@pytest.mark.parametrize(("index", "error"), [(0, 1e-5), (0, 0.01), (2, 0.1)])
def test_wrong_states_and_critical_multipliers_do_not(beside_homoclinic, index, error):
    # The first three folds: which method takes the branch on from there is rounding.
    fold = beside_homoclinic[index]
    nodes = fold.nodes * (1 + 1e-6 * np.arange(1, 4))
    assert difference(replace(fold, nodes=nodes)).excess > 1
    critical = np.argsort(np.abs(fold.multipliers - 1))[1]
    wrong = fold.multipliers.copy()
    wrong[critical] += error
    found = difference(replace(fold, multipliers=wrong))
    assert found.excess > 1
    assert found.what == "multipliers"
    assert found.unknown == 0


@pytest.mark.parametrize(
    ("value", "allowed", "agrees"), [(2e-3, 0.1, True), (0.2, 0.1, False), (0.9, 100.0, False)]
)
def test_multipliers_that_cannot_be_known_leave_the_states(
    orbit, monkeypatch, value, allowed, agrees
):
    def tried(orbits, pieces, free):
        multipliers = Difference(value, allowed, what="multipliers")
        return [checks._OrbitComparison(Difference(1e-13), multipliers)]

    monkeypatch.setattr(checks, "_differences", tried)
    found = difference(orbit)
    check = Check("LP", "collocation", found.value, found.allowed, found.what, found.unknown)
    assert check.agrees == agrees
    assert found.unknown == (value if agrees else 0)
    text = str(Checked((check,)))
    assert ("multipliers of 1 are known to 2e-03 only" in text) == agrees
    assert Checked.from_json(Checked((check,)).to_json()) == Checked((check,))


def test_sensitivities_of_eigenvalues_are_those_of_differences():
    rng = np.random.default_rng(3)
    factors = rng.normal(size=(4, 3, 3)) + 2 * np.eye(3)
    # Beside a longer product.
    (values, _), (moved, _) = checks._sensitive_eigenvalues([factors, [*factors, *factors]])
    for _ in range(20):
        change = rng.normal(size=factors.shape)
        change *= (
            1e-7
            * np.linalg.norm(factors, 2, axis=(1, 2))[:, None, None]
            / np.linalg.norm(change, 2, axis=(1, 2))[:, None, None]
        )
        others = checks._sensitive_eigenvalues([factors + change])[0][0]
        apart = np.abs(values[:, None] - others).min(axis=1)
        assert (apart <= 1.001e-7 * moved).all()
        assert (apart >= 1e-10 * moved).any()
