"""The systems that come as files: values and sources in shared/reference/textbook.md."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import slipfold as sf
from slipfold.errors import InputError
from slipfold.models import built_in_models, model_named
from slipfold.models.evaluation import evaluation_of
from slipfold.models.registry import built_in_text

SYSTEMS = [name for name in built_in_models() if isinstance(model_named(name), sf.System)]


def only(diagram, kind):
    return [point for _, point in diagram.special if point.type == kind]


@pytest.mark.parametrize("name", SYSTEMS)
def test_files_are_complete(name):
    model = model_named(name)
    assert model.name == name
    assert model.title
    assert all(parameter.doc for parameter in model.parameters)
    assert all(state.label.startswith("$") for state in model.states)
    assert all(output.doc for output in model.outputs())
    text = built_in_text(name)
    assert text.startswith("# ")
    assert sf.System.from_toml(text) == model
    assert sf.System(model.to_toml()) == model


def test_they_are_found_by_name():
    assert {"duffing", "mathieu", "vanderpol", "lorenz"} <= set(SYSTEMS)
    assert model_named("duffing", W=1.1).W == 1.1
    with pytest.raises(InputError, match=r"no model 'dufing'; did you mean duffing\?"):
        model_named("dufing")
    with pytest.raises(InputError, match="no model 'dufing'"):
        built_in_text("dufing")
    with pytest.raises(InputError, match="sliding is written in Python"):
        built_in_text("sliding")


def test_folds_of_duffings_oscillator():
    diagram = sf.response(model_named("duffing"), "W", (0.8, 1.6))
    high, low = only(diagram, "LP")
    assert high.value == pytest.approx(1.269601955546, abs=1e-9)
    assert high.state == pytest.approx([-0.140434285344, 3.413427245844], abs=1e-9)
    assert np.abs(high.multipliers).min() == pytest.approx(0.780792, abs=1e-6)
    assert low.value == pytest.approx(1.115700251771, abs=1e-9)
    assert low.state == pytest.approx([-1.020826011254, 0.413916481576], abs=1e-9)
    # The list of values has 2.871529 and 1.085018, samples next to the true extrema.
    assert high.orbit.extrema.of("q")[1] == pytest.approx(2.8715748, abs=1e-7)
    assert low.orbit.extrema.of("q")[1] == pytest.approx(1.0850358, abs=1e-7)


@pytest.mark.parametrize(("w", "h"), [(2.0, 0.0400008749895), (1.9, 0.2014699309238)])
def test_doublings_of_mathieus_equation(w, h):
    diagram = sf.response(model_named("mathieu", w=w), "h", (0, 1.5 * h))
    assert only(diagram, "PD")[0].value == pytest.approx(h, abs=1e-10)


def test_torus_of_van_der_pols_oscillator():
    diagram = sf.response(model_named("vanderpol"), "w", (1.0, 1.2))
    (item,) = only(diagram, "NS")
    assert item.value == pytest.approx(1.086728948108, abs=1e-10)
    assert item.critical_multiplier == pytest.approx(0.915559 + 0.402185j, abs=1e-6)


def test_cycle_of_stuart_and_landau():
    model = model_named("stuart-landau", r=0.5, w=2.0)
    motion = sf.simulate(model, 60, model.start)
    assert np.hypot(*motion.strobe[-1]) == pytest.approx(np.sqrt(0.5), rel=1e-10)
    # Radius of the way there, in closed form: 1/r^2 falls to 1/r0 as exp(-2 r0 t).
    start = 0.1
    time = np.arange(len(motion.strobe))
    exact = (2 + (start**-2 - 2) * np.exp(-2 * 0.5 * time)) ** -0.5
    assert np.hypot(*motion.strobe.T) == pytest.approx(exact, rel=1e-10)
    angle = np.unwrap(np.arctan2(*motion.strobe.T[::-1]))
    assert angle == pytest.approx(2.0 * time, abs=1e-9)


def test_cycle_of_the_free_van_der_pol_oscillator():
    model = model_named("vanderpol-free")

    def rates(t, state):
        return evaluation_of(model).rates(model, state)

    def turning(t, state):
        return state[1]

    turning.direction = -1
    run = solve_ivp(rates, (0, 100), [2, 0], "DOP853", rtol=1e-11, atol=1e-12, events=turning)
    assert np.diff(run.t_events[0])[-1] == pytest.approx(6.663286859323, abs=1e-8)
    assert run.y_events[0][-1, 0] == pytest.approx(2.008619860875, abs=1e-9)


def growth(model, point):
    """Largest real part of the complex eigenvalues at an equilibrium."""
    values = np.linalg.eigvals(evaluation_of(model).jacobian(model, point))
    return values[values.imag != 0].real.max()


def crossing(model, vary, low, high, point=lambda model: np.zeros(len(model.states))):
    """Value of the parameter at which an equilibrium changes stability."""

    def margin(value):
        changed = model.replace(**{vary: value})
        assert evaluation_of(changed).rates(changed, point(changed)) == pytest.approx(0, abs=1e-12)
        return growth(changed, point(changed))

    return brentq(margin, low, high, xtol=1e-13)


def routh_hurwitz_of_freire(b=0.5, g=-0.6, r=0.6):
    """Hopf point in n: with u = (b + n)/r and k = b + g, (u + k) (1 + u k - b^2/r) = u."""
    k = b + g
    u = np.roots([k, k**2 - b**2 / r, k * (1 - b**2 / r)])
    return r * u[np.abs(u).argmin()] - b


def steady_sliding(model):
    friction = model.md * (1 + (model.r - 1) * np.exp(-model.vd / model.v0))
    return np.array([friction, 0.0])


def convection(model):
    side = np.sqrt(model.beta * (model.rho - 1))
    return np.array([side, side, model.rho - 1])


@pytest.mark.parametrize(
    ("name", "vary", "span", "value", "point"),
    [
        ("lure", "a", (0.5, 1.5), 1.0, None),
        # The list of values has -0.589336512; this is the root of the Routh-Hurwitz condition.
        ("freire", "n", (-0.595, -0.585), routh_hurwitz_of_freire(), None),
        ("stribeck", "vd", (1.0, 1.5), 1.151292546497, steady_sliding),
        ("stuart-landau", "r", (-0.3, 0.4), 0.0, None),
        ("vanderpol-free", "mu", (-0.3, 0.4), 0.0, None),
        ("squeal", "mu", (0.7, 0.8), (1 + 2 * 0.05**2) * 0.75, None),
        ("lorenz", "rho", (20, 28), 10 * (13 + 8 / 3) / (9 - 8 / 3), convection),
    ],
)
def test_stability_of_equilibria(name, vary, span, value, point):
    model = model_named(name)
    found = crossing(model, vary, *span, **({} if point is None else {"point": point}))
    assert found == pytest.approx(value, abs=1e-9)


def test_equilibria_of_roessler():
    model = model_named("roessler")
    y = (-model.c + np.sqrt(model.c**2 - 4 * model.a * model.b)) / (2 * model.a)
    rates = evaluation_of(model).rates(model, np.array([-model.a * y, y, -y]))
    assert rates == pytest.approx(np.zeros(3), abs=1e-12)


def test_slip_ends_where_the_mass_sticks():
    model = model_named("stribeck", vd=0.5)
    motion = sf.simulate(model, 100, {"x": 1.5})
    assert motion.stopped.kind == "stick"
    assert motion.stopped.reason.startswith("stick: the relative speed fell to 0.001")
